#include "evaluation/sensor_fit/leak_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace saccade {
namespace {

constexpr double shortest_s = 1e-3;  ///< of a leak period
constexpr double bin_width = 0.07;   ///< of a period's logarithm
constexpr std::size_t bins = 200;    ///< up to 1,200 s
constexpr double missed = 0.01;      ///< probability that an interval lasts longer than the leak period
constexpr double negligible = 15.0;  ///< below the largest logarithm of the posterior

double log_period(std::size_t bin) {
  return std::log(shortest_s) + (static_cast<double>(bin) + 0.5) * bin_width;
}

std::size_t bin_of(std::int64_t duration_us) {
  const double bin =
      std::log(std::max(1e-6 * static_cast<double>(duration_us), shortest_s) / shortest_s) / bin_width;
  return std::min(bins - 1, static_cast<std::size_t>(bin));
}

/// A recording at rest: of each pixel, how its intervals stand to each leak period.
class StillIntervals {
 public:
  StillIntervals(const SensorRecording& recording, std::size_t number) : number_(number) {
    const PixelTrains trains = recording.trains().half(false);
    pixels_.resize(trains.pixels());
    const StimulusInterval whole = recording.interval();
    exposure_s_ = 1e-6 * static_cast<double>(whole.end_us - whole.begin_us) *
                  static_cast<double>(std::max<std::size_t>(1, trains.pixels()));
    for (std::size_t p = 0; p < trains.pixels(); ++p) {
      std::int64_t last_us = whole.begin_us;
      bool first = true;
      for (const TrainEvent& event : trains.of(p)) {
        (event.on ? on_ : off_) += 1.0;
        // How long the first interval had lasted at the recording's start is unknown.
        add(pixels_[p], bin_of(event.t_us - last_us), event.on && !first, first);
        last_us = event.t_us;
        first = false;
      }
      add(pixels_[p], bin_of(whole.end_us - last_us), false, true);
    }
    likelihood_.resize(pixels_.size() * bins);
    set_leak_events(std::max(0.0, on_ - off_));
  }

  [[nodiscard]] std::size_t number() const { return number_; }

  /// The likelihood of each pixel for each period, relative to that of shot noise alone, when so many of the ON events come
  /// from leak.
  void set_leak_events(double count) {
    on_hz_ = std::max(0.5, on_ - count) / exposure_s_;
    for (std::size_t p = 0; p < pixels_.size(); ++p) {
      std::array<double, bins> logs{};
      double beyond = 0.0, largest = -1e300;
      for (std::size_t k = bins; k-- > 0;) {
        const Counts& counts = pixels_[p][k];
        logs[k] = counts.on * std::log(ratio(k)) + counts.other * std::log(0.5) + beyond * std::log(missed);
        beyond += counts.on + counts.other + counts.cut;
        largest = std::max(largest, logs[k]);
      }
      for (std::size_t k = 0; k < bins; ++k)
        likelihood_[p * bins + k] = static_cast<float>(std::exp(logs[k] - largest));
    }
  }

  [[nodiscard]] double log_likelihood(const std::array<float, bins>& share) const {
    double sum = 0.0;
    for (std::size_t p = 0; p < pixels_.size(); ++p) {
      const float* const row = &likelihood_[p * bins];
      float pixel = 0.0F;
      for (std::size_t k = 0; k < bins; ++k) pixel += row[k] * share[k];
      sum += std::log(std::max(1e-30, static_cast<double>(pixel)));
    }
    return sum;
  }

  /// Expected number of ON events that come from leak.
  [[nodiscard]] double leak_events(const std::array<float, bins>& share) const {
    double sum = 0.0;
    for (std::size_t p = 0; p < pixels_.size(); ++p) {
      double all = 1e-30, leak = 0.0;
      for (std::size_t k = 0; k < bins; ++k) {
        const double weight = static_cast<double>(likelihood_[p * bins + k]) * static_cast<double>(share[k]);
        all += weight;
        leak += weight * pixels_[p][k].on * (1.0 - 0.5 / ratio(k));
      }
      sum += leak / all;
    }
    return sum;
  }

 private:
  /// Intervals that end in a bin: with an ON event, with another one, at an end of the recording.
  struct Counts {
    float on = 0.0F, other = 0.0F, cut = 0.0F;
  };

  static void add(std::array<Counts, bins>& pixel, std::size_t bin, bool on, bool cut) {
    (cut ? pixel[bin].cut : (on ? pixel[bin].on : pixel[bin].other)) += 1.0F;
  }

  /// The density of ON events in the bin of the period, leak and shot noise, over that of shot noise alone.
  [[nodiscard]] double ratio(std::size_t bin) const {
    return 0.5 + 1.0 / (bin_width * std::exp(log_period(bin)) * on_hz_);
  }

  std::size_t number_;
  double exposure_s_ = 0.0, on_ = 0.0, off_ = 0.0, on_hz_ = 1.0;
  std::vector<std::array<Counts, bins>> pixels_;
  std::vector<float> likelihood_;  // pixels by bins
};

/// The share of pixels with each period.
std::array<float, bins> shares(double log_rate, double log_spread) {
  const double deviation = std::numbers::ln10 * std::exp(log_spread);
  const auto below = [&](double log_s) {
    return 0.5 * std::erfc(-(log_s + log_rate) / (deviation * std::numbers::sqrt2));
  };
  std::array<float, bins> share{};
  double last = 0.0;  // the first and the last bin have what lies outside
  for (std::size_t k = 0; k < bins; ++k) {
    const double next = k + 1 == bins ? 1.0 : below(log_period(k) + 0.5 * bin_width);
    share[k] = static_cast<float>(next - last);
    last = next;
  }
  return share;
}

struct Box {
  double low = 0.0, high = 0.0;
  std::size_t steps = 0;
  [[nodiscard]] double at(std::size_t i) const {
    return low + (high - low) * static_cast<double>(i) / static_cast<double>(steps - 1);
  }
};

/// The posterior distribution on a grid.
struct Posterior {
  Box rate, spread;
  std::vector<double> weight;  // 1 at its largest

  Posterior(Box of_rate, Box of_spread, std::span<const StillIntervals> still, const LeakPrior& prior)
      : rate(of_rate), spread(of_spread) {
    for (std::size_t i = 0; i < rate.steps; ++i) {
      for (std::size_t j = 0; j < spread.steps; ++j) {
        const double a = (rate.at(i) - std::log(prior.rate_hz)) / prior.rate_deviation;
        const double b = (spread.at(j) - std::log(prior.spread_decades)) / prior.spread_deviation;
        double log = -0.5 * (a * a + b * b);
        const std::array<float, bins> share = shares(rate.at(i), spread.at(j));
        for (const StillIntervals& s : still) log += s.log_likelihood(share);
        weight.push_back(log);
      }
    }
    const double largest = *std::max_element(weight.begin(), weight.end());
    for (double& w : weight) w = std::exp(w - largest);
  }

  /// Over the grid: what holds more than a negligible share, and one step around it.
  [[nodiscard]] std::array<Box, 2> support() const {
    std::array<std::size_t, 2> low{rate.steps, spread.steps}, high{0, 0};
    for (std::size_t n = 0; n < weight.size(); ++n) {
      if (weight[n] < std::exp(-negligible)) continue;
      const std::array<std::size_t, 2> at{n / spread.steps, n % spread.steps};
      for (std::size_t d = 0; d < 2; ++d) {
        low[d] = std::min(low[d], at[d] == 0 ? 0 : at[d] - 1);
        high[d] = std::max(high[d], at[d] + 1);
      }
    }
    return {Box{rate.at(low[0]), rate.at(std::min(high[0], rate.steps - 1)), 33},
            Box{spread.at(low[1]), spread.at(std::min(high[1], spread.steps - 1)), 21}};
  }
};

/// Mean and standard deviation of values with weights.
std::array<double, 2> moments(const Box& box, std::span<const double> weight) {
  double all = 0.0, mean = 0.0, square = 0.0;
  for (std::size_t i = 0; i < weight.size(); ++i) {
    all += weight[i];
    mean += weight[i] * box.at(i);
  }
  mean /= all;
  for (std::size_t i = 0; i < weight.size(); ++i)
    square += weight[i] * (box.at(i) - mean) * (box.at(i) - mean);
  const double step = (box.high - box.low) / static_cast<double>(box.steps - 1);
  return {mean, std::sqrt(square / all + step * step / 12.0)};
}

}  // namespace

LeakFit fit_leak(std::span<const SensorRecording> recordings, const LeakPrior& prior) {
  std::vector<StillIntervals> still;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    if (!recordings[r].stimulus().moves()) still.emplace_back(recordings[r], r);
  }
  LeakFit fit;
  fit.events.assign(recordings.size(), 0.0);
  const Box all_rates{std::log(1e-4), std::log(100.0), 70}, all_spreads{std::log(0.005), std::log(0.8), 12};
  constexpr int rounds = 3;  // each with the rate of shot noise that the last one left
  for (int round = 0; round < rounds; ++round) {
    const std::array<Box, 2> coarse = Posterior(all_rates, all_spreads, still, prior).support();
    const std::array<Box, 2> fine = Posterior(coarse[0], coarse[1], still, prior).support();
    const Posterior posterior(fine[0], fine[1], still, prior);
    std::vector<double> rates(fine[0].steps), spreads(fine[1].steps);
    for (std::size_t n = 0; n < posterior.weight.size(); ++n) {
      rates[n / spreads.size()] += posterior.weight[n];
      spreads[n % spreads.size()] += posterior.weight[n];
    }
    const auto [rate, rate_deviation] = moments(fine[0], rates);
    const auto [spread, spread_deviation] = moments(fine[1], spreads);
    fit.rate_hz = std::exp(rate);
    fit.rate_deviation = rate_deviation;
    fit.spread_decades = std::exp(spread);
    fit.spread_deviation = spread_deviation;
    double all = 0.0, below = 0.0;
    for (const double w : rates) all += w;
    for (std::size_t i = 0; i < rates.size() && below < 0.95 * all; ++i) {
      below += rates[i];
      fit.highest_rate_hz = std::exp(fine[0].at(i));
    }
    const std::array<float, bins> share = shares(rate, spread);
    for (StillIntervals& s : still) {
      fit.events[s.number()] = s.leak_events(share);
      s.set_leak_events(fit.events[s.number()]);
    }
  }
  return fit;
}

}  // namespace saccade
