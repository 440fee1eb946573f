#include "control/gaze_controller.h"

#include "control/ikingaze_controller.h"
#include "control/qp_controller.h"
#include "control/script_controller.h"

namespace saccade {
namespace {

constexpr double nearest_target_m = 0.10;

}  // namespace

TargetStatus check_gaze_target(const Eigen::Vector3d& target, const HeadKinematics& head) {
  if (!target.allFinite()) return TargetStatus::not_finite;
  if ((target - head.root_from_eye(Eye::left).translation()).norm() < nearest_target_m) {
    return TargetStatus::too_near;
  }
  if (!((target - head.point_on_axis(neck_pitch)).dot(head.chest_forward()) > 0.0))
    return TargetStatus::behind;
  return TargetStatus::ok;
}

void describe(FieldVisitor& v, FollowConfig& config) {
  v.choice("lost", config.lost, {"hold", "rest"}, "what the head does when the target is lost");
  v.real("start_s", config.start_s, {0.0, 3600.0}, "from when on the head follows what a detector finds");
  v.real("lost_after_s", config.lost_after_s, {0.01, 3600.0}, "the target is lost after so long without one");
}

void describe(FieldVisitor& v, QpConfig& config) {
  v.choice("eyes", config.eyes, {"both", "left"}, "whose optical axes go to the target");
  v.real("eye_time_constant_s", config.eye_time_constant_s, {0.005, 5.0}, "how fast the gaze error falls");
  v.real("neck_time_constant_s", config.neck_time_constant_s, {0.02, 20.0}, "how fast the neck takes over");
  v.real("right_eye_weight", config.right_eye_weight, {1e-4, 1.0}, "against the left eye's error");
  v.real("neck_weight", config.neck_weight, {1e-6, 1.0}, "of the neck's own motion");
  v.real("damping", config.damping, {1e-9, 1e-2}, "of every joint's velocity");
  v.real("target_time_constant_s", config.target_time_constant_s, {0.0, 2.0},
         "memory of the target's motion; 0: none, it is followed with a lag");
  v.real("max_lead_deg", config.max_lead_deg, {0.1, 60.0}, "reference ahead of the measured joint at most");
}

void describe(FieldVisitor& v, IkinGazeConfig& config) {
  v.choice("eyes", config.eyes, {"both", "left"}, "whose optical axes go to the target");
  v.real("neck_time_s", config.neck_time_s, {0.3, 20.0}, "how long the neck takes to the target");
  v.real("eyes_time_s", config.eyes_time_s, {0.1, 20.0}, "how long the eyes take");
  v.require(config.neck_time_s >= config.eyes_time_s + 0.2, "neck_time_s", text_of(config.neck_time_s),
            "at least 0.2 s more than eyes_time_s");
  v.boolean("saccades", config.saccades, "whether the eyes jump to what is far off");
  v.real("saccade_angle_deg", config.saccade_angle_deg, {1.0, 90.0}, "how far that is");
  v.real("saccade_interval_s", config.saccade_interval_s, {0.05, 60.0}, "between the starts of two jumps");
  v.real("min_tilt_deg", config.min_tilt_deg, {-90.0, 0.0}, "lowest tilt of the eyes");
  v.real("max_tilt_deg", config.max_tilt_deg, {0.0, 90.0}, "highest tilt of the eyes");
}

void describe(FieldVisitor& v, ScriptConfig& config) {
  v.points("eyes_deg", config.eyes_deg, 2, {-45.0, 45.0}, "tilt and version to go to in turn, for ever");
  v.require(!config.eyes_deg.empty(), "eyes_deg", "[]", "at least one point");
  v.points("neck_deg", config.neck_deg, 3, {-60.0, 60.0},
           "neck pitch, roll and yaw at the same time; none: the neck stays");
  v.require(config.neck_deg.empty() || config.neck_deg.size() == config.eyes_deg.size(), "neck_deg",
            std::to_string(config.neck_deg.size()) + " points",
            "none, or one for each of the " + std::to_string(config.eyes_deg.size()) + " points in eyes_deg");
  v.real("speed_deg_s", config.speed_deg_s, {0.1, 500.0},
         "mean speed of a move of least jerk, over all joints together");
  v.real("dwell_s", config.dwell_s, {0.001, 3600.0}, "rest at every point");
}

void describe(FieldVisitor& v, GazeControllerConfig& config) {
  v.choice("controller", config.controller, {"qp", "ikingaze", "script"}, "what moves the head");
  if (config.controller == "script") {
    v.section(
        "script", [&](FieldVisitor& w) { describe(w, config.script); }, "eyes that go their own way");
  } else if (config.controller == "ikingaze") {
    v.section(
        "ikingaze", [&](FieldVisitor& w) { describe(w, config.ikingaze); }, "the iCub's own controller");
  } else {
    v.section(
        "qp", [&](FieldVisitor& w) { describe(w, config.qp); }, "bounded velocity inverse kinematics");
  }
  v.section(
      "limits", [&](FieldVisitor& w) { describe(w, config.limits); }, "how briskly gaze may move");
}

std::unique_ptr<GazeController> make_gaze_controller(const GazeControllerConfig& config,
                                                     const JointLimits& hardware) {
  check_config("gaze", config);
  if (config.controller == "script") return std::make_unique<ScriptController>(config.script, hardware);
  if (config.controller == "ikingaze") {
    return std::make_unique<IkinGazeController>(config.ikingaze, motion_limits(hardware, config.limits));
  }
  return std::make_unique<QpController>(config.qp, motion_limits(hardware, config.limits));
}

}  // namespace saccade
