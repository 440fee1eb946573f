#include "evaluation/scoring/gaze_scorer.h"

#include <cmath>

#include "core/config.h"
#include "core/error.h"
#include "core/units.h"

namespace saccade {
namespace {

constexpr double on_target_deg = 2.0;
constexpr std::int64_t acquire_hold_us = 100'000;
constexpr double ball_motion_m = 1e-4;
constexpr double wrong_move_px = 6.0;
constexpr double limit_tolerance_rad = 0.01 / deg_per_rad;

bool inside_image(const Eigen::Vector2d& pixel, ImageSize size) {
  return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() < size.width - 0.5 &&
         pixel.y() < size.height - 0.5;
}

}  // namespace

bool is_wrong_move(const Camera& camera, const Eigen::Isometry3d& root_from_left_cam,
                   const Eigen::Vector3d& target_m, const Eigen::Vector3d& ball_m) {
  const Eigen::Isometry3d left_cam_from_root = root_from_left_cam.inverse();
  const auto target_px = camera.project(left_cam_from_root * target_m);
  const auto ball_px = camera.project(left_cam_from_root * ball_m);
  return !target_px || !ball_px || (*target_px - *ball_px).norm() > wrong_move_px;
}

GazeScorer::GazeScorer(const GazeScoringConfig& config, std::size_t max_exact)
    : config_(config), errors_deg_(max_exact), target_errors_m_(max_exact) {
  check_config("camera", config_.camera);
  if (!Range{1e-6, std::numbers::pi}.contains(config_.acquire_within_rad)) {
    throw InputError("gaze scoring: acquire_within_rad", text_of(config_.acquire_within_rad),
                     "an angle in (0, pi]");
  }
}

void GazeScorer::add(const GazeSample& sample) {
  SACCADE_CHECK(!started_ || sample.t_us > last_t_us_);
  follow_ball(sample);
  follow_target(sample);
  saccades_.add(sample.t_us, sample.root_from_left_cam.linear().col(2));
  follow_joints(sample);
  started_ = true;
  last_t_us_ = sample.t_us;
}

void GazeScorer::restart(std::int64_t t_us) {
  motion_start_us_ = t_us;
  acquired_ = false;
  hold_start_us_.reset();
  errors_deg_.clear();
  on_target_ = 0;
  in_view_ = 0;
}

void GazeScorer::follow_ball(const GazeSample& sample) {
  if (!started_) {
    first_ball_m_ = sample.ball_m;
    restart(sample.t_us);
  } else if (!ball_moved_ && (sample.ball_m - first_ball_m_).norm() > ball_motion_m) {
    ball_moved_ = true;
    restart(sample.t_us);
  }

  const Eigen::Vector3d ball_cam_m = sample.root_from_left_cam.inverse() * sample.ball_m;
  fixation_error_rad_ = angle_deg(Eigen::Vector3d::UnitZ(), ball_cam_m) / deg_per_rad;
  if (!acquired_ && fixation_error_rad_ > config_.acquire_within_rad) {
    restart(motion_start_us_);
    return;
  }
  if (!hold_start_us_) {
    hold_start_us_ = sample.t_us;
  }
  acquired_ = acquired_ || sample.t_us - *hold_start_us_ >= acquire_hold_us;
  const double error_deg = fixation_error_rad_ * deg_per_rad;
  const auto pixel = config_.camera.project(ball_cam_m);
  errors_deg_.add(error_deg);
  on_target_ += error_deg <= on_target_deg ? 1 : 0;
  in_view_ += pixel && inside_image(*pixel, config_.camera.size) ? 1 : 0;
}

void GazeScorer::follow_target(const GazeSample& sample) {
  if (!sample.target_m || !is_move(last_target_m_, *sample.target_m)) return;
  last_target_m_ = sample.target_m;
  wrong_moves_ +=
      is_wrong_move(config_.camera, sample.root_from_left_cam, *sample.target_m, sample.ball_m) ? 1 : 0;
  target_errors_m_.add((*sample.target_m - sample.ball_m).norm());
}

void GazeScorer::follow_joints(const GazeSample& sample) {
  const JointVector& q = sample.plant_position_rad;
  const bool outside = ((config_.limits.min_rad - q).array() > limit_tolerance_rad).any() ||
                       ((q - config_.limits.max_rad).array() > limit_tolerance_rad).any();
  limit_violations_ += outside ? 1 : 0;
}

GazeScore GazeScorer::score() const {
  GazeScore score;
  score.acquire_within_deg = std::round(config_.acquire_within_rad * deg_per_rad * 1e9) / 1e9;
  score.moves = target_errors_m_.count();
  score.wrong_moves = wrong_moves_;
  score.saccades = saccades_.count();
  score.limit_violations = limit_violations_;
  score.target_error_median_m = target_errors_m_.at(0.5);
  score.exact = errors_deg_.exact() && target_errors_m_.exact();
  if (acquired_) {
    const auto samples = static_cast<double>(errors_deg_.count());
    score.acquire_s = static_cast<double>(*hold_start_us_ - motion_start_us_) * 1e-6;
    score.acquired_at_us = hold_start_us_;
    score.fixation_error_deg = errors_deg_.percentiles();
    score.on_target_ratio = static_cast<double>(on_target_) / samples;
    score.in_view_ratio = static_cast<double>(in_view_) / samples;
  }
  return score;
}

}  // namespace saccade
