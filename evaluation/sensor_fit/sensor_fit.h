#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "emulator/emulator_config.h"
#include "evaluation/sensor_fit/sensor_recording.h"
#include "evaluation/sensor_fit/still_fit.h"

namespace saccade {

/// A parameter after the fit.
struct FittedParameter {
  std::string key;
  double value = 0.0;
  double prior = 0.0;
  double deviation =
      0.0;  ///< relative standard deviation; of a parameter that is not identifiable that of the prior
  bool identifiable = false;  ///< false: `value` is the prior's, or the limit that the recordings set
  std::string decided_by;     ///< recordings and their features; or what is missing
};

/// A quantity of a recording's events beside those of the emulator, at pixels that the fit did not use.
struct ComparedDistribution {
  std::string recording;
  std::string quantity;  ///< "events per pixel and second"
  bool logarithmic = false;
  std::vector<double> recorded, before, after;  ///< sorted; before: of the prior
  double ks_before = 0.0;                       ///< Kolmogorov-Smirnov distance to the recorded ones
  double ks_after = 0.0;
};

struct SensorFit {
  EmulatorConfig config;
  EmulatorConfig prior;
  /// Of each recording, the exponent of dark / light that was fitted; 1 where the contrast is known.
  std::vector<double> contrast_scales;
  std::vector<FittedParameter> parameters;
  std::vector<ComparedDistribution> distributions;
  std::vector<StillFit> still;  ///< of each scene at rest, where SensorFitConfig::still asks for it
  std::size_t features = 0;
  double misfit_before = 0.0;  ///< rms of the features' residuals, in standard deviations
  double misfit_after = 0.0;
};

struct SensorFitConfig {
  EmulatorConfig prior;
  std::uint64_t seed = 1;  ///< of the emulator
  bool still =
      false;  ///< also what the noise of scenes at rest says about thresholds and bandwidth (still_fit.h)
  bool known_light = true;  ///< whether the luminance of scenes at rest was measured
  /// Called with a line of text after each step; it may throw to end the fit.
  std::function<void(const std::string&)> progress;
};

/// Fits the emulator's parameters to recordings of known stimuli, by features of the events (event_features.h) of every
/// other sampled pixel: least squares with Ceres over the logarithms of the parameters, between the recorded features and
/// those of the emulator before the same stimulus, with the prior as further residuals. A feature's weight is that of its
/// jackknife deviation and of 1 % for what the stimulus file leaves out. A parameter whose posterior deviation is above half
/// of its prior one is not identifiable: it keeps the prior's value, and the others are fitted again. Leak and its spread come
/// from the likelihood of intervals (leak_fit.h); a leak that is not identifiable is at most the highest allowed one. Share and rate of hot
/// pixels, the bus and the tick come from counts. The other pixels give the distributions.
/// `still`: the quotient of the thresholds, bandwidth and refractory period of scenes at rest become values of the fit where
/// no recording that moves determines them; the bandwidth only in `known_light`. The thresholds keep the prior's geometric mean.
/// `recordings` are finished; hot pixels are dropped from them. Throws InputError where there is no event to fit.
[[nodiscard]] SensorFit fit_sensor(std::vector<SensorRecording>& recordings, const SensorFitConfig& config);

/// The quantities of the pixels that the fit does not use.
[[nodiscard]] std::vector<ComparedDistribution> compare_distributions(
    const std::vector<SensorRecording>& recordings, const EmulatorConfig& before, const EmulatorConfig& after,
    const std::vector<double>& contrast_scales, std::uint64_t seed);

}  // namespace saccade
