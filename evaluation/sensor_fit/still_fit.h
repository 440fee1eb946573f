#pragma once

#include <cstddef>
#include <string>

#include "emulator/emulator_config.h"
#include "evaluation/sensor_fit/sensor_recording.h"

namespace saccade {

/// A quantity with the interval that holds it with a probability of 95 %.
struct StillValue {
  double value = 0.0;
  double low = 0.0, high = 0.0;
  bool identifiable = false;  ///< false: the prior decides
};

/// What the noise of a scene at rest says about a sensor (StillNoise).
struct StillFit {
  std::string recording;
  std::size_t on_events = 0, off_events = 0;
  /// Contrast thresholds / standard deviation of the noise, and their ratio, in which the noise cancels. Their intervals have
  /// `model_error` beside what chance explains.
  StillValue on, off, on_over_off;
  StillValue cutoff_hz;  ///< of the noise, at the light of the recording
  StillValue refractory_s;
  StillValue leak_hz;
  StillValue spread;    ///< relative standard deviation over pixels of threshold / noise
  double misfit = 0.0;  ///< rms of the residuals, in deviations
  std::string limit;    ///< why no threshold is identifiable; empty where one is

  static constexpr double model_error = 0.03;  ///< relative, of a ratio: poles that the low-pass leaves out
};

/// Least squares with Ceres between the numbers of events and of intervals, for each polarity of an event and the next one
/// and each bin of duration, and those of StillNoise with a spread over the pixels. The bandwidth comes from how fast an
/// event of one polarity follows one of the other (the noise returns), the ratios from the rates. All pixels of the sample.
/// `prior`: of bandwidth, refractory period and leak. `recording`: of a still scene, without hot pixels.
[[nodiscard]] StillFit fit_still(const SensorRecording& recording, const EmulatorConfig& prior);

}  // namespace saccade
