#include "robot/head_limits.h"

#include <array>
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

}  // namespace saccade
