#pragma once

#include <string>
#include <vector>

#include "evaluation/sensor_fit/sensor_fit.h"
#include "evaluation/sensor_fit/sensor_parameters.h"

namespace saccade {

/// What the recordings lack where a parameter is not identifiable.
[[nodiscard]] std::string missing(Needs needs);

/// Adds the parameters that need no emulator to `fit`: hot pixels, bus and tick. `hot` has the hot pixels of each recording,
/// `hot_pixels` is the number of different ones.
void fit_counts(const std::vector<SensorRecording>& recordings,
                const std::vector<SensorRecording::HotPixels>& hot, std::size_t hot_pixels, SensorFit& fit);

/// Adds to the rate of hot pixels what the refractory period of fit.config takes of it.
void correct_hot_rate(SensorFit& fit);

}  // namespace saccade
