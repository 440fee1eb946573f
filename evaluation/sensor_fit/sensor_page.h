#pragma once

#include <filesystem>
#include <string>

#include "evaluation/sensor_fit/sensor_fit.h"

namespace saccade {

/// Writes `folder`/report.html: the parameters, and the distributions of recorded and emulated events at the pixels that
/// the fit did not use. Throws RunError, where gnuplot is missing too.
void write_sensor_page(const SensorFit& fit, const std::filesystem::path& folder);

/// The fit as JSON: parameters, KS distances, misfit.
[[nodiscard]] std::string sensor_fit_json(const SensorFit& fit);
/// Comments for the head of the fitted preset: how well it agrees, and what the recordings leave open.
[[nodiscard]] std::string sensor_fit_remark(const SensorFit& fit);

}  // namespace saccade
