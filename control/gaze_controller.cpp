#include "control/gaze_controller.h"

namespace saccade {
namespace {

constexpr double nearest_target_m = 0.10;

}  // namespace

TargetStatus check_gaze_target(const Eigen::Vector3d& target, const HeadKinematics& head) {
  if (!target.allFinite()) return TargetStatus::not_finite;
  // Before any sum of squares, which overflows.
  if (target.cwiseAbs().maxCoeff() > farthest_target_m) return TargetStatus::too_far;
  const double distance_m = (target - head.root_from_eye(Eye::left).translation()).norm();
  if (distance_m < nearest_target_m) return TargetStatus::too_near;
  if (distance_m > farthest_target_m) return TargetStatus::too_far;
  if (!((target - head.neck_base_m()).dot(head.chest_forward()) > 0.0)) return TargetStatus::behind;
  return TargetStatus::ok;
}

void describe(FieldVisitor& v, FollowConfig& config) {
  v.choice("lost", config.lost,
           "motion of the head when the target is lost: keeps looking there, returns to its neutral pose, or "
           "looks "
           "around until it is found again");
  v.real("start_s", config.start_s, {0.0, 3600.0}, "time from which on the head follows detections");
  v.real("lost_after_s", config.lost_after_s, {0.01, 3600.0}, "time without a target after which it is lost");
  v.real("search_dwell_s", config.search_dwell_s, {0.2, 60.0},
         "time at each point of a search (lost: search)");
  v.section("delay", config.delay, "delays between light and motion that are compensated");
  v.section("stabilisation", config.stabilisation, "motion of the body that the eyes compensate");
  v.section("fixational", config.fixational, "small eye movements around a target that makes no events");
  v.boolean("detect_hunting", config.detect_hunting,
            "whether the time constants of the controller grow by half, up to four times, whenever the head "
            "oscillates");
}

}  // namespace saccade
