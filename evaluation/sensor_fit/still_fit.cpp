#include "evaluation/sensor_fit/still_fit.h"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <future>
#include <limits>
#include <numbers>
#include <utility>
#include <vector>

#include "evaluation/sensor_fit/still_noise.h"

namespace saccade {
namespace {

constexpr std::size_t groups = 16;          ///< of pixels, for deviations
constexpr double relative_error = 0.05;     ///< of an expected number of events
constexpr double large_residual = 5.0;      ///< residuals grow with their logarithm from there on
constexpr double difference = 0.02;         ///< of a parameter's logarithm, for derivatives
constexpr double identifiable_share = 0.5;  ///< posterior deviation against the prior's
constexpr double fewest_events = 30.0;      ///< of each polarity
constexpr double largest_misfit = 4.0;      ///< deviations; above it the noise is not that of the model
constexpr double as_good =
    10.0;  ///< a minimum whose sum of squares is larger by that, in deviations, may be the right one
constexpr double two_sided = 1.96;  ///< deviations of 95 %
constexpr double edges_per_decade = 4.0, first_edge_s = 3e-5;
constexpr std::size_t bins = 30;

enum Parameter : Eigen::Index { on_ratio, on_to_off, time_constant, refractory, leak, spread, parameters };
using Logs = Eigen::Matrix<double, parameters, 1>;

/// Normal distribution over the pixels by three of them.
struct Node {
  double deviations, weight;
};
constexpr std::array<Node, 3> nodes{{{0.0, 2.0 / 3.0}, {-1.732050808, 1.0 / 6.0}, {1.732050808, 1.0 / 6.0}}};

/// Numbers of events or of intervals.
struct Counts {
  std::array<double, 2> events{};
  std::array<std::vector<double>, successions> intervals;
  double variation = 0.0;  // of the pixels' rates: variance over squared mean
};

/// Numbers of a group of pixels.
struct Group {
  Counts counts;
  double first = 0.0, second = 0.0, product = 0.0, pixels = 0.0;  // events of the halves of the time
};

double variation_of(double first, double second, double product, double pixels) {
  return first > 0.0 && second > 0.0 ? product * pixels / (first * second) - 1.0 : 0.0;
}

/// All counts one after the other.
std::vector<double> listed(const Counts& counts) {
  std::vector<double> list(counts.events.begin(), counts.events.end());
  for (const auto& bins_of : counts.intervals) list.insert(list.end(), bins_of.begin(), bins_of.end());
  return list;
}

class StillProblem {
 public:
  StillProblem(const SensorRecording& recording, const Logs& prior, const Logs& deviation)
      : prior_(prior), deviation_(deviation) {
    for (std::size_t i = 0; i <= bins; ++i)
      edges_s_.push_back(first_edge_s * std::pow(10.0, static_cast<double>(i) / edges_per_decade));
    const StimulusInterval whole = recording.interval();
    duration_s_ = 1e-6 * static_cast<double>(whole.end_us - whole.begin_us);
    const std::int64_t half_us = whole.begin_us + (whole.end_us - whole.begin_us) / 2;
    const PixelTrains& trains = recording.trains();
    pixels_ = static_cast<double>(trains.pixels());
    std::array<Group, groups> parts;
    for (Group& part : parts) {
      for (auto& counts : part.counts.intervals) counts.assign(bins, 0.0);
    }
    for (std::size_t p = 0; p < trains.pixels(); ++p)
      add(trains.of(p), half_us, parts[p * groups / trains.pixels()]);
    set_targets(parts);
  }

  [[nodiscard]] double events(bool on) const { return recorded_[on ? 0 : 1]; }
  /// Of the intervals from an event to one of the other polarity, from the bins.
  [[nodiscard]] double quantile_s(double share) const {
    const auto count = [&](std::size_t b) {
      return recorded_[2 + bins * static_cast<std::size_t>(Succession::on_off) + b] +
             recorded_[2 + bins * static_cast<std::size_t>(Succession::off_on) + b];
    };
    double all = 0.0, below = 0.0;
    for (std::size_t b = 0; b < bins; ++b) all += count(b);
    for (std::size_t b = 0; b < bins; ++b) {
      below += count(b);
      if (below >= share * all) return edges_s_[b];
    }
    return edges_s_.back();
  }
  [[nodiscard]] double exposure_s() const { return pixels_ * duration_s_; }
  [[nodiscard]] Eigen::Index features() const { return static_cast<Eigen::Index>(recorded_.size()); }
  [[nodiscard]] const Logs& prior() const { return prior_; }
  [[nodiscard]] const Logs& deviation() const { return deviation_; }

  /// Of the features, then of the prior. `whole`: with the spread over the pixels.
  [[nodiscard]] Eigen::VectorXd residuals(const Logs& logs, bool whole) const {
    const std::vector<double> expected = expectation(logs, whole);
    Eigen::VectorXd r(features() + parameters);
    for (std::size_t i = 0; i < recorded_.size(); ++i) {
      const bool of_spread = i + 1 == recorded_.size();
      const double error =
          of_spread ? deviations_[i] : std::hypot(deviations_[i], relative_error * expected[i]);
      const double off = of_spread && !whole ? 0.0 : (expected[i] - recorded_[i]) / error;
      r[static_cast<Eigen::Index>(i)] = large_residual * std::asinh(off / large_residual);
    }
    r.tail(parameters) = (logs - prior_).cwiseQuotient(deviation_);
    return r;
  }
  [[nodiscard]] Eigen::MatrixXd derivatives(const Logs& logs, const Eigen::VectorXd& at, bool whole) const {
    Eigen::MatrixXd j(features() + parameters, static_cast<Eigen::Index>(parameters));
    for (Eigen::Index i = 0; i < parameters; ++i) {
      Logs other = logs;
      other[i] += difference;
      j.col(i) = (residuals(other, whole) - at) / difference;
    }
    return j;
  }

 private:
  void add(std::span<const TrainEvent> train, std::int64_t half_us, Group& group) const {
    std::array<double, 2> halves{};
    for (std::size_t i = 0; i < train.size(); ++i) {
      group.counts.events[train[i].on ? 0 : 1] += 1.0;
      halves[train[i].t_us <= half_us ? 0 : 1] += 1.0;
      if (i == 0) continue;
      const double interval_s = 1e-6 * static_cast<double>(train[i].t_us - train[i - 1].t_us);
      const auto after = std::upper_bound(edges_s_.begin(), edges_s_.end(), interval_s);
      if (after == edges_s_.begin() || after == edges_s_.end()) continue;
      const auto bin = static_cast<std::size_t>(after - edges_s_.begin()) - 1;
      group.counts.intervals[succession_of(train[i - 1].on, train[i].on)][bin] += 1.0;
    }
    group.first += halves[0];
    group.second += halves[1];
    group.product += halves[0] * halves[1];
    group.pixels += 1.0;
  }

  /// Sums over the groups, and their deviations from those of the groups; one event where there are none.
  void set_targets(const std::array<Group, groups>& parts) {
    std::vector<std::vector<double>> lists;
    Group all;
    for (const Group& part : parts) {
      lists.push_back(listed(part.counts));
      all.first += part.first;
      all.second += part.second;
      all.product += part.product;
      all.pixels += part.pixels;
    }
    constexpr auto count = static_cast<double>(groups);
    for (std::size_t i = 0; i < lists.front().size(); ++i) {
      double sum = 0.0, squares = 0.0;
      for (const auto& list : lists) sum += list[i];
      for (const auto& list : lists) squares += (list[i] - sum / count) * (list[i] - sum / count);
      recorded_.push_back(sum);
      deviations_.push_back(std::sqrt(std::max(squares * count / (count - 1.0), sum + 1.0)));
    }
    const double variation = variation_of(all.first, all.second, all.product, all.pixels);
    double squares = 0.0;
    for (const Group& part : parts) {
      const double without = variation_of(all.first - part.first, all.second - part.second,
                                          all.product - part.product, all.pixels - part.pixels);
      squares += (without - variation) * (without - variation);
    }
    recorded_.push_back(variation);
    deviations_.push_back(std::sqrt(squares * (count - 1.0) / count) + 0.01 + 0.1 * std::abs(variation));
  }

  [[nodiscard]] std::vector<double> expectation(const Logs& logs, bool whole) const {
    const std::size_t count = whole ? nodes.size() : 1;
    std::vector<std::future<StillRates>> futures;
    for (std::size_t m = 0; m < count; ++m) {
      futures.push_back(std::async(std::launch::async, [&, m] {
        const double factor = std::exp(nodes[m].deviations * std::exp(logs[spread]));
        StillNoise noise;
        noise.on = std::clamp(std::exp(logs[on_ratio]) * factor, 1.0, StillNoise::largest_ratio);
        noise.off =
            std::clamp(std::exp(logs[on_ratio] - logs[on_to_off]) * factor, 1.0, StillNoise::largest_ratio);
        noise.time_constant_s = std::exp(logs[time_constant]);
        noise.refractory_s = std::exp(logs[refractory]);
        noise.leak_hz = std::exp(logs[leak]);
        return still_rates(noise, edges_s_);
      }));
    }
    std::vector<double> list(recorded_.size(), 0.0);
    double mean = 0.0, square = 0.0;
    for (std::size_t m = 0; m < count; ++m) {
      const StillRates rates = futures[m].get();
      const double weight = whole ? nodes[m].weight : 1.0;
      list[0] += weight * rates.on_hz * exposure_s();
      list[1] += weight * rates.off_hz * exposure_s();
      for (std::size_t s = 0; s < successions; ++s) {
        for (std::size_t b = 0; b < bins;
             ++b) {  // an interval of the length t is whole in duration - t of the time
          const double middle_s = std::sqrt(edges_s_[b] * edges_s_[b + 1]);
          list[2 + s * bins + b] +=
              weight * rates.intervals_hz[s][b] * pixels_ * std::max(0.0, duration_s_ - middle_s);
        }
      }
      const double all_hz = rates.on_hz + rates.off_hz;
      mean += weight * all_hz;
      square += weight * all_hz * all_hz;
    }
    list.back() = square / (mean * mean) - 1.0;
    return list;
  }

  Logs prior_, deviation_;
  std::vector<double> edges_s_;
  double duration_s_ = 0.0, pixels_ = 0.0;
  std::vector<double> recorded_, deviations_;
};

class StillCost final : public ceres::CostFunction {
 public:
  StillCost(const StillProblem& problem, bool whole) : problem_(problem), whole_(whole) {
    set_num_residuals(static_cast<int>(problem.features() + parameters));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(parameters));
  }
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Logs logs = Eigen::Map<const Logs>(blocks[0]);
    const Eigen::VectorXd at = problem_.residuals(logs, whole_);
    Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()) = at;
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
          jacobians[0], num_residuals(), static_cast<Eigen::Index>(parameters)) =
          problem_.derivatives(logs, at, whole_);
    }
    return true;
  }

 private:
  const StillProblem& problem_;
  bool whole_;
};

struct Bound {
  double low, high;
};
constexpr std::array<Bound, parameters> bounds{
    {{1.2, 9.4}, {0.3, 3.3}, {2e-6, 0.3}, {2e-6, 0.1}, {1e-4, 100.0}, {0.003, 0.3}}};

Logs least_squares(const StillProblem& problem, Logs logs, bool whole) {
  ceres::Problem solved;
  solved.AddResidualBlock(new StillCost(problem, whole), nullptr, logs.data());
  for (int i = 0; i < parameters; ++i) {
    const auto k = static_cast<std::size_t>(i);
    logs[i] = std::clamp(logs[i], std::log(bounds[k].low), std::log(bounds[k].high));
    solved.SetParameterLowerBound(logs.data(), i, std::log(bounds[k].low));
    solved.SetParameterUpperBound(logs.data(), i, std::log(bounds[k].high));
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.logging_type = ceres::SILENT;
  options.max_num_iterations = 20;
  options.function_tolerance = 1e-4;
  options.parameter_tolerance = 1e-4;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &solved, &summary);
  return logs;
}

/// The bandwidth at the recording's light.
double cutoff_at(const EmulatorConfig& prior, double luminance) {
  const double at_white = prior.cutoff_hz > 0.0 ? prior.cutoff_hz : EmulatorConfig{}.cutoff_hz;
  if (!prior.cutoff_follows_light) return at_white;
  return at_white * std::max(1e-3, (luminance + prior.dark_current) / (prior.white + prior.dark_current));
}

/// The ratio of thresholds to noise above which fewer OFF events than `events` come in `exposure_s`.
double ratio_of_rate(double events, double exposure_s, double time_constant_s, double refractory_s) {
  double low = bounds[on_ratio].low, high = bounds[on_ratio].high;
  const std::array<double, 2> edges{1e-6, 1e3};
  for (int i = 0; i < 8; ++i) {
    const double middle = 0.5 * (low + high);
    const StillRates rates = still_rates({middle, middle, time_constant_s, refractory_s, 1e-4}, edges);
    (rates.off_hz * exposure_s > events ? low : high) = middle;
  }
  return low;
}

}  // namespace

StillFit fit_still(const SensorRecording& recording, const EmulatorConfig& prior) {
  constexpr double tau = 2.0 * std::numbers::pi;
  const double refractory_s = std::max(1e-5, 1e-6 * static_cast<double>(prior.refractory_us));
  const double prior_cutoff_hz = cutoff_at(prior, recording.stimulus().luminance);
  Logs centre, deviation;
  centre << std::log(4.0), std::log(prior.contrast_threshold_on / prior.contrast_threshold_off),
      -std::log(tau * prior_cutoff_hz), std::log(refractory_s), std::log(std::max(1e-3, prior.leak_rate_hz)),
      std::log(std::max(0.01, prior.threshold_mismatch));
  deviation << 0.6, 0.5, 2.0, 1.5, 2.0, 1.0;
  const StillProblem problem(recording, centre, deviation);

  StillFit fit;
  fit.recording = recording.name();
  fit.on_events = static_cast<std::size_t>(problem.events(true));
  fit.off_events = static_cast<std::size_t>(problem.events(false));
  if (problem.events(false) < fewest_events || problem.events(true) < fewest_events) {
    constexpr double most = 3.0;  // of which none comes with a probability of 5 %
    const double fewest = std::min(problem.events(true), problem.events(false));
    const double limit =
        ratio_of_rate(fewest + most, problem.exposure_s(), 1.0 / (tau * prior_cutoff_hz), refractory_s);
    fit.limit = fmt::format(
        "{} ON and {} OFF events: threshold / noise is above {:.2g} if the bandwidth is the prior's, {:.3g} "
        "Hz",
        fit.on_events, fit.off_events, limit, prior_cutoff_hz);
    return fit;
  }

  // Without the spread from some starts, because there are several minima, then with it. The bandwidth begins where events
  // follow those of the other polarity, the thresholds where rises and falls cancel, or where one of them is the larger one.
  const double balance = std::clamp(std::log(problem.events(false) / problem.events(true)), -0.7, 0.7);
  const double dead_s = std::clamp(problem.quantile_s(0.02), 1e-5, 0.03);
  const double follows_s = std::max(problem.quantile_s(0.3) - dead_s, 0.3 * dead_s);
  std::vector<Logs> starts;
  for (const double log_ratio : {balance, -0.25, 0.25}) {
    for (const double faster : {1.0, 4.0}) {
      Logs start = centre;
      start[time_constant] = std::clamp(std::log(follows_s / faster), std::log(1e-5), std::log(0.1));
      start[refractory] = std::log(dead_s);
      const double ratio = ratio_of_rate(0.5 * (problem.events(true) + problem.events(false)),
                                         problem.exposure_s(), std::exp(start[time_constant]), dead_s);
      start[on_ratio] = std::log(ratio) + 0.5 * log_ratio;
      start[on_to_off] = log_ratio;
      starts.push_back(start);
    }
  }
  std::vector<std::pair<double, Logs>> minima;
  for (const Logs& start : starts) {
    const Logs found = least_squares(problem, start, false);
    minima.emplace_back(problem.residuals(found, false).squaredNorm(), found);
  }
  const std::pair<double, Logs> fewest = *std::min_element(
      minima.begin(), minima.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  const double least = fewest.first;
  const Logs& best = fewest.second;
  const Logs logs = least_squares(problem, best, true);
  const Eigen::VectorXd at = problem.residuals(logs, true);
  fit.misfit = std::sqrt(at.head(problem.features()).squaredNorm() / static_cast<double>(problem.features()));
  const Eigen::MatrixXd j = problem.derivatives(logs, at, true);
  const double widened = std::max(1.0, fit.misfit);
  Eigen::MatrixXd information =
      j.topRows(problem.features()).transpose() * j.topRows(problem.features()) / (widened * widened);
  information.diagonal() += deviation.cwiseAbs2().cwiseInverse();
  const Eigen::MatrixXd covariance =
      information.ldlt().solve(Eigen::MatrixXd::Identity(parameters, parameters));
  const auto value = [&](const Logs& direction, double sign, double factor, double model_error) {
    const double log = direction.dot(logs), own = std::sqrt(direction.dot(covariance * direction));
    const double before = std::sqrt((direction.cwiseProduct(deviation)).squaredNorm());
    const double both = two_sided * std::hypot(own, model_error);
    StillValue v{factor * std::exp(sign * log), factor * std::exp(sign * log - both),
                 factor * std::exp(sign * log + both), own <= identifiable_share * before};
    for (const auto& [cost, other] : minima) {
      if (cost - least > as_good * widened * widened) continue;
      const double away = direction.dot(other) - direction.dot(best);
      v.low = std::min(v.low, v.value * std::exp(sign * away));
      v.high = std::max(v.high, v.value * std::exp(sign * away));
      v.identifiable = v.identifiable && std::abs(away) <= identifiable_share * before;
    }
    return v;
  };
  const double largest_ratio = std::exp(logs[on_ratio] + std::max(0.0, -logs[on_to_off]));
  const auto unit = [](Parameter p) { return Logs(Logs::Unit(p)); };
  fit.on = value(unit(on_ratio), 1.0, 1.0, StillFit::model_error);
  fit.off = value(unit(on_ratio) - unit(on_to_off), 1.0, 1.0, StillFit::model_error);
  fit.on_over_off = value(unit(on_to_off), 1.0, 1.0, StillFit::model_error);
  fit.cutoff_hz = value(unit(time_constant), -1.0, 1.0 / tau, StillFit::model_error);
  fit.refractory_s = value(unit(refractory), 1.0, 1.0, 0.0);
  fit.leak_hz = value(unit(leak), 1.0, 1.0, 0.0);
  fit.spread = value(unit(spread), 1.0, 1.0, 0.0);
  if (fit.misfit > largest_misfit) {
    fit.limit = fmt::format(
        "the intervals are not those of Gaussian noise behind a low-pass: rms residual {:.2g} deviations",
        fit.misfit);
    for (StillValue* v :
         {&fit.on, &fit.off, &fit.on_over_off, &fit.cutoff_hz, &fit.refractory_s, &fit.leak_hz, &fit.spread})
      v->identifiable = false;
  } else if (largest_ratio > 0.98 * bounds[on_ratio].high) {
    fit.limit = fmt::format("one of the thresholds is above {:.2g} deviations of the noise, beyond the model",
                            0.98 * bounds[on_ratio].high);
    fit.on.identifiable = fit.off.identifiable = fit.on_over_off.identifiable = false;
  } else if (!fit.on.identifiable || !fit.off.identifiable || !fit.on_over_off.identifiable) {
    fit.limit = "the events leave threshold / noise open: other values fit as well";
  }
  return fit;
}

}  // namespace saccade
