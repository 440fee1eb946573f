#include "evaluation/sensor_fit/sensor_fit.h"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <future>
#include <limits>
#include <map>
#include <numeric>

#include "core/error.h"
#include "core/random.h"
#include "evaluation/sensor_fit/event_features.h"
#include "evaluation/sensor_fit/leak_fit.h"
#include "evaluation/sensor_fit/sensor_counts.h"
#include "evaluation/sensor_fit/sensor_model.h"
#include "evaluation/sensor_fit/sensor_parameters.h"

namespace saccade::inline v0_1 {
namespace {

constexpr double identifiable_share = 0.5;  ///< posterior deviation against the prior's
constexpr double difference = 0.04;         ///< of a parameter's logarithm, for derivatives
constexpr double stimulus_error = 0.01;     ///< relative, of every feature
constexpr double smallest_error = 0.003;    ///< absolute: of shares and logarithms of times
constexpr double large_residual = 5.0;      ///< residuals grow with their logarithm from there on
constexpr std::uint64_t restarts = 6, draws_per_restart = 12;
constexpr double restart_deviation = 0.4;     ///< of other starts of the search, in deviations of the prior
constexpr double good_misfit = 1.25;          ///< deviations, rms: more than chance explains above
constexpr std::size_t emulated_pixels = 512;  ///< at least, of a panel

/// A parameter that the search changes: of the emulator, or a recording's contrast.
struct Free {
  std::string key;
  std::optional<std::size_t> recording;  ///< whose contrast it is
  Needs needs = Needs::contrast;
  double prior = 0.0;  ///< logarithm
  double prior_deviation = 1.0;
  double low = 0.0, high = 0.0;
};

/// A recorded feature and its weight.
struct Target {
  std::size_t recording = 0;
  std::size_t feature = 0;  ///< of features_of()
  std::string name;
  double value = 0.0;
  double deviation = 1.0;
};

class FeatureProblem {
 public:
  FeatureProblem(const std::vector<SensorRecording>& recordings, const SensorFitConfig& config)
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
    if (targets_.empty())
      throw InputError("recordings", "no events of the stimuli", "recordings with events");
  }

  /// The values of the parameters that are not free.
  void set_base(const EmulatorConfig& base) { base_ = base; }
  void set_free(std::vector<Free> free) { free_ = std::move(free); }
  [[nodiscard]] const std::vector<Free>& free() const { return free_; }
  [[nodiscard]] const std::vector<Target>& targets() const { return targets_; }
  [[nodiscard]] std::size_t residual_count() const { return targets_.size() + free_.size(); }

  [[nodiscard]] EmulatorConfig config_of(const std::vector<double>& logs) const {
    EmulatorConfig config = base_;
    for (std::size_t i = 0; i < free_.size(); ++i) {
      if (!free_[i].recording) set_parameter(config, free_[i].key, std::exp(logs[i]));
    }
    return config;
  }
  [[nodiscard]] std::vector<double> contrast_scales(const std::vector<double>& logs) const {
    std::vector<double> scales(recordings_.size(), 1.0);
    for (std::size_t i = 0; i < free_.size(); ++i) {
      if (free_[i].recording) scales[*free_[i].recording] = std::exp(logs[i]);
    }
    return scales;
  }

  /// Features' residuals in deviations, compressed where large, then those of the prior. `changed`: the one parameter by
  /// which `logs` differs from the logs of the residuals `before`; recordings on which it does not act are not emulated again.
  [[nodiscard]] Eigen::VectorXd residuals(const std::vector<double>& logs,
                                          std::optional<std::size_t> changed = {},
                                          const Eigen::VectorXd& before = {}) const {
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
        const Target& t = targets_[k];
        if (t.recording != i) continue;
        const double value = found[t.feature].value();
        const double off = std::isfinite(value) ? (value - t.value) / t.deviation : large_residual;
        r[static_cast<Eigen::Index>(k)] = large_residual * std::asinh(off / large_residual);
      }
    }
    for (std::size_t i = 0; i < free_.size(); ++i) {
      r[static_cast<Eigen::Index>(targets_.size() + i)] =
          (logs[i] - free_[i].prior) / free_[i].prior_deviation;
    }
    return r;
  }

  /// Derivatives of the residuals by central differences.
  [[nodiscard]] Eigen::MatrixXd derivatives(const std::vector<double>& logs,
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

  [[nodiscard]] double misfit(const std::vector<double>& logs) const {
    const Eigen::VectorXd r = residuals(logs).head(static_cast<Eigen::Index>(targets_.size()));
    return std::sqrt(r.squaredNorm() / static_cast<double>(targets_.size()));
  }

 private:
  /// Noise acts on still scenes, what needs a change of light on the others; thresholds act on all.
  [[nodiscard]] bool acts_on(const Free& f, std::size_t recording) const {
    if (f.recording) return *f.recording == recording;
    if (f.needs == Needs::contrast) return true;
    return (f.needs == Needs::still) != recordings_[recording].stimulus().moves();
  }

  const std::vector<SensorRecording>& recordings_;
  EmulatorConfig base_;
  std::vector<SensorModel> models_;
  std::vector<Target> targets_;
  std::vector<Free> free_;
};

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

/// Each parameter in turn by factors, then again by smaller ones: a start near the deepest valley.
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

std::vector<double> solve(const FeatureProblem& problem, std::vector<double> logs) {
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

/// Searches again from the best of some places drawn around what was found, because the search can end in a local minimum
/// (a mismatch and a bandwidth that are both too large).
std::vector<double> solve_again(const FeatureProblem& problem, std::vector<double> logs, std::uint64_t seed) {
  const RandomStream random(seed, "sensor_fit");
  double least = problem.residuals(logs).squaredNorm();
  for (std::uint64_t round = 0; round < restarts && problem.misfit(logs) > good_misfit; ++round) {
    std::vector<double> start;
    double least_of_starts = std::numeric_limits<double>::infinity();
    for (std::uint64_t draw = 0; draw < draws_per_restart; ++draw) {
      std::vector<double> other = logs;
      for (std::size_t i = 0; i < other.size(); ++i) {
        const Free& f = problem.free()[i];
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
    start = solve(problem, std::move(start));
    const double found = problem.residuals(start).squaredNorm();
    if (found < least) {
      least = found;
      logs = std::move(start);
    }
  }
  return logs;
}

/// Which recordings, and which of their features, hold most of the information about a parameter.
std::string decided_by(const FeatureProblem& problem, const Eigen::MatrixXd& j, std::size_t parameter,
                       const std::vector<SensorRecording>& recordings) {
  struct Part {
    double information = 0.0;
    double best = 0.0;
    std::string feature;
  };
  std::vector<Part> parts(recordings.size());
  double all = 0.0;
  for (std::size_t i = 0; i < problem.targets().size(); ++i) {
    const double d = j(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(parameter));
    Part& part = parts[problem.targets()[i].recording];
    part.information += d * d;
    all += d * d;
    if (d * d > part.best) {
      part.best = d * d;
      part.feature = problem.targets()[i].name;
    }
  }
  std::vector<std::size_t> order(parts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return parts[a].information > parts[b].information; });
  std::string text;
  for (const std::size_t r : order) {
    if (parts[r].information < 0.1 * all || !(all > 0.0)) continue;
    text += fmt::format("{}{} ({:.0f} %: {})", text.empty() ? "" : ", ", recordings[r].name(),
                        100.0 * parts[r].information / all, parts[r].feature);
  }
  return text;
}

bool offers(const SensorRecording& recording, Needs needs) {
  const Stimulus& s = recording.stimulus();
  switch (needs) {
    case Needs::contrast:
      return s.moves() && (s.kind != StimulusKind::disc || s.known_contrast);
    case Needs::change:
      return s.moves();
    case Needs::trigger:
      return s.kind == StimulusKind::panel;
    case Needs::still:
      return !s.moves();
  }
  return false;
}

std::vector<Free> free_parameters(const std::vector<SensorRecording>& recordings, const EmulatorConfig& prior,
                                  const std::vector<std::string>& fixed) {
  std::vector<Free> free;
  for (const SensorParameter& p : sensor_parameters()) {
    const bool offered = std::any_of(recordings.begin(), recordings.end(),
                                     [&](const SensorRecording& r) { return offers(r, p.needs); });
    if (!offered || std::count(fixed.begin(), fixed.end(), p.key) > 0) continue;
    const double value = std::clamp(parameter_of(prior, p.key), 1.05 * p.smallest, 0.95 * p.largest);
    free.push_back({p.key, std::nullopt, p.needs, std::log(value), p.prior_deviation, std::log(p.smallest),
                    std::log(p.largest)});
  }
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const Stimulus& s = recordings[r].stimulus();
    if (s.kind != StimulusKind::disc || s.known_contrast) continue;
    constexpr double deviation = 0.7;
    free.push_back({"contrast of " + recordings[r].name(), r, Needs::contrast, 0.0, deviation, std::log(0.1),
                    std::log(5.0)});
  }
  return free;
}

/// Which recordings the leak events come from.
std::string decided_by(const LeakFit& leak, const std::vector<SensorRecording>& recordings) {
  const double all = std::accumulate(leak.events.begin(), leak.events.end(), 0.0);
  std::vector<std::size_t> order(recordings.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return leak.events[a] > leak.events[b]; });
  std::string text;
  for (const std::size_t r : order) {
    if (leak.events[r] < 0.1 * all || !(all > 0.0)) continue;
    text += fmt::format("{}{} ({:.0f} %: {:.0f} leak events)", text.empty() ? "" : ", ", recordings[r].name(),
                        100.0 * leak.events[r] / all, leak.events[r]);
  }
  return text;
}

/// Leak and its spread, where there is a scene at rest. A rate that is not identifiable is the prior's, but at most the
/// highest one that the recordings allow. `reasons` gets what the recordings leave open.
std::vector<FittedParameter> leak_parameters(const std::vector<SensorRecording>& recordings,
                                             const EmulatorConfig& prior,
                                             std::map<std::string, std::string>& reasons) {
  if (std::none_of(recordings.begin(), recordings.end(),
                   [](const SensorRecording& r) { return offers(r, Needs::still); }))
    return {};
  const auto row = [](const char* key) {
    const auto all = sensor_parameters();
    return *std::find_if(all.begin(), all.end(), [&](const SensorParameter& p) { return p.key == key; });
  };
  const auto inside = [&](const SensorParameter& p) {
    return std::clamp(parameter_of(prior, p.key), 1.05 * p.smallest, 0.95 * p.largest);
  };
  const SensorParameter rate = row("leak_rate_hz"), spread = row("leak_spread_decades");
  const LeakFit leak =
      fit_leak(recordings, {inside(rate), rate.prior_deviation, inside(spread), spread.prior_deviation});
  const std::string decided = decided_by(leak, recordings);
  const bool rate_found = leak.rate_deviation <= identifiable_share * rate.prior_deviation;
  const bool spread_found = leak.spread_deviation <= identifiable_share * spread.prior_deviation;
  if (!rate_found)
    reasons[rate.key] = fmt::format(
        "no leak above {:.3g} Hz (95 %): shot noise restarts the leakage too often", leak.highest_rate_hz);
  if (!spread_found)
    reasons[spread.key] =
        fmt::format("the recordings leave it open to a factor of {:.2g}", std::exp(leak.spread_deviation));
  const double rate_prior = parameter_of(prior, rate.key), spread_prior = parameter_of(prior, spread.key);
  return {{rate.key, rate_found ? leak.rate_hz : std::min(rate_prior, leak.highest_rate_hz), rate_prior,
           leak.rate_deviation, rate_found, decided},
          {spread.key, spread_found ? leak.spread_decades : spread_prior, spread_prior, leak.spread_deviation,
           spread_found, decided}};
}

std::vector<double> priors_of(const std::vector<Free>& free) {
  std::vector<double> logs;
  for (const Free& f : free) logs.push_back(f.prior);
  return logs;
}

}  // namespace

SensorFit fit_sensor(std::vector<SensorRecording>& recordings, const SensorFitConfig& config) {
  const auto report = [&](const std::string& line) {
    if (config.progress) config.progress(line);
  };
  SensorFit fit;
  fit.config = fit.prior = config.prior;

  std::vector<SensorRecording::HotPixels> hot;
  std::vector<PixelPlace> all_hot;
  for (const SensorRecording& recording : recordings) {
    hot.push_back(recording.hot_pixels());
    for (const PixelPlace& place : hot.back().places) {
      if (std::find(all_hot.begin(), all_hot.end(), place) == all_hot.end()) all_hot.push_back(place);
    }
  }
  for (SensorRecording& recording : recordings) recording.drop(all_hot);
  fit_counts(recordings, hot, all_hot.size(), fit);

  FeatureProblem problem(recordings, config);
  fit.features = problem.targets().size();
  problem.set_free({});
  fit.misfit_before = problem.misfit({});
  std::map<std::string, std::string> reasons;
  const std::vector<FittedParameter> leak = leak_parameters(recordings, config.prior, reasons);
  EmulatorConfig base = config.prior;
  base.readout_rate_hz = fit.config.readout_rate_hz;
  for (const FittedParameter& p : leak) set_parameter(base, p.key, p.value);
  problem.set_base(base);
  for (const FittedParameter& p : leak)
    report(fmt::format("{} {:.4g}, deviation {:.1f} %{}", p.key, p.value, 100.0 * p.deviation,
                       p.identifiable ? "" : ", not identifiable"));
  std::vector<std::string> fixed = {"leak_rate_hz", "leak_spread_decades"};  // by their own likelihood
  std::map<std::string, double> start;
  for (int round = 0; round < 3; ++round) {
    problem.set_free(free_parameters(recordings, config.prior, fixed));
    report(fmt::format("{} features, {} parameters", fit.features, problem.free().size()));
    std::vector<double> logs = priors_of(problem.free());
    for (std::size_t i = 0; i < logs.size(); ++i) {
      if (start.contains(problem.free()[i].key)) logs[i] = start.at(problem.free()[i].key);
    }
    if (round == 0) logs = coarse_search(problem, std::move(logs));
    report(fmt::format("start: rms residual {:.3g} deviations", problem.misfit(logs)));
    logs = solve(problem, std::move(logs));
    if (round == 0) logs = solve_again(problem, std::move(logs), config.seed);
    fit.misfit_after = problem.misfit(logs);
    report(fmt::format("fit: rms residual {:.3g} deviations", fit.misfit_after));
    const Eigen::MatrixXd j = problem.derivatives(logs, problem.residuals(logs));
    // Residuals above what chance explains widen the deviations.
    const double widened = std::max(1.0, fit.misfit_after);
    Eigen::MatrixXd information = j.topRows(static_cast<Eigen::Index>(fit.features)).transpose() *
                                  j.topRows(static_cast<Eigen::Index>(fit.features)) / (widened * widened);
    for (std::size_t i = 0; i < logs.size(); ++i) {
      const auto k = static_cast<Eigen::Index>(i);
      information(k, k) += 1.0 / (problem.free()[i].prior_deviation * problem.free()[i].prior_deviation);
    }
    const Eigen::MatrixXd covariance =
        information.ldlt().solve(Eigen::MatrixXd::Identity(information.rows(), information.cols()));
    std::vector<std::string> unclear;
    std::vector<FittedParameter> fitted;
    for (const FittedParameter& p : leak) {
      if (p.identifiable) fitted.push_back(p);
    }
    for (std::size_t i = 0; i < logs.size(); ++i) {
      const Free& f = problem.free()[i];
      const double deviation =
          std::sqrt(covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i)));
      start[f.key] = logs[i];
      if (!f.recording && deviation > identifiable_share * f.prior_deviation) {
        unclear.push_back(f.key);
        reasons[f.key] =
            fmt::format("the recordings leave it open to a factor of {:.2g}", std::exp(deviation));
      }
      fitted.push_back({f.key, std::exp(logs[i]), std::exp(f.prior), deviation, true,
                        decided_by(problem, j, i, recordings)});
    }
    if (!unclear.empty() && round < 2) {
      fixed.insert(fixed.end(), unclear.begin(), unclear.end());
      continue;
    }
    const EmulatorConfig found = problem.config_of(logs);
    fit.contrast_scales = problem.contrast_scales(logs);
    std::vector<FittedParameter> rows;
    for (const SensorParameter& p : sensor_parameters()) {
      const auto it =
          std::find_if(fitted.begin(), fitted.end(), [&](const auto& f) { return f.key == p.key; });
      if (it != fitted.end() && std::count(unclear.begin(), unclear.end(), p.key) == 0) {
        rows.push_back(*it);
        rows.back().value = parameter_of(found, p.key);
        rows.back().prior = parameter_of(config.prior, p.key);
        set_parameter(fit.config, p.key, rows.back().value);
        continue;
      }
      set_parameter(fit.config, p.key, parameter_of(base, p.key));
      rows.push_back({p.key, parameter_of(base, p.key), parameter_of(config.prior, p.key), p.prior_deviation,
                      false, reasons.contains(p.key) ? reasons.at(p.key) : missing(p.needs)});
    }
    for (const FittedParameter& f : fitted) {
      if (f.key.starts_with("contrast of ")) rows.push_back(f);
    }
    fit.parameters.insert(fit.parameters.begin(), rows.begin(), rows.end());
    break;
  }
  correct_hot_rate(fit);
  report("distributions");
  fit.distributions =
      compare_distributions(recordings, fit.prior, fit.config, fit.contrast_scales, config.seed);
  return fit;
}

}  // namespace saccade::inline v0_1
