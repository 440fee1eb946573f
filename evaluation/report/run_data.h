#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/event.h"
#include "evaluation/report/figures.h"
#include "evaluation/scoring/metrics.h"
#include "recording/run_files.h"

namespace saccade {

class FormatRegistry;

/// Reads what the report of a run shows.

inline constexpr std::size_t events_per_shift = 1'500;  ///< of the last shift_window_us at most
inline constexpr std::int64_t shift_window_us = 100'000;
inline constexpr std::int64_t image_window_us = 10'000;

/// A detector's Hough space at one instant.
struct SavedResponse {
  std::filesystem::path path;
  double strongest = 0.0;  ///< the response that is drawn white
};

/// The images and events of one instant.
struct Frame {
  std::int64_t t_us = 0;
  std::filesystem::path eye;  ///< path of a saved image; empty where the run saved none
  std::filesystem::path right_eye;
  std::filesystem::path scene;
  std::map<std::size_t, SavedResponse> responses;  ///< by the detector's index in the metrics
  std::vector<Event> events;
  std::vector<Event> other_events;  ///< the other eye's, where there is one
};

/// A run folder: its metrics, its tables, and the events around the instants that the report shows.
struct RunData {
  std::filesystem::path folder;
  std::filesystem::path paper;  ///< FigureFolder::paper
  Metrics metrics;
  std::vector<TruthRow> truth;
  std::vector<TruthRow> right_truth;
  std::vector<DetectionRow> detections;
  std::vector<GazeRow> gaze;
  std::vector<EyeRow> eye;
  std::vector<Frame> frames;
  std::vector<Frame> shifts;  ///< two for each of the largest gaze shifts: where it starts and where it ends
  bool has_images = false;
  std::int64_t window_us = image_window_us;  ///< of the events shown in a frame
  std::optional<EventCounts> event_counts;
  std::string events_remark;  ///< why events are not shown
  /// Per detector and row of truth, from found_at_chances(); empty where the truth is sparse or missing.
  std::vector<std::vector<std::optional<bool>>> found;

  /// True for annotations of a recording, which are not one row per millisecond and have no position in the world.
  [[nodiscard]] bool sparse_truth() const {
    return !truth.empty() && !std::isfinite(truth.front().position_m.x());
  }
  [[nodiscard]] bool scored_every_ms() const { return !found.empty(); }
};

/// Throws InputError for a broken metrics.json or table; an event file that cannot be read leaves a remark.
[[nodiscard]] RunData load_run(const std::filesystem::path& folder, const FormatRegistry& formats);

/// At most `count` of the elements, evenly spaced, with both ends.
template <class T>
std::vector<T> evenly_spaced(const std::vector<T>& all, std::size_t count) {
  if (all.size() <= count) return all;
  std::vector<T> some;
  for (std::size_t i = 0; i < count; ++i) some.push_back(all[i * (all.size() - 1) / (count - 1)]);
  return some;
}

/// The rows of a table, none where the file does not exist. Throws InputError for a broken table.
template <class Row>
std::vector<Row> read_table_if_there(const std::filesystem::path& path) {
  return std::filesystem::exists(path) ? read_table<Row>(path) : std::vector<Row>{};
}

/// Every how many ms the report of so long a run has rows: 1 up to 262 s, then so that at most 2^18 instants remain.
[[nodiscard]] std::int64_t report_step_ms(double duration_s);

/// As read_table_if_there, but only the rows whose time after `start_us` is, in whole ms, a multiple of `step_ms`: tables of
/// the same run keep the same instants, in bounded memory.
template <class Row>
std::vector<Row> read_thinned_table(const std::filesystem::path& path, std::int64_t start_us,
                                    std::int64_t step_ms) {
  std::vector<Row> rows;
  if (!std::filesystem::exists(path)) return rows;
  TableReader<Row> reader(path);
  while (std::optional<Row> row = reader.next()) {
    if ((row->t_us - start_us) / 1000 % step_ms == 0) rows.push_back(std::move(*row));
  }
  return rows;
}

}  // namespace saccade
