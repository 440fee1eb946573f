#include "evaluation/scoring/eye_movement.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"

namespace saccade {

double angle_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180.0 / std::numbers::pi;
}

void SaccadeFinder::add(std::int64_t t_us, const Eigen::Vector3d& axis) {
  SACCADE_CHECK(!started_ || t_us > last_t_us_);
  if (started_) speed_deg_s_ = angle_deg(last_axis_, axis) * 1e6 / static_cast<double>(t_us - last_t_us_);
  if (started_ && speed_deg_s_ > Saccade::fast_deg_s) {
    stretch_.end_us = t_us;
    stretch_.amplitude_deg = angle_deg(start_axis_, axis);
    stretch_.peak_deg_s = std::max(stretch_.peak_deg_s, speed_deg_s_);
    if (!counted_ && stretch_.end_us - stretch_.start_us >= Saccade::shortest_us) {
      ++count_;
      counted_ = true;
    }
    if (counted_) newest_ = stretch_;
  } else {
    stretch_ = {.start_us = t_us, .end_us = t_us, .amplitude_deg = 0.0, .peak_deg_s = 0.0};
    start_axis_ = axis;
    counted_ = false;
  }
  started_ = true;
  last_t_us_ = t_us;
  last_axis_ = axis;
}

std::vector<Saccade> saccades_of(std::span<const EyeRow> eye) {
  SaccadeFinder finder;
  std::vector<Saccade> saccades;
  for (const EyeRow& row : eye) {
    finder.add(row.t_us, row.root_from_left_cam().linear().col(2));
    if (finder.count() > std::ssize(saccades)) saccades.emplace_back();
    if (!saccades.empty()) saccades.back() = finder.newest();
  }
  return saccades;
}

bool is_move(const std::optional<Eigen::Vector3d>& last_m, const Eigen::Vector3d& target_m) {
  return !last_m || (target_m - *last_m).norm() > 1e-3;
}

std::vector<Move> moves_of(std::span<const GazeRow> gaze) {
  std::vector<Move> moves;
  std::optional<Eigen::Vector3d> last_m;
  for (const GazeRow& row : gaze) {
    if (!row.target_m.allFinite() || !is_move(last_m, row.target_m)) continue;
    last_m = row.target_m;
    moves.push_back({row.t_us, row.target_m});
  }
  return moves;
}

namespace {

constexpr std::int64_t longest_shift_us = 800'000;
constexpr std::int64_t shifts_apart_us = 500'000;
constexpr double smallest_shift_deg = 1.0;
constexpr double arrived_share = 0.25;

double off_axis_deg(const EyeRow& eye, const Eigen::Vector3d& target_m) {
  return angle_deg(eye.root_from_left_cam().linear().col(2), target_m - eye.position_m);
}

std::int64_t arrival_us(std::span<const Move> later, std::span<const EyeRow> eye, double size_deg) {
  std::int64_t nearest_us = eye.front().t_us;
  double nearest_deg = size_deg;
  std::size_t newest = 0;
  for (const EyeRow& row : eye) {
    if (row.t_us > eye.front().t_us + longest_shift_us) break;
    while (newest + 1 < later.size() && later[newest + 1].t_us <= row.t_us) ++newest;
    const double off_deg = off_axis_deg(row, later[newest].target_m);
    if (off_deg >= nearest_deg) continue;
    nearest_deg = off_deg;
    nearest_us = row.t_us;
    if (off_deg <= arrived_share * size_deg) break;
  }
  return nearest_us;
}

}  // namespace

std::vector<GazeShift> largest_gaze_shifts(std::span<const GazeRow> gaze, std::span<const EyeRow> eye,
                                           std::size_t count) {
  struct Candidate {
    std::size_t move;
    std::size_t row;  // of `eye`
    double size_deg;
  };
  const std::vector<Move> moves = moves_of(gaze);
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < moves.size(); ++i) {
    const auto at = std::lower_bound(eye.begin(), eye.end(), moves[i].t_us,
                                     [](const EyeRow& row, std::int64_t t_us) { return row.t_us < t_us; });
    if (at == eye.end() || at->t_us != moves[i].t_us) continue;
    const double size_deg = off_axis_deg(*at, moves[i].target_m);
    if (size_deg >= smallest_shift_deg)
      candidates.push_back({i, static_cast<std::size_t>(at - eye.begin()), size_deg});
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.size_deg > b.size_deg; });
  std::vector<GazeShift> shifts;
  for (const Candidate& c : candidates) {
    if (shifts.size() == count) break;
    const std::int64_t start_us = moves[c.move].t_us;
    const bool apart = std::all_of(shifts.begin(), shifts.end(), [&](const GazeShift& s) {
      return std::abs(s.start_us - start_us) >= shifts_apart_us;
    });
    if (!apart) continue;
    shifts.push_back(
        {start_us, arrival_us(std::span(moves).subspan(c.move), eye.subspan(c.row), c.size_deg)});
  }
  std::sort(shifts.begin(), shifts.end(),
            [](const GazeShift& a, const GazeShift& b) { return a.start_us < b.start_us; });
  return shifts;
}

}  // namespace saccade
