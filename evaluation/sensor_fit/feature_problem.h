#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "emulator/emulator_config.h"
#include "evaluation/sensor_fit/sensor_fit.h"
#include "evaluation/sensor_fit/sensor_model.h"
#include "evaluation/sensor_fit/sensor_parameters.h"
#include "evaluation/sensor_fit/sensor_recording.h"

namespace saccade {

/// A parameter that the search changes: of the emulator, or a recording's contrast.
struct FreeParameter {
  std::string key;
  std::optional<std::size_t> recording;  ///< whose contrast it is
  Needs needs = Needs::contrast;
  double prior = 0.0;  ///< logarithm
  double prior_deviation = 1.0;
  double low = 0.0, high = 0.0;
};

/// A recorded feature and its weight.
struct TargetFeature {
  std::size_t recording = 0;
  std::size_t feature = 0;  ///< of features_of()
  std::string name;
  double value = 0.0;
  double deviation = 1.0;
};

/// How well an emulated sensor's events agree with the recorded ones: features of every other pixel of the recordings
/// against those of emulated pixels there. Parameters are logarithms.
class FeatureProblem {
 public:
  /// Throws InputError where no recording has an event of its stimulus. `recordings` outlive the problem.
  FeatureProblem(const std::vector<SensorRecording>& recordings, const SensorFitConfig& config);

  /// The values of the parameters that are not free.
  void set_base(const EmulatorConfig& base) { base_ = base; }
  void set_free(std::vector<FreeParameter> free) { free_ = std::move(free); }
  [[nodiscard]] const std::vector<FreeParameter>& free() const { return free_; }
  [[nodiscard]] const std::vector<TargetFeature>& targets() const { return targets_; }
  [[nodiscard]] std::size_t residual_count() const { return targets_.size() + free_.size(); }

  [[nodiscard]] EmulatorConfig config_of(const std::vector<double>& logs) const;
  [[nodiscard]] std::vector<double> contrast_scales(const std::vector<double>& logs) const;

  /// Features' residuals in deviations, compressed where large, then those of the prior. `changed`: the one parameter by
  /// which `logs` differs from the logs of the residuals `before`; recordings on which it does not act are not emulated again.
  [[nodiscard]] Eigen::VectorXd residuals(const std::vector<double>& logs,
                                          std::optional<std::size_t> changed = {},
                                          const Eigen::VectorXd& before = {}) const;
  /// Derivatives of the residuals by central differences.
  [[nodiscard]] Eigen::MatrixXd derivatives(const std::vector<double>& logs, const Eigen::VectorXd& at) const;
  /// Rms of the features' residuals.
  [[nodiscard]] double misfit(const std::vector<double>& logs) const;

 private:
  [[nodiscard]] bool acts_on(const FreeParameter& f, std::size_t recording) const;

  const std::vector<SensorRecording>& recordings_;
  EmulatorConfig base_;
  std::vector<SensorModel> models_;
  std::vector<TargetFeature> targets_;
  std::vector<FreeParameter> free_;
};

/// Each parameter in turn by factors, then again by smaller ones: a start near the deepest valley.
[[nodiscard]] std::vector<double> coarse_search(const FeatureProblem& problem, std::vector<double> logs);
/// The nearest least sum of squared residuals.
[[nodiscard]] std::vector<double> least_squares(const FeatureProblem& problem, std::vector<double> logs);
/// While the misfit is larger than chance explains: searches again from the best of some places drawn around what was
/// found, because the search can end in a local minimum (a mismatch and a bandwidth that are both too large).
[[nodiscard]] std::vector<double> search_again(const FeatureProblem& problem, std::vector<double> logs,
                                               std::uint64_t seed);

}  // namespace saccade
