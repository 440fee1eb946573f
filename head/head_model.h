#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "head/head_chain.h"
#include "head/head_state.h"

namespace saccade {

/// What a joint belongs to.
enum class JointRole {
  torso,  ///< measured; gaze does not command it
  neck,   ///< gaze commands it, with the limits for the neck
  eye,    ///< gaze commands it, with the limits for the eyes
};

/// A joint of a head.
struct HeadJoint {
  std::string name;
  JointRole role = JointRole::neck;
  int slot = 0;  ///< its element of a JointVector
  double min_rad = 0.0;
  double max_rad = 0.0;
  double max_speed_rad_s = 0.0;
  double bandwidth_hz =
      10.0;  ///< natural frequency of its servo in a model that is made from the description
};

/// A head: its joints and its kinematic chain, from a description. The simulator's model is made from it or checked
/// against it; gaze control computes with it.
struct HeadModel {
  std::string name;               ///< for messages: "icub version 2"
  std::vector<HeadJoint> joints;  ///< torso, neck, eyes: the order of tables and initial poses
  HeadChain chain;
  /// The slots of the torso's joints in the order in which the control board of the torso has them.
  std::vector<int> torso_motors;
  std::string mjcf;  ///< path of a model of the head's own; empty: made from the description, or the iCub's
  bool is_icub = false;
  /// Orientation of the inertial measurement unit in the frame of ImuReading.
  Eigen::Matrix3d head_from_imu = Eigen::Matrix3d::Identity();

  [[nodiscard]] int count(JointRole role) const;
  [[nodiscard]] int torso_joints() const { return count(JointRole::torso); }
  [[nodiscard]] int neck_joints() const { return count(JointRole::neck); }
  [[nodiscard]] int gaze_joints() const { return static_cast<int>(joints.size()) - torso_joints(); }
  /// The name of the joint with this slot, empty for a slot that the head does not use.
  [[nodiscard]] std::string_view name_of(int slot) const;
  /// The values of all joints, or of those that gaze commands, in the order of `joints`; and back, other slots 0.
  [[nodiscard]] Eigen::VectorXd in_order(const JointVector& by_slot) const;
  [[nodiscard]] Eigen::VectorXd gaze_in_order(const HeadJointVector& by_slot) const;
  [[nodiscard]] JointVector by_slot(const Eigen::VectorXd& in_order) const;
  [[nodiscard]] HeadJointVector gaze_by_slot(const Eigen::VectorXd& in_order) const;
  /// Whether the slots of Joint have their meaning: three joints of the neck, then tilt, version and vergence of two eyes.
  [[nodiscard]] bool has_icub_gaze() const;
};

/// The iCub head of a version: 1, 2, 2.8, 2.10 or 3, as written. Null for any other text.
/// Source: iKinFwd.cpp (iKin, BSD-3); limits of iCubGenova02, 2016, and for version 3 those of iKin. Where the limits of a
/// version are not known they are those of version 2.
[[nodiscard]] std::shared_ptr<const HeadModel> icub_head(std::string_view version = "2");
[[nodiscard]] const std::vector<std::string>& icub_versions();

/// The head with its eyes' frames at cameras that are mounted in the eyes: what gaze control aims. Each frame has its origin in
/// the pinhole and its z axis along the camera's optical axis; a roll of the camera about that axis is left out, so that x
/// stays to the right. The same head where both cameras are at the eyes' own frames.
[[nodiscard]] std::shared_ptr<const HeadModel> aiming_cameras(const std::shared_ptr<const HeadModel>& head,
                                                              const Eigen::Isometry3d& left_eye_from_camera,
                                                              const Eigen::Isometry3d& right_eye_from_camera);

/// A head of which only the names of the joints are known, such as from the columns of a table: the default head where the
/// names are its joints', otherwise joints in the slots from torso_slots on. At most gaze_slots names.
[[nodiscard]] std::shared_ptr<const HeadModel> head_of_names(const std::vector<std::string>& names);

}  // namespace saccade
