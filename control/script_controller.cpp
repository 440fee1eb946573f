#include "control/script_controller.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "head/minimum_jerk.h"

namespace saccade {
void describe(FieldVisitor& v, ScriptConfig& config) {
  v.points("eyes_deg", config.eyes_deg, {-45.0, 45.0},
           "tilt and version of each point; the points repeat without end");
  v.require(!config.eyes_deg.empty(), "eyes_deg", "[]", "at least one point");
  v.points("neck_deg", config.neck_deg, {-60.0, 60.0},
           "neck pitch, roll and yaw of each point; empty: the neck stays");
  v.require(config.neck_deg.empty() || config.neck_deg.size() == config.eyes_deg.size(), "neck_deg",
            std::to_string(config.neck_deg.size()) + " points",
            "none, or one for each of the " + std::to_string(config.eyes_deg.size()) + " points in eyes_deg");
  v.real("speed_deg_s", config.speed_deg_s, {0.1, 500.0},
         "mean speed of a minimum-jerk movement, norm over all joints");
  v.real("dwell_s", config.dwell_s, {0.001, 3600.0}, "time at rest at every point");
}

ScriptController::ScriptController(const ScriptConfig& config, const MotionLimits& limits)
    : config_(config), min_rad_(limits.hardware_min_rad), max_rad_(limits.hardware_max_rad) {
  check_config("script", config);
  if (!limits.head->has_icub_gaze()) {
    throw InputError("gaze.controller", "script",
                     "qp: script moves tilt, version and a neck of three joints, and " + limits.head->name +
                         " has others");
  }
}

HeadJointVector ScriptController::step(const HeadState& state, const std::optional<Eigen::Vector3d>&,
                                       double dt_s) {
  if (!reference_rad_) {
    if (!is_reading(state.position_rad)) return HeadJointVector::Zero().cwiseMax(min_rad_).cwiseMin(max_rad_);
    reference_rad_ = state.head_position_rad().cwiseMax(min_rad_).cwiseMin(max_rad_);
    start_rad_ = from_rad_ = *reference_rad_;
    move_s_ = -config_.dwell_s;
  }
  const auto point_rad = [&](std::size_t i) {
    HeadJointVector point = start_rad_;
    point[head_index(eyes_tilt)] = config_.eyes_deg[i][0] * rad_per_deg;
    point[head_index(eyes_version)] = config_.eyes_deg[i][1] * rad_per_deg;
    for (std::size_t j = 0; !config_.neck_deg.empty() && j < neck_joint_count; ++j) {
      point[static_cast<Eigen::Index>(j)] = config_.neck_deg[i][j] * rad_per_deg;
    }
    return point;
  };
  const auto duration_s = [&] {
    return (point_rad(next_) - from_rad_).norm() / (config_.speed_deg_s * rad_per_deg);
  };
  move_s_ += bounded_step_s(dt_s);
  if (move_s_ >= duration_s() + config_.dwell_s) {
    move_s_ -= duration_s() + config_.dwell_s;
    from_rad_ = point_rad(next_);
    next_ = (next_ + 1) % config_.eyes_deg.size();
  }
  const double move_s = duration_s();
  const double share = move_s > 0.0 ? std::clamp(move_s_ / move_s, 0.0, 1.0) : 1.0;
  const HeadJointVector wanted_rad = from_rad_ + minimum_jerk(share) * (point_rad(next_) - from_rad_);
  reference_rad_ = wanted_rad.cwiseMax(min_rad_).cwiseMin(max_rad_);
  return *reference_rad_;
}

}  // namespace saccade
