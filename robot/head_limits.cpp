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

using HeadRanges = std::array<std::array<double, 2>*, head_joint_count>;

HeadRanges ranges_of(HeadLimitsConfig& config) {
  return {&config.neck_pitch_deg, &config.neck_roll_deg,    &config.neck_yaw_deg,
          &config.eyes_tilt_deg,  &config.eyes_version_deg, &config.eyes_vergence_deg};
}

}  // namespace

void describe(FieldVisitor& v, HeadLimitsConfig& config) {
  const HeadRanges ranges = ranges_of(config);
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const std::string key = std::string(joint_names[torso_joint_count + i]) + "_deg";
    std::array<double, 2>& range = *ranges[i];
    v.reals(key, range, {-180.0, 180.0}, "lowest and highest position");
    v.require(range[0] < range[1], key, "[" + text_of(range[0]) + ", " + text_of(range[1]) + "]",
              "the lower one first");
  }
}

JointLimits joint_limits(const HeadLimitsConfig& config) {
  check_config("limits", config);
  HeadLimitsConfig copy = config;
  JointLimits limits;
  limits.min_rad.setConstant(-std::numbers::pi);
  limits.max_rad.setConstant(std::numbers::pi);
  limits.max_speed_rad_s.setConstant(std::numeric_limits<double>::infinity());
  const HeadRanges ranges = ranges_of(copy);
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const auto j = static_cast<Eigen::Index>(torso_joint_count + i);
    limits.min_rad[j] = (*ranges[i])[0] * rad_per_deg;
    limits.max_rad[j] = (*ranges[i])[1] * rad_per_deg;
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
  for (int i = torso_joint_count; i < joint_count; ++i) {
    const std::string name(joint_names[static_cast<std::size_t>(i)]);
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
