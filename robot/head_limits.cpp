#include "robot/head_limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "core/units.h"

namespace saccade {
namespace {

double rounded_deg(double rad) { return std::round(rad * deg_per_rad * 1e9) / 1e9; }

}  // namespace

HeadLimitsConfig::HeadLimitsConfig(std::shared_ptr<const HeadModel> model) : head(std::move(model)) {
  for (const HeadJoint& joint : head->joints) {
    if (joint.role == JointRole::torso) continue;
    range_deg[static_cast<std::size_t>(joint.slot - torso_slots)] = {rounded_deg(joint.min_rad),
                                                                     rounded_deg(joint.max_rad)};
  }
}

void describe(FieldVisitor& v, HeadLimitsConfig& config) {
  for (const HeadJoint& joint : config.head->joints) {
    if (joint.role == JointRole::torso) continue;
    const std::string key = joint.name + "_deg";
    std::array<double, 2>& range = config.range_deg[static_cast<std::size_t>(joint.slot - torso_slots)];
    v.reals(key, range, {-360.0, 360.0}, "lowest and highest position");
    v.require(range[0] < range[1], key, "[" + text_of(range[0]) + ", " + text_of(range[1]) + "]",
              "the lower one first");
  }
}

JointLimits joint_limits(const HeadLimitsConfig& config) {
  check_config("limits", config);
  JointLimits limits;
  limits.head = config.head;
  limits.min_rad.setConstant(-std::numbers::pi);
  limits.max_rad.setConstant(std::numbers::pi);
  limits.max_speed_rad_s.setConstant(std::numeric_limits<double>::infinity());
  for (int i = 0; i < config.head->gaze_joints(); ++i) {
    const auto [min_deg, max_deg] = config.range_deg[static_cast<std::size_t>(i)];
    limits.min_rad[torso_slots + i] = min_deg * rad_per_deg;
    limits.max_rad[torso_slots + i] = max_deg * rad_per_deg;
  }
  return limits;
}

CommonLimits common_limits(const JointLimits& ours, const JointLimits& robot) {
  constexpr double least_range_rad = 1.0 * rad_per_deg;
  constexpr double tolerance_rad = 0.01 * rad_per_deg;
  const auto text = [](double min_rad, double max_rad) {
    const auto deg = [](double rad) { return text_of(std::round(rad * deg_per_rad * 100.0) / 100.0); };
    return deg(min_rad) + " to " + deg(max_rad);
  };
  CommonLimits common{ours, {"limits of the joints, deg", true, {}}};
  std::string narrowed, broken;
  for (const HeadJoint& joint : ours.head->joints) {
    if (joint.role == JointRole::torso) continue;
    const int i = joint.slot;
    const std::string& name = joint.name;
    double& min_rad = common.limits.min_rad[i];
    double& max_rad = common.limits.max_rad[i];
    min_rad = std::max(ours.min_rad[i], robot.min_rad[i]);
    max_rad = std::min(ours.max_rad[i], robot.max_rad[i]);
    const bool is_range = std::isfinite(robot.min_rad[i]) && std::isfinite(robot.max_rad[i]) &&
                          max_rad - min_rad >= least_range_rad;
    if (!is_range) {
      broken += (broken.empty() ? "" : ", ") + name + " " + text(robot.min_rad[i], robot.max_rad[i]) +
                " of the robot, " + text(ours.min_rad[i], ours.max_rad[i]) + " configured";
      min_rad = ours.min_rad[i];
      max_rad = ours.max_rad[i];
    } else if (min_rad > ours.min_rad[i] + tolerance_rad || max_rad < ours.max_rad[i] - tolerance_rad) {
      narrowed += (narrowed.empty() ? "" : ", ") + name + " " + text(min_rad, max_rad);
    }
  }
  common.check.passed = broken.empty();
  common.check.found = !broken.empty()    ? "no common range of 1 deg: " + broken
                       : narrowed.empty() ? "the configured ones"
                                          : "the configured ones, narrowed by the robot: " + narrowed;
  return common;
}

}  // namespace saccade
