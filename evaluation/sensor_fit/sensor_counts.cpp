#include "evaluation/sensor_fit/sensor_counts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace saccade {

std::string missing(Needs needs) {
  switch (needs) {
    case Needs::contrast:
      return "no change of light of known contrast (panel, board, or disc with known_contrast)";
    case Needs::change:
      return "no change of light (panel, board or disc)";
    case Needs::trigger:
      return "no change of light at a known time (panel)";
    case Needs::still:
      return "no scene at rest (still)";
  }
  return {};
}

void fit_counts(const std::vector<SensorRecording>& recordings,
                const std::vector<SensorRecording::HotPixels>& hot, std::size_t hot_pixels, SensorFit& fit) {
  const auto put = [&](const char* key, double value, double prior, double deviation, bool identifiable,
                       std::string decided) {
    fit.parameters.push_back(
        {key, identifiable ? value : prior, prior, deviation, identifiable, std::move(decided)});
  };
  double rate_hz = 0.0;
  bool any_still = false;
  std::string names;
  double still_pixels = 0.0;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    if (recordings[r].stimulus().moves()) continue;
    any_still = true;
    rate_hz = std::max(rate_hz, hot[r].rate_hz);
    names += (names.empty() ? "" : ", ") + recordings[r].name();
    still_pixels = static_cast<double>(recordings[r].size().width) * recordings[r].size().height;
  }
  const auto count = static_cast<double>(hot_pixels);
  put("hot_pixel_share", any_still ? count / still_pixels : 0.0, fit.prior.hot_pixel_share,
      count > 0.0 ? 1.0 / std::sqrt(count) : 1.0, any_still,
      any_still ? fmt::format("{} ({} pixels)", names, hot_pixels) : missing(Needs::still));
  put("hot_pixel_rate_hz", rate_hz, fit.prior.hot_pixel_rate_hz, count > 0.0 ? 0.1 / std::sqrt(count) : 1.0,
      count > 0.0, count > 0.0 ? names : (any_still ? "no hot pixel" : missing(Needs::still)));
  double busy_hz = 0.0, highest_hz = 0.0;
  std::string busy;
  std::int64_t tick_us = 0;
  for (const SensorRecording& recording : recordings) {
    const SensorRecording::Readout readout = recording.readout();
    highest_hz = std::max(highest_hz, readout.rate_hz);
    if (readout.is_busy && readout.rate_hz > busy_hz) {
      busy_hz = readout.rate_hz;
      busy = recording.name();
    }
    tick_us = std::gcd(tick_us, recording.tick_us());
  }
  put("readout_rate_hz", busy_hz, fit.prior.readout_rate_hz, busy_hz > 0.0 ? 0.01 : 1.0, busy_hz > 0.0,
      busy_hz > 0.0
          ? busy + " (its fullest milliseconds)"
          : fmt::format(
                "no limit below {:.3g} events/s: the fullest millisecond holds that many, and the bus "
                "is not busy all through it",
                highest_hz));
  put("timestamp_resolution_us", static_cast<double>(tick_us),
      static_cast<double>(fit.prior.timestamp_resolution_us), 0.0, tick_us > 0,
      tick_us > 0 ? "the time stamps of all recordings" : "fewer than two events");
  for (const FittedParameter& p : fit.parameters) {
    if (p.key == "hot_pixel_share") fit.config.hot_pixel_share = p.value;
    if (p.key == "hot_pixel_rate_hz") fit.config.hot_pixel_rate_hz = p.value;
    if (p.key == "readout_rate_hz") fit.config.readout_rate_hz = p.value;
    if (p.key == "timestamp_resolution_us") fit.config.timestamp_resolution_us = std::llround(p.value);
  }
}

void correct_hot_rate(SensorFit& fit) {
  constexpr double most_blind = 0.9;  // share of the time: beyond that the correction is a guess
  for (FittedParameter& p : fit.parameters) {
    if (p.key != "hot_pixel_rate_hz" || !p.identifiable) continue;
    const double blind = p.value * static_cast<double>(fit.config.refractory_us) * 1e-6;
    p.value /= 1.0 - std::min(blind, most_blind);
    fit.config.hot_pixel_rate_hz = p.value;
  }
}

}  // namespace saccade
