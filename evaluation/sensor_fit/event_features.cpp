#include "evaluation/sensor_fit/event_features.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

namespace saccade {
namespace {

constexpr std::size_t responses_counted = 4;  ///< events after a panel's step whose times and shares count
constexpr std::size_t interval_bins = 12;
constexpr double first_interval_us = 50.0;

std::size_t group_of(std::size_t pixel) { return pixel % Feature::groups; }

double log_us(std::int64_t duration_us) {
  return std::log(static_cast<double>(std::max<std::int64_t>(1, duration_us)));
}

/// Features by number; names are given once.
class Features {
 public:
  explicit Features(std::vector<std::string> names) {
    for (std::string& name : names) features_.push_back({std::move(name), {}, {}});
  }
  void add(std::size_t feature, std::size_t pixel, double numerator, double denominator) {
    features_[feature].numerator[group_of(pixel)] += numerator;
    features_[feature].denominator[group_of(pixel)] += denominator;
  }
  [[nodiscard]] std::vector<Feature> take() && { return std::move(features_); }

 private:
  std::vector<Feature> features_;
};

/// How much the logarithm of a pixel's counts differs from that of the pixel before, 100 times the variance. Mismatch makes it;
/// what differs slowly over the pixels does not.
class Spread {
 public:
  void add(Features& features, std::size_t feature, std::size_t pixel, double value) {
    if (last_) features.add(feature, pixel, 50.0 * (value - *last_) * (value - *last_), 1.0);
    last_ = value;
  }

 private:
  std::optional<double> last_;
};

std::vector<Feature> still_features(double duration_s, const PixelTrains& trains) {
  enum { rate, variance = 2, interval = 4, interval_square = 6 };  // of OFF; those of ON follow
  Features features({"OFF rate", "ON rate", "OFF variance", "ON variance", "OFF intervals", "ON intervals",
                     "OFF intervals, spread", "ON intervals, spread"});
  for (std::size_t pixel = 0; pixel < trains.pixels(); ++pixel) {
    std::array<double, 2> counts{};
    const auto train = trains.of(pixel);
    for (std::size_t i = 0; i < train.size(); ++i) {
      const std::size_t on = train[i].on ? 1 : 0;
      counts[on] += 1.0;
      if (i == 0 || train[i - 1].on != train[i].on) continue;
      const double length = log_us(train[i].t_us - train[i - 1].t_us);
      features.add(interval + on, pixel, length, 1.0);
      features.add(interval_square + on, pixel, length * length, 1.0);
    }
    for (std::size_t on = 0; on < 2; ++on) {
      features.add(rate + on, pixel, counts[on], duration_s);
      features.add(variance + on, pixel, counts[on] * counts[on], counts[on]);
    }
  }
  return std::move(features).take();
}

std::vector<Feature> moving_features(double duration_s, const PixelTrains& trains) {
  enum { rate, variance = 2, run = 4, run_square = 6, interval = 8, ratio = 10, bins = 11 };
  std::vector<std::string> names = {"OFF rate",
                                    "ON rate",
                                    "OFF variance",
                                    "ON variance",
                                    "OFF events per run",
                                    "ON events per run",
                                    "OFF events per run, spread",
                                    "ON events per run, spread",
                                    "OFF intervals",
                                    "ON intervals",
                                    "ON to OFF events, spread over pixels"};
  Spread ratios;
  double edge_us = first_interval_us;
  for (std::size_t i = 0; i < interval_bins; ++i, edge_us *= 2.0) {
    names.push_back("intervals below " + std::to_string(static_cast<int>(edge_us)) + " us");
  }
  Features features(std::move(names));
  for (std::size_t pixel = 0; pixel < trains.pixels(); ++pixel) {
    std::array<double, 2> counts{};
    const auto train = trains.of(pixel);
    double length = 0.0;
    for (std::size_t i = 0; i < train.size(); ++i) {
      const std::size_t on = train[i].on ? 1 : 0;
      counts[on] += 1.0;
      length += 1.0;
      const bool ends = i + 1 == train.size() || train[i + 1].on != train[i].on;
      if (ends) {
        features.add(run + on, pixel, length, 1.0);
        features.add(run_square + on, pixel, length * length, length);
        length = 0.0;
        continue;
      }
      const std::int64_t gap_us = train[i + 1].t_us - train[i].t_us;
      features.add(interval + on, pixel, log_us(gap_us), 1.0);
      edge_us = first_interval_us;
      for (std::size_t bin = 0; bin < interval_bins; ++bin, edge_us *= 2.0) {
        features.add(bins + bin, pixel, static_cast<double>(gap_us) < edge_us ? 1.0 : 0.0, 1.0);
      }
    }
    for (std::size_t on = 0; on < 2; ++on) {
      features.add(rate + on, pixel, counts[on], duration_s);
      features.add(variance + on, pixel, counts[on] * counts[on], counts[on]);
    }
    if (counts[0] > 0.0 && counts[1] > 0.0)
      ratios.add(features, ratio, pixel, std::log(counts[1] / counts[0]));
  }
  return std::move(features).take();
}

std::vector<Feature> panel_features(const Stimulus& panel, StimulusInterval interval,
                                    const PixelTrains& trains) {
  const std::vector<PanelStep> steps = steps_of(panel);
  constexpr std::size_t per_step = 3 + 2 * responses_counted;
  std::vector<std::string> names;
  for (const PanelStep& step : steps) {
    const std::string which = text_of(step.before) + " to " + text_of(step.after);
    names.insert(names.end(), {"events, " + which, "events against it, " + which, "variance, " + which});
    for (std::size_t k = 1; k <= responses_counted; ++k)
      names.push_back("event " + std::to_string(k) + ", " + which);
    for (std::size_t k = 1; k <= responses_counted; ++k)
      names.push_back("time of event " + std::to_string(k) + ", " + which);
  }
  names.insert(names.end(), {"OFF events, spread over pixels", "ON events, spread over pixels"});
  Features features(std::move(names));
  std::array<Spread, 2> spreads;
  for (std::size_t pixel = 0; pixel < trains.pixels(); ++pixel) {
    std::array<double, 2> counts{};
    for (const TrainEvent& event : trains.of(pixel)) counts[event.on ? 1 : 0] += 1.0;
    for (std::size_t on = 0; on < 2; ++on) {
      if (counts[on] > 0.0)
        spreads[on].add(features, steps.size() * per_step + on, pixel, std::log(counts[on]));
    }
  }
  for (const PanelResponse& response : panel_responses(panel, interval, trains)) {
    const bool rises = steps[response.step].after > steps[response.step].before;
    const std::size_t first = response.step * per_step;
    double with = 0.0, against = 0.0;
    std::size_t number = 0;
    for (const TrainEvent& event : response.events) {
      (event.on == rises ? with : against) += 1.0;
      if (event.on != rises || number >= responses_counted) continue;
      features.add(first + 3 + responses_counted + number, response.pixel,
                   log_us(event.t_us - response.begin_us), 1.0);
      ++number;
    }
    features.add(first, response.pixel, with, 1.0);
    features.add(first + 1, response.pixel, against, 1.0);
    features.add(first + 2, response.pixel, with * with, with);
    for (std::size_t k = 0; k < responses_counted; ++k) {
      features.add(first + 3 + k, response.pixel, number > k ? 1.0 : 0.0, 1.0);
    }
  }
  return std::move(features).take();
}

}  // namespace

double Feature::value() const {
  const double all = std::accumulate(denominator.begin(), denominator.end(), 0.0);
  return all > 0.0 ? std::accumulate(numerator.begin(), numerator.end(), 0.0) / all
                   : std::numeric_limits<double>::quiet_NaN();
}

double Feature::deviation() const {
  const double numerators = std::accumulate(numerator.begin(), numerator.end(), 0.0);
  const double denominators = std::accumulate(denominator.begin(), denominator.end(), 0.0);
  std::vector<double> left;
  for (std::size_t g = 0; g < groups; ++g) {
    if (denominator[g] == 0.0) continue;
    if (!(denominators > denominator[g])) return std::numeric_limits<double>::quiet_NaN();
    left.push_back((numerators - numerator[g]) / (denominators - denominator[g]));
  }
  if (left.size() < 2) return std::numeric_limits<double>::quiet_NaN();
  const auto count = static_cast<double>(left.size());
  const double mean = std::accumulate(left.begin(), left.end(), 0.0) / count;
  double squares = 0.0;
  for (const double v : left) squares += (v - mean) * (v - mean);
  return std::sqrt(squares * (count - 1.0) / count);
}

std::vector<Feature> features_of(const Stimulus& stimulus, StimulusInterval interval,
                                 const PixelTrains& trains) {
  const double duration_s = static_cast<double>(interval.end_us - interval.begin_us) * 1e-6;
  if (stimulus.kind == StimulusKind::still) return still_features(duration_s, trains);
  if (stimulus.kind == StimulusKind::panel) return panel_features(stimulus, interval, trains);
  return moving_features(duration_s, trains);
}

std::vector<PanelResponse> panel_responses(const Stimulus& panel, StimulusInterval interval,
                                           const PixelTrains& trains) {
  const std::vector<PanelStep> steps = steps_of(panel);
  const auto us = [](double seconds) { return std::llround(seconds * 1e6); };
  const std::int64_t period_us = panel.period_s > 0.0 ? us(panel.period_s) : 0;
  std::vector<PanelResponse> responses;
  for (std::size_t pixel = 0; pixel < trains.pixels(); ++pixel) {
    const auto train = trains.of(pixel);
    auto next = train.begin();
    for (std::int64_t start_us = panel.zero_us; start_us < interval.end_us; start_us += period_us) {
      for (std::size_t step = 0; step < steps.size(); ++step) {
        PanelResponse response{pixel, step, start_us + us(steps[step].t_s), {}};
        const std::int64_t until_us = start_us + us(steps[step].until_s);
        if (response.begin_us <= interval.begin_us || until_us > interval.end_us) continue;
        while (next != train.end() && next->t_us <= response.begin_us) ++next;
        for (; next != train.end() && next->t_us <= until_us; ++next) response.events.push_back(*next);
        responses.push_back(std::move(response));
      }
      if (period_us == 0) break;
    }
  }
  return responses;
}

}  // namespace saccade
