#include "apps/session/summary.h"

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace saccade {

namespace {

std::string number(const std::optional<double>& value, const char* unit) {
  return value ? fmt::format("{:.3g}{}", *value, unit) : std::string("-");
}

}  // namespace

void print_summary(const std::string& detector, const DetectorScore& score) {
  if (score.chances == 0) {
    if (std::isnan(score.threshold)) {
      fmt::print("{}: no chance to find a ball\n", detector);
    } else {
      fmt::print("{}: {} observations at or above its threshold", detector, score.observations);
      if (score.alarm_ratio) fmt::print(", in {:.3g} % of the instants", 100.0 * *score.alarm_ratio);
      fmt::print("\n");
    }
    return;
  }
  fmt::print("{}: average precision {}", detector, number(score.average_precision, ""));
  if (score.streaming && score.streaming->average_precision != score.average_precision)
    fmt::print(" (streaming {})", number(score.streaming->average_precision, ""));
  fmt::print(", precision {} and recall {} at its threshold, median error {}, lag {}\n",
             number(score.precision, ""), number(score.recall, ""),
             number(score.position_error_px.median, " px"), number(score.lag_ms, " ms"));
}

void print_summary(const Metrics& metrics) {
  fmt::print("{} events in {:.3f} s", metrics.event_count, metrics.duration_s);
  if (metrics.wall_s && metrics.duration_s > 0.0) {
    fmt::print(", {:.0f} per second; {:.2f} x real time",
               static_cast<double>(metrics.event_count) / metrics.duration_s,
               metrics.duration_s / *metrics.wall_s);
  }
  fmt::print("\n");
  for (const auto& [name, score] : metrics.detectors) print_summary(name, score);
  if (metrics.gaze) {
    const GazeScore& gaze = metrics.gaze->score;
    fmt::print(
        "gaze: acquired after {}, in view {}, median error {}, {} moves of which {} wrong, {} limit "
        "violations\n",
        number(gaze.acquire_s, " s"), number(gaze.in_view_ratio, ""),
        number(gaze.fixation_error_deg.median, " deg"), gaze.moves, gaze.wrong_moves, gaze.limit_violations);
  }
}

}  // namespace saccade
