#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string_view>

namespace saccade {

/// The joints of the iCub head in the order of the kinematic chain (iKin v2: torso pitch first).
/// Version and vergence are the coupled eye pans: left = version + vergence / 2,
/// right = version - vergence / 2. Signs: torso pitch + leans forward, torso yaw + turns right, neck
/// pitch and eyes tilt + look up, neck yaw + turns LEFT, eyes version + look RIGHT.
enum Joint : int {
  torso_pitch,
  torso_roll,
  torso_yaw,
  neck_pitch,
  neck_roll,
  neck_yaw,
  eyes_tilt,
  eyes_version,
  eyes_vergence,
};
inline constexpr int joint_count = 9;
inline constexpr int torso_joint_count = 3;
/// The joints that gaze commands: neck pitch to eyes vergence, the last six.
inline constexpr int head_joint_count = 6;
/// The first joints of gaze, those of the neck.
inline constexpr int neck_joint_count = 3;
/// The index of a joint among those that gaze commands.
[[nodiscard]] constexpr int head_index(Joint joint) { return joint - torso_joint_count; }

inline constexpr std::array<std::string_view, joint_count> joint_names = {
    "torso_pitch", "torso_roll", "torso_yaw",    "neck_pitch",   "neck_roll",
    "neck_yaw",    "eyes_tilt",  "eyes_version", "eyes_vergence"};

using JointVector = Eigen::Matrix<double, joint_count, 1>;
using HeadJointVector = Eigen::Matrix<double, head_joint_count, 1>;

/// Positions and velocities of all joints at one instant, from the encoders.
struct HeadState {
  std::int64_t t_us = 0;
  JointVector position_rad = JointVector::Zero();
  JointVector velocity_rad_s = JointVector::Zero();

  [[nodiscard]] HeadJointVector head_position_rad() const { return position_rad.tail<head_joint_count>(); }
};

[[nodiscard]] inline bool is_finite(const HeadState& state) {
  return state.position_rad.allFinite() && state.velocity_rad_s.allFinite();
}

/// Position range and maximum speed of every joint.
struct JointLimits {
  JointVector min_rad = JointVector::Zero();
  JointVector max_rad = JointVector::Zero();
  JointVector max_speed_rad_s = JointVector::Zero();
};

}  // namespace saccade
