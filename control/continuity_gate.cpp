#include "control/continuity_gate.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace saccade {
namespace {

constexpr double track_memory_s = 0.045;  // of a TargetTrack
constexpr double speed_memory_s = 0.5;    // a ball that swings is soon as fast again
constexpr double speed_margin = 1.5;      // it may accelerate unseen

double angle_deg(const Eigen::Vector3d& a_m, const Eigen::Vector3d& b_m, const Eigen::Vector3d& eye_m) {
  const Eigen::Vector3d a = a_m - eye_m;
  const Eigen::Vector3d b = b_m - eye_m;
  return std::atan2(a.cross(b).norm(), a.dot(b)) * deg_per_rad;
}

/// Of the larger distance to the smaller one.
double ratio(const Eigen::Vector3d& a_m, const Eigen::Vector3d& b_m, const Eigen::Vector3d& eye_m) {
  const double share = (a_m - eye_m).norm() / (b_m - eye_m).norm();
  return std::max(share, 1.0 / share);
}

}  // namespace

void describe(FieldVisitor& v, ContinuityGateConfig& config) {
  v.real("tolerance_deg", config.tolerance_deg, {0.01, 180.0},
         "largest angle between bearings of detections that agree");
  v.real("depth_ratio", config.depth_ratio, {1.0, 100.0},
         "largest ratio between distances of detections that agree");
  v.real(
      "growth_deg_s", config.growth_deg_s, {0.0, 1e4},
      "growth of the tolerance since the last target, or one and a half times the speed of the last targets "
      "where that is more");
  v.real("window_s", config.window_s, {0.001, 1.0}, "age up to which detections confirm a new place");
  v.integer("min_agreeing", config.min_agreeing, {1, 1000}, "number of detections that confirm a new place");
  v.real("forget_s", config.forget_s, {0.001, 60.0},
         "time without a detection near the last place after which the ball is lost");
  v.real("near_score", config.near_score, {0.0, 1.0},
         "share of the threshold from which on a score suffices near the predicted place; 1: the threshold "
         "holds");
  v.real("near_deg", config.near_deg, {0.01, 45.0},
         "largest angle between such a detection and the predicted place");
  v.real("near_s", config.near_s, {0.001, 60.0},
         "time without a detection at the threshold after which such detections count no more");
}

ContinuityGate::ContinuityGate(const ContinuityGateConfig& config, const TargetConfig& target)
    : LocatingGate(target),
      config_(config),
      window_us_(std::llround(config.window_s * 1e6)),
      forget_us_(std::llround(config.forget_s * 1e6)),
      track_(track_memory_s) {
  check_config("gaze.continuity_gate", config);
  if (config_.near_score < 1.0) predictor_.emplace(track_memory_s, true);
}

void ContinuityGate::advance(std::int64_t now_us) {
  if (now_us <= advanced_us_) return;
  if (advanced_us_ > 0) {
    const double dt_s = static_cast<double>(now_us - advanced_us_) * 1e-6;
    track_.advance(dt_s);
    fastest_rad_s_ *= std::exp(-dt_s / speed_memory_s);
    if (predictor_) predictor_->advance(dt_s);
  }
  advanced_us_ = now_us;
}

/// The target of a circle below the threshold that is where the ball is expected: in its direction, at the distance of the last
/// target, because a radius is not confirmed by a place. None while the targets move so fast that the prediction is not known to
/// near_deg.
std::optional<Eigen::Vector3d> ContinuityGate::near_prediction(std::int64_t now_us, const Estimate& estimate,
                                                               double threshold, const Camera& camera,
                                                               const Eigen::Isometry3d& root_from_cam) {
  const bool tracked = estimate.covariance_px2(0, 0) > 0.0;
  if (!predictor_ || !last_ || !tracked || !predictor_->is_known() ||
      !is_detection(estimate, config_.near_score * threshold))
    return std::nullopt;
  if (static_cast<double>(now_us - sure_us_) * 1e-6 > config_.near_s ||
      fastest_rad_s_ * deg_per_rad * track_memory_s > config_.near_deg)
    return std::nullopt;
  const auto point_m = locate(estimate.circle, camera, root_from_cam);
  if (!point_m ||
      !agree(*point_m, predictor_->predict(0.0).position_m, root_from_cam.translation(), config_.near_deg))
    return std::nullopt;
  const Eigen::Vector3d eye_m = root_from_cam.translation();
  return eye_m + (last_->point_m - eye_m).norm() * (*point_m - eye_m).normalized();
}

std::optional<Eigen::Vector3d> ContinuityGate::update(std::int64_t now_us, const Estimate& estimate,
                                                      double threshold, const Camera& camera,
                                                      const Eigen::Isometry3d& root_from_cam) {
  advance(now_us);
  if (!is_detection(estimate, threshold)) {
    auto expected_m = near_prediction(now_us, estimate, threshold, camera, root_from_cam);
    if (expected_m) accept({now_us, *expected_m}, root_from_cam.translation());
    return expected_m;
  }
  auto point_m = locate(estimate.circle, camera, root_from_cam);
  if (!point_m) return std::nullopt;
  const Eigen::Vector3d eye_m = root_from_cam.translation();
  const Place here{now_us, *point_m};
  recent_[count_++ % capacity] = here;

  if (last_ && now_us - last_->t_us <= forget_us_) {
    if (!can_have_reached(here, eye_m)) return std::nullopt;
  } else if (!confirmed(here, eye_m)) {
    return std::nullopt;
  }
  sure_us_ = now_us;
  accept(here, eye_m);
  return point_m;
}

/// In direction and distance. Another distance in a direction that the ball can have reached needs a confirmation: an outlier
/// of the radius does not move the target, and one that did does not keep the ball out.
bool ContinuityGate::can_have_reached(const Place& here, const Eigen::Vector3d& eye_m) const {
  const double unseen_s = static_cast<double>(here.t_us - last_->t_us) * 1e-6;
  const double growth_deg_s = std::max(config_.growth_deg_s, speed_margin * fastest_rad_s_ * deg_per_rad);
  const double grown_deg = growth_deg_s * unseen_s;
  if (angle_deg(here.point_m, last_->point_m, eye_m) > config_.tolerance_deg + grown_deg) return false;
  return ratio(here.point_m, last_->point_m, eye_m) <=
             config_.depth_ratio * std::exp(grown_deg / deg_per_rad) ||
         confirmed(here, eye_m);
}

void ContinuityGate::accept(const Place& here, const Eigen::Vector3d& eye_m) {
  last_ = here;
  track_.observe(here.point_m);
  const Eigen::Vector3d away_m = track_.position_m() - eye_m;
  fastest_rad_s_ =
      std::max(fastest_rad_s_, away_m.cross(track_.velocity_m_s()).norm() / away_m.squaredNorm());
  if (predictor_) predictor_->observe(here.point_m, 0.0);
}

bool ContinuityGate::confirmed(const Place& here, const Eigen::Vector3d& eye_m) const {
  std::int64_t agreeing = 0;
  for (std::size_t back = 1; back <= std::min(count_, capacity); ++back) {
    const Place& other = recent_[(count_ - back) % capacity];
    if (here.t_us - other.t_us > window_us_) break;
    agreeing += agree(here.point_m, other.point_m, eye_m, config_.tolerance_deg);
  }
  return agreeing >= config_.min_agreeing;
}

bool ContinuityGate::agree(const Eigen::Vector3d& a_m, const Eigen::Vector3d& b_m,
                           const Eigen::Vector3d& eye_m, double tolerance_deg) const {
  return angle_deg(a_m, b_m, eye_m) <= tolerance_deg && ratio(a_m, b_m, eye_m) <= config_.depth_ratio;
}

}  // namespace saccade
