#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <string_view>

namespace saccade {

struct HeadModel;

/// The slots of the joints of an iCub head in a JointVector, in the order of the kinematic chain (torso pitch first).
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
/// Slots of a JointVector: first those of the torso, then those of the joints that gaze commands, neck before eyes. A head
/// has at most as many joints of each kind (HeadModel); the slots that it does not use are 0.
inline constexpr int torso_slots = 3;
inline constexpr int gaze_slots = 12;
inline constexpr int joint_slots = torso_slots + gaze_slots;
/// The joints of the iCub: all of them, those of the torso, those that gaze commands, and the first of these, the neck's.
inline constexpr int joint_count = 9;
inline constexpr int torso_joint_count = 3;
inline constexpr int head_joint_count = 6;
inline constexpr int neck_joint_count = 3;
/// The index of a joint among those that gaze commands.
[[nodiscard]] constexpr int head_index(Joint joint) { return joint - torso_slots; }

/// Their names, in the order of Joint.
inline constexpr std::array<std::string_view, joint_count> joint_names = {
    "torso_pitch", "torso_roll", "torso_yaw",    "neck_pitch",   "neck_roll",
    "neck_yaw",    "eyes_tilt",  "eyes_version", "eyes_vergence"};

using JointVector = Eigen::Matrix<double, joint_slots, 1>;
using HeadJointVector = Eigen::Matrix<double, gaze_slots, 1>;  ///< the joints that gaze commands

/// Positions and velocities of all joints at one instant, from the encoders.
struct HeadState {
  std::int64_t t_us = 0;
  JointVector position_rad = JointVector::Zero();
  JointVector velocity_rad_s = JointVector::Zero();

  [[nodiscard]] HeadJointVector head_position_rad() const { return position_rad.tail<gaze_slots>(); }
};

[[nodiscard]] inline bool is_finite(const HeadState& state) {
  return state.position_rad.allFinite() && state.velocity_rad_s.allFinite();
}

/// The head that everything has unless something else is given: the iCub's, version 2.
[[nodiscard]] const std::shared_ptr<const HeadModel>& default_head();

/// Position range and maximum speed of every joint of a head.
struct JointLimits {
  JointVector min_rad = JointVector::Zero();
  JointVector max_rad = JointVector::Zero();
  JointVector max_speed_rad_s = JointVector::Zero();
  /// The head whose joints these are; never null.
  std::shared_ptr<const HeadModel> head = default_head();
};

}  // namespace saccade
