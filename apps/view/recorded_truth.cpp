#include "apps/view/recorded_truth.h"

#include <algorithm>
#include <cmath>

#include "apps/view/sim_snapshot.h"

namespace saccade {
namespace {

constexpr std::int64_t annotation_us = 20'000;  ///< for how long an annotated circle is shown

/// The newest row up to t_us; null where it is older than `max_age_us`.
template <class Row>
const Row* row_at(const std::vector<Row>& rows, std::int64_t t_us, std::int64_t max_age_us) {
  const auto after = std::ranges::upper_bound(rows, t_us, {}, &Row::t_us);
  if (after == rows.begin() || std::prev(after)->t_us < t_us - max_age_us) return nullptr;
  return &*std::prev(after);
}

template <class Row>
std::vector<Row> rows_of(const std::filesystem::path& table) {
  return std::filesystem::exists(table) ? read_table<Row>(table) : std::vector<Row>{};
}

}  // namespace

void RecordedTruth::read_gaze(const std::filesystem::path& folder) {
  eye_rows_ = rows_of<EyeRow>(folder / "eye.csv");
  gaze_rows_ = rows_of<GazeRow>(folder / "gaze.csv");
}

SnapshotTruth RecordedTruth::at(std::int64_t t_us) const {
  SnapshotTruth shown;
  const TruthRow* circle = row_at(circles_, t_us, annotated_ ? annotation_us : 0);
  if (circle != nullptr && circle->visible > 0.0 && std::isfinite(circle->circle.r_px))
    shown.circle = circle->circle;
  const EyeRow* eye = row_at(eye_rows_, t_us, 0);
  if (eye == nullptr) return shown;
  shown.root_from_cam = eye->root_from_left_cam();
  if (circle != nullptr && circle->position_m.allFinite())
    shown.gaze_error_deg = gaze_error_deg(*shown.root_from_cam, circle->position_m);
  const GazeRow* gaze = row_at(gaze_rows_, t_us, 0);
  if (gaze != nullptr && gaze->target_m.allFinite()) {
    shown.target_m = gaze->target_m;
    shown.target_px = camera_.project(shown.root_from_cam->inverse() * gaze->target_m);
  }
  return shown;
}

std::optional<std::int64_t> RecordedTruth::last_us() const {
  return gaze_rows_.empty() ? std::nullopt : std::optional(gaze_rows_.back().t_us);
}

}  // namespace saccade
