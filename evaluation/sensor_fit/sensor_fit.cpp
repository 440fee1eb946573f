#include "evaluation/sensor_fit/sensor_fit.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "core/error.h"
#include "evaluation/sensor_fit/feature_problem.h"
#include "evaluation/sensor_fit/leak_fit.h"
#include "evaluation/sensor_fit/sensor_counts.h"
#include "evaluation/sensor_fit/sensor_parameters.h"

namespace saccade {
namespace {

constexpr double identifiable_share = 0.5;  ///< posterior deviation against the prior's

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

std::vector<FreeParameter> free_parameters(const std::vector<SensorRecording>& recordings,
                                           const EmulatorConfig& prior,
                                           const std::vector<std::string>& fixed) {
  std::vector<FreeParameter> free;
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

std::string in_words(const StillValue& v, double unit) {
  return fmt::format("{:.3g} ({:.3g} to {:.3g})", v.value / unit, v.low / unit, v.high / unit);
}

/// The mean of the logarithms of what recordings identify, weighted by their intervals; none: not identifiable.
StillValue mean_of(const std::vector<StillFit>& fits, StillValue StillFit::*member,
                   const std::vector<double>& factor) {
  double weights = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < fits.size(); ++i) {
    const StillValue& v = fits[i].*member;
    if (!v.identifiable) continue;
    const double width = std::log(v.high / v.low);
    weights += 1.0 / (width * width);
    sum += std::log(v.value * factor[i]) / (width * width);
  }
  if (!(weights > 0.0)) return {};
  const double log = sum / weights, half = 0.5 / std::sqrt(weights);
  return {std::exp(log), std::exp(log - half), std::exp(log + half), true};
}

/// Adds what the noise of scenes at rest says to what no other recording determines.
void add_still(const std::vector<SensorRecording>& recordings, const SensorFitConfig& config,
               SensorFit& fit) {
  std::vector<double> same, to_white;
  for (const SensorRecording& recording : recordings) {
    if (recording.stimulus().moves()) continue;
    fit.still.push_back(fit_still(recording, config.prior));
    same.push_back(1.0);
    to_white.push_back(config.prior.cutoff_follows_light
                           ? (config.prior.white + config.prior.dark_current) /
                                 std::max(1e-9, recording.stimulus().luminance + config.prior.dark_current)
                           : 1.0);
  }
  const auto row = [&](const char* key) -> FittedParameter* {
    for (FittedParameter& p : fit.parameters) {
      if (p.key == key && !p.identifiable) return &p;
    }
    return nullptr;
  };
  const auto list = [&](StillValue StillFit::*member, double unit, const char* what) {
    std::string text;
    for (const StillFit& s : fit.still) {
      text += text.empty() ? "" : ", ";
      text +=
          (s.*member).identifiable ? s.recording + " " + in_words(s.*member, unit) : s.recording + " unknown";
    }
    return what + text;
  };
  FittedParameter* const on = row("contrast_threshold_on");
  FittedParameter* const off = row("contrast_threshold_off");
  const StillValue ratio = mean_of(fit.still, &StillFit::on_over_off, same);
  if (on != nullptr) on->decided_by = list(&StillFit::on, 1.0, "only threshold / noise: ");
  if (off != nullptr) off->decided_by = list(&StillFit::off, 1.0, "only threshold / noise: ");
  if (on != nullptr && off != nullptr && ratio.identifiable) {
    const double mean = std::sqrt(on->prior * off->prior);
    on->value = fit.config.contrast_threshold_on = mean * std::sqrt(ratio.value);
    off->value = fit.config.contrast_threshold_off = mean / std::sqrt(ratio.value);
    on->decided_by += "; ON / OFF " + in_words(ratio, 1.0);
  }
  const auto set = [&](FittedParameter& p, const StillValue& v, double unit) {
    p.value = v.value / unit;
    p.deviation = std::log(v.high / v.low) / 4.0;  // the interval of 95 % is about four deviations wide
    p.identifiable = true;
    set_parameter(fit.config, p.key, p.value);
  };
  if (FittedParameter* const p = row("cutoff_hz")) {
    const StillValue cutoff = mean_of(fit.still, &StillFit::cutoff_hz, to_white);
    p->decided_by = list(&StillFit::cutoff_hz, 1.0, "of the noise, at its light, Hz: ");
    if (cutoff.identifiable && config.known_light) set(*p, cutoff, 1.0);
  }
  if (FittedParameter* const p = row("refractory_us")) {
    const StillValue refractory = mean_of(fit.still, &StillFit::refractory_s, same);
    p->decided_by = list(&StillFit::refractory_s, 1e-6, "us: ");
    if (refractory.identifiable) set(*p, refractory, 1e-6);
  }
}

std::vector<double> priors_of(const std::vector<FreeParameter>& free) {
  std::vector<double> logs;
  for (const FreeParameter& f : free) logs.push_back(f.prior);
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
    logs = least_squares(problem, std::move(logs));
    if (round == 0) logs = search_again(problem, std::move(logs), config.seed);
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
      const FreeParameter& f = problem.free()[i];
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
  if (config.still) {
    report("noise of the scenes at rest");
    add_still(recordings, config, fit);
  }
  report("distributions");
  fit.distributions =
      compare_distributions(recordings, fit.prior, fit.config, fit.contrast_scales, config.seed);
  return fit;
}

}  // namespace saccade
