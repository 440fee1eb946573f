#include "apps/session/summary.h"

#include <fmt/format.h>

#include <string>

namespace saccade {

void print_summary(const Metrics& metrics) {
  const auto number = [](const std::optional<double>& value, const char* unit) {
    return value ? fmt::format("{:.3g}{}", *value, unit) : std::string("-");
  };
  fmt::print("{} events in {:.3f} s", metrics.event_count, metrics.duration_s);
  if (metrics.wall_s && metrics.duration_s > 0.0) {
    fmt::print(", {:.0f} per second; {:.2f} x real time",
               static_cast<double>(metrics.event_count) / metrics.duration_s,
               metrics.duration_s / *metrics.wall_s);
  }
  fmt::print("\n");
  for (const auto& [name, score] : metrics.detectors) {
    if (score.chances == 0) {
      fmt::print("{}: {} observations at or above its threshold\n", name, score.observations);
      continue;
    }
    fmt::print(
        "{}: average precision {}, precision {} and recall {} at its threshold, median error {}, lag {}\n",
        name, number(score.average_precision, ""), number(score.precision, ""), number(score.recall, ""),
        number(score.position_error_px.median, " px"), number(score.lag_ms, " ms"));
  }
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
