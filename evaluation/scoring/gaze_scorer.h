#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <numbers>
#include <optional>

#include "core/camera.h"
#include "evaluation/scoring/eye_movement.h"
#include "evaluation/scoring/statistics.h"
#include "head/head_state.h"

namespace saccade {

/// The true state of plant and ball after a tick, and the gaze target then.
struct GazeSample {
  std::int64_t t_us = 0;
  /// The plant's left camera (the controller's own estimate of it may differ).
  Eigen::Isometry3d root_from_left_cam = Eigen::Isometry3d::Identity();
  Eigen::Vector3d ball_m = Eigen::Vector3d::Zero();  ///< root frame
  /// The newest gaze target handed to the controller, root frame; none before the first.
  std::optional<Eigen::Vector3d> target_m;
  JointVector plant_position_rad = JointVector::Zero();
};

struct GazeScoringConfig {
  Camera camera;
  JointLimits limits;
  /// The ball counts as acquired within this angle.
  double acquire_within_rad = 2.0 * std::numbers::pi / 180.0;
};

/// The figures of the gaze in metrics.json. None = does not apply: never acquired, no target.
struct GazeScore {
  double acquire_within_deg = 2.0;
  /// From the ball's first motion (from the first sample when it never moves) to the start of the first 100
  /// ms on end within acquire_within_deg.
  std::optional<double> acquire_s;
  std::optional<std::int64_t> acquired_at_us;  ///< that start, in the clock of the samples
  /// From that start to the last sample: the angle at the left eye between its optical axis and the ball's
  /// centre, the share of samples below 2 deg, the share with the ball's centre inside the image.
  Percentiles fixation_error_deg;
  std::optional<double> on_target_ratio;
  std::optional<double> in_view_ratio;
  /// Over the whole run; see Move and is_wrong_move.
  std::int64_t moves = 0;
  std::int64_t wrong_moves = 0;
  std::int64_t saccades = 0;          ///< see Saccade
  std::int64_t limit_violations = 0;  ///< samples with a joint more than 0.01 deg outside its limits
  /// Distance of a move's target from the ball's centre at that moment.
  std::optional<double> target_error_median_m;
  /// False where a run was so long that percentiles are approximated (QuantileCounter).
  bool exact = true;
};

/// A move is wrong when its target, projected through the true camera at that moment, is more than 6 px from the ball's
/// projected centre, or either is not in front of the camera. Points in the root frame.
[[nodiscard]] bool is_wrong_move(const Camera& camera, const Eigen::Isometry3d& root_from_left_cam,
                                 const Eigen::Vector3d& target_m, const Eigen::Vector3d& ball_m);

/// Scores the gaze sample by sample while the run goes on, in bounded memory: 8 bytes per sample and per move as long as
/// the percentiles are exact (QuantileCounter), fixed beyond that. Counts and ratios are always exact.
class GazeScorer {
 public:
  /// Throws InputError for a camera that is none or acquire_within_rad outside (0, pi].
  explicit GazeScorer(const GazeScoringConfig& config, std::size_t max_exact = max_exact_values);

  /// One sample per tick, time going forward.
  void add(const GazeSample& sample);
  [[nodiscard]] GazeScore score() const;
  /// The angle of the newest sample; 0 before any.
  [[nodiscard]] double fixation_error_rad() const { return fixation_error_rad_; }
  /// Since when the gaze is on target without a break, or since when it has acquired the ball; none where neither.
  [[nodiscard]] std::optional<std::int64_t> held_since_us() const { return hold_start_us_; }

 private:
  void follow_ball(const GazeSample& sample);
  void follow_target(const GazeSample& sample);
  void follow_joints(const GazeSample& sample);
  void restart(std::int64_t t_us);

  GazeScoringConfig config_;
  double fixation_error_rad_ = 0.0;

  bool started_ = false;
  bool ball_moved_ = false;
  Eigen::Vector3d first_ball_m_ = Eigen::Vector3d::Zero();
  std::int64_t motion_start_us_ = 0;

  /// The samples on target that are or may become the acquisition, and all after it.
  bool acquired_ = false;
  std::optional<std::int64_t> hold_start_us_;
  QuantileCounter errors_deg_;
  std::int64_t on_target_ = 0;
  std::int64_t in_view_ = 0;

  std::optional<Eigen::Vector3d> last_target_m_;
  QuantileCounter target_errors_m_;
  std::int64_t wrong_moves_ = 0;

  std::int64_t last_t_us_ = 0;
  SaccadeFinder saccades_;
  std::int64_t limit_violations_ = 0;
};

}  // namespace saccade
