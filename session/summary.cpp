#include "session/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "evaluation/report/report.h"

namespace saccade {
namespace {

std::string number(const std::optional<double>& value, const char* unit) {
  return value ? fmt::format("{:.3g}{}", *value, unit) : std::string("-");
}

/// Both scores of each detector of a simulated run.
void print_table(const Metrics& metrics) {
  std::size_t width = 10;
  for (const auto& [name, score] : metrics.detectors) width = std::max(width, name.size() + 2);
  fmt::print(
      "{:<{}} average precision          at the threshold     error    lag  ready after\n"
      "{:<{}} by event time  streaming   precision   recall   px       ms   ms\n",
      "", width, "detector", width);
  for (const auto& [name, score] : metrics.detectors) {
    const StreamingScore streaming = score.streaming.value_or(StreamingScore{});
    fmt::print("{:<{}} {:<13}  {:<9}   {:<9}   {:<6}   {:<6}   {:<4} {}\n", name, width,
               number(score.average_precision, ""), number(streaming.average_precision, ""),
               number(score.precision, ""), number(score.recall, ""),
               number(score.position_error_px.median, ""), number(score.lag_ms, ""),
               number(streaming.latency_median_ms, ""));
  }
  fmt::print(
      "by event time: judged at the instants of its events; streaming: at each instant the newest estimate "
      "that a robot could use\n");
  if (const std::optional<double> share = dropped_share(metrics))
    fmt::print("the event camera dropped {:.2g} % of its events\n", 100.0 * *share);
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
  fmt::print(
      "{}: average precision {}, precision {} and recall {} at its threshold, median error {}, lag {}\n",
      detector, number(score.average_precision, ""), number(score.precision, ""), number(score.recall, ""),
      number(score.position_error_px.median, " px"), number(score.lag_ms, " ms"));
}

void print_summary(const Metrics& metrics) {
  if (metrics.interrupted)
    fmt::print("interrupted after {:.3f} s: the figures are of what was processed until then\n",
               metrics.duration_s);
  fmt::print("{} events in {:.3f} s", metrics.event_count, metrics.duration_s);
  if (metrics.wall_s && metrics.duration_s > 0.0) {
    fmt::print(", {:.0f} per second; {:.2f} x real time",
               static_cast<double>(metrics.event_count) / metrics.duration_s,
               metrics.duration_s / *metrics.wall_s);
  }
  fmt::print("\n");
  if (const std::string warning = dropped_warning(metrics); !warning.empty())
    fmt::print(stderr, "saccade: warning: {}\n", warning);
  const bool simulated_ball =
      metrics.seed && std::ranges::any_of(metrics.detectors,
                                          [](const auto& detector) { return detector.second.chances > 0; });
  if (simulated_ball) {
    print_table(metrics);
  } else {
    for (const auto& [name, score] : metrics.detectors) print_summary(name, score);
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

void print_page(const std::filesystem::path& folder) {
  if (const std::string warning = undrawn_warning(); !warning.empty())
    fmt::print(stderr, "saccade: warning: {}\n", warning);
  fmt::print("{}\n", (folder / "report.html").string());
}

}  // namespace saccade
