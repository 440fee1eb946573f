#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "recording/run_files.h"

namespace saccade {

/// A saccade: 10 ms or more in which the eye turns faster than 60 deg/s.
struct Saccade {
  static constexpr double fast_deg_s = 60.0;
  static constexpr std::int64_t shortest_us = 10'000;

  std::int64_t start_us = 0;
  std::int64_t end_us = 0;
  double amplitude_deg = 0.0;  ///< between where the eye looked at its start and at its end
  double peak_deg_s = 0.0;
};

/// Finds saccades in the directions of an eye's optical axis, step by step, in fixed memory.
class SaccadeFinder {
 public:
  /// `axis`: the optical axis, root frame, unit length. Time goes forward.
  void add(std::int64_t t_us, const Eigen::Vector3d& axis);
  /// How fast the eye turned in the newest step; 0 before there is one.
  [[nodiscard]] double speed_deg_s() const { return speed_deg_s_; }
  /// How many there were so far, with the one that has not ended.
  [[nodiscard]] std::int64_t count() const { return count_; }
  /// The newest one; one that has not ended is as long as it is now. There is one where count() is above 0.
  [[nodiscard]] const Saccade& newest() const { return newest_; }

 private:
  bool started_ = false;
  std::int64_t last_t_us_ = 0;
  Eigen::Vector3d last_axis_ = Eigen::Vector3d::Zero();
  double speed_deg_s_ = 0.0;
  Saccade stretch_;  // the fast motion that goes on, or its start where the eye is slow
  Eigen::Vector3d start_axis_ = Eigen::Vector3d::Zero();
  bool counted_ = false;  // it is newest_
  std::int64_t count_ = 0;
  Saccade newest_;
};

[[nodiscard]] std::vector<Saccade> saccades_of(std::span<const EyeRow> eye);

/// A gaze target more than 1 mm from the target of the last move (the first target is one).
struct Move {
  std::int64_t t_us = 0;
  Eigen::Vector3d target_m = Eigen::Vector3d::Zero();  ///< root frame
};
[[nodiscard]] bool is_move(const std::optional<Eigen::Vector3d>& last_m, const Eigen::Vector3d& target_m);
[[nodiscard]] std::vector<Move> moves_of(std::span<const GazeRow> gaze);

/// A target far off the optical axis, and the eye's way there.
struct GazeShift {
  std::int64_t start_us = 0;  ///< of the move
  /// When the axis first was within a quarter of that angle of the newest target, or nearest to it within 0.8 s.
  std::int64_t end_us = 0;
};
/// The `count` moves whose targets lay farthest off the axis, at least 1 deg and half a second apart, in the order of
/// their time. Moves without a row of `eye` at their time are left out.
[[nodiscard]] std::vector<GazeShift> largest_gaze_shifts(std::span<const GazeRow> gaze,
                                                         std::span<const EyeRow> eye, std::size_t count);

/// The angle between two directions of any length, deg.
[[nodiscard]] double angle_deg(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

}  // namespace saccade
