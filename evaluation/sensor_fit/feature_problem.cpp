#include "evaluation/sensor_fit/feature_problem.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>
#include <future>
#include <limits>

#include "core/error.h"
#include "core/random.h"
#include "evaluation/sensor_fit/event_features.h"

namespace saccade {
namespace {

constexpr double difference = 0.04;       ///< of a parameter's logarithm, for derivatives
constexpr double stimulus_error = 0.01;   ///< relative, of every feature
constexpr double smallest_error = 0.003;  ///< absolute: of shares and logarithms of times
constexpr double large_residual = 5.0;    ///< residuals grow with their logarithm from there on
constexpr std::uint64_t restarts = 6, draws_per_restart = 12;
constexpr double restart_deviation = 0.4;     ///< of other starts of the search, in deviations of the prior
constexpr double good_misfit = 1.25;          ///< deviations, rms: more than chance explains above
constexpr std::size_t emulated_pixels = 512;  ///< at least, of a panel

class FeatureCost final : public ceres::CostFunction {
 public:
  explicit FeatureCost(const FeatureProblem& problem) : problem_(problem) {
    set_num_residuals(static_cast<int>(problem.residual_count()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(problem.free().size()));
  }
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const std::vector<double> logs(blocks[0], blocks[0] + problem_.free().size());
    const Eigen::VectorXd at = problem_.residuals(logs);
    Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) = at;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
          jacobians[0], num_residuals(), static_cast<Eigen::Index>(logs.size())) =
          problem_.derivatives(logs, at);
    }
    return true;
  }

 private:
  const FeatureProblem& problem_;
};

}  // namespace

FeatureProblem::FeatureProblem(const std::vector<SensorRecording>& recordings, const SensorFitConfig& config)
    : recordings_(recordings), base_(config.prior) {
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const SensorRecording& recording = recordings[r];
    std::vector<PixelPlace> places;
    for (std::size_t i = 0; i < recording.places().size(); i += 2) places.push_back(recording.places()[i]);
    const std::size_t repeats =
        (emulated_pixels + places.size() - 1) / std::max<std::size_t>(1, places.size());
    models_.emplace_back(recording, places, repeats, config.seed);
    const PixelTrains trains = recording.trains().half(false);
    const std::vector<Feature> features = features_of(recording.stimulus(), recording.interval(), trains);
    // The emulated pixels vary too.
    const double both =
        1.0 + static_cast<double>(places.size()) / static_cast<double>(models_.back().pixels());
    for (std::size_t f = 0; f < features.size(); ++f) {
      const double value = features[f].value();
      const double deviation = features[f].deviation();
      if (!std::isfinite(value) || !std::isfinite(deviation)) continue;
      const double floor = std::max(smallest_error, stimulus_error * std::abs(value));
      targets_.push_back(
          {r, f, features[f].name, value, std::sqrt(both * deviation * deviation + floor * floor)});
    }
  }
  if (targets_.empty()) throw InputError("recordings", "no events of the stimuli", "recordings with events");
}

EmulatorConfig FeatureProblem::config_of(const std::vector<double>& logs) const {
  EmulatorConfig config = base_;
  for (std::size_t i = 0; i < free_.size(); ++i) {
    if (!free_[i].recording) set_parameter(config, free_[i].key, std::exp(logs[i]));
  }
  return config;
}

std::vector<double> FeatureProblem::contrast_scales(const std::vector<double>& logs) const {
  std::vector<double> scales(recordings_.size(), 1.0);
  for (std::size_t i = 0; i < free_.size(); ++i) {
    if (free_[i].recording) scales[*free_[i].recording] = std::exp(logs[i]);
  }
  return scales;
}

Eigen::VectorXd FeatureProblem::residuals(const std::vector<double>& logs, std::optional<std::size_t> changed,
                                          const Eigen::VectorXd& before) const {
  const EmulatorConfig config = config_of(logs);
  const std::vector<double> scales = contrast_scales(logs);
  Eigen::VectorXd r = changed ? before : Eigen::VectorXd::Zero(static_cast<Eigen::Index>(residual_count()));
  std::vector<std::future<std::vector<Feature>>> features(recordings_.size());
  for (std::size_t i = 0; i < recordings_.size(); ++i) {
    if (changed && !acts_on(free_[*changed], i)) continue;
    features[i] = std::async(std::launch::async, [&, i] {
      return features_of(recordings_[i].stimulus(), recordings_[i].interval(),
                         models_[i].events(config, scales[i]));
    });
  }
  for (std::size_t i = 0; i < recordings_.size(); ++i) {
    if (!features[i].valid()) continue;
    const std::vector<Feature> found = features[i].get();
    for (std::size_t k = 0; k < targets_.size(); ++k) {
      const TargetFeature& t = targets_[k];
      if (t.recording != i) continue;
      const double value = found[t.feature].value();
      const double off = std::isfinite(value) ? (value - t.value) / t.deviation : large_residual;
      r[static_cast<Eigen::Index>(k)] = large_residual * std::asinh(off / large_residual);
    }
  }
  for (std::size_t i = 0; i < free_.size(); ++i) {
    r[static_cast<Eigen::Index>(targets_.size() + i)] = (logs[i] - free_[i].prior) / free_[i].prior_deviation;
  }
  return r;
}

Eigen::MatrixXd FeatureProblem::derivatives(const std::vector<double>& logs,
                                            const Eigen::VectorXd& at) const {
  Eigen::MatrixXd j(static_cast<Eigen::Index>(residual_count()), static_cast<Eigen::Index>(free_.size()));
  for (std::size_t i = 0; i < free_.size(); ++i) {
    std::vector<double> up = logs, down = logs;
    up[i] += difference;
    down[i] -= difference;
    j.col(static_cast<Eigen::Index>(i)) =
        (residuals(up, i, at) - residuals(down, i, at)) / (2.0 * difference);
  }
  return j;
}

double FeatureProblem::misfit(const std::vector<double>& logs) const {
  const Eigen::VectorXd r = residuals(logs).head(static_cast<Eigen::Index>(targets_.size()));
  return std::sqrt(r.squaredNorm() / static_cast<double>(targets_.size()));
}

/// Noise acts on still scenes, what needs a change of light on the others; thresholds act on all.
bool FeatureProblem::acts_on(const FreeParameter& f, std::size_t recording) const {
  if (f.recording) return *f.recording == recording;
  if (f.needs == Needs::contrast) return true;
  return (f.needs == Needs::still) != recordings_[recording].stimulus().moves();
}

std::vector<double> coarse_search(const FeatureProblem& problem, std::vector<double> logs) {
  Eigen::VectorXd at = problem.residuals(logs);
  for (const double step : {1.4, 0.7, 0.35}) {
    for (std::size_t i = 0; i < logs.size(); ++i) {
      for (const double way : {-1.0, 1.0}) {
        for (int k = 0; k < 3; ++k) {  // as long as it gets better
          std::vector<double> other = logs;
          other[i] = std::clamp(logs[i] + way * step, problem.free()[i].low, problem.free()[i].high);
          Eigen::VectorXd there = problem.residuals(other, i, at);
          if (!(there.squaredNorm() < at.squaredNorm())) break;
          at = std::move(there);
          logs = std::move(other);
        }
      }
    }
  }
  return logs;
}

std::vector<double> least_squares(const FeatureProblem& problem, std::vector<double> logs) {
  ceres::Problem solved;
  solved.AddResidualBlock(new FeatureCost(problem), nullptr, logs.data());
  for (std::size_t i = 0; i < logs.size(); ++i) {
    solved.SetParameterLowerBound(logs.data(), static_cast<int>(i), problem.free()[i].low);
    solved.SetParameterUpperBound(logs.data(), static_cast<int>(i), problem.free()[i].high);
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 12;
  options.function_tolerance = 1e-4;
  options.parameter_tolerance = 1e-4;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &solved, &summary);
  return logs;
}

std::vector<double> search_again(const FeatureProblem& problem, std::vector<double> logs,
                                 std::uint64_t seed) {
  const RandomStream random(seed, "sensor_fit");
  double least = problem.residuals(logs).squaredNorm();
  for (std::uint64_t round = 0; round < restarts && problem.misfit(logs) > good_misfit; ++round) {
    std::vector<double> start;
    double least_of_starts = std::numeric_limits<double>::infinity();
    for (std::uint64_t draw = 0; draw < draws_per_restart; ++draw) {
      std::vector<double> other = logs;
      for (std::size_t i = 0; i < other.size(); ++i) {
        const FreeParameter& f = problem.free()[i];
        if (f.needs == Needs::still) continue;  // still scenes alone determine it
        const double away = random.normal(i, round * draws_per_restart + draw);
        other[i] = std::clamp(logs[i] + restart_deviation * f.prior_deviation * away, f.low, f.high);
      }
      const double there = problem.residuals(other).squaredNorm();
      if (there < least_of_starts) {
        least_of_starts = there;
        start = std::move(other);
      }
    }
    start = least_squares(problem, std::move(start));
    const double found = problem.residuals(start).squaredNorm();
    if (found < least) {
      least = found;
      logs = std::move(start);
    }
  }
  return logs;
}

}  // namespace saccade
