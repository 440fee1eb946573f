#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/config.h"
#include "head/head_model.h"

namespace saccade {

constexpr auto words_of(JointRole) {
  return std::to_array<Word<JointRole>>(
      {{JointRole::torso, "torso"}, {JointRole::neck, "neck"}, {JointRole::eye, "eye"}});
}

/// A joint of a described head.
struct DescribedJoint {
  JointRole role = JointRole::neck;
  double min_deg = -90.0;
  double max_deg = 90.0;
  double max_speed_deg_s = 180.0;
  double bandwidth_hz = 10.0;  ///< natural frequency of its critically damped servo in the simulator
};

/// Keys: role, min_deg, max_deg, max_speed_deg_s, bandwidth_hz.
void describe(FieldVisitor& v, DescribedJoint& joint);

/// How the place of a link is given.
enum class LinkKind {
  axis,  ///< a line in the root frame, with all joints at 0
  dh,    ///< a row of a DH table
};
constexpr auto words_of(LinkKind) {
  return std::to_array<Word<LinkKind>>({{LinkKind::axis, "axis"}, {LinkKind::dh, "dh"}});
}

/// A link of a described head.
struct DescribedLink {
  LinkKind kind = LinkKind::dh;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();    ///< its positive turn is right-handed
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  ///< on the axis
  double a_m = 0.0;
  double d_m = 0.0;
  double alpha_deg = 0.0;
  double offset_deg = 0.0;
  /// A fixed displacement before a row of a DH table, in the frame of the link before.
  Eigen::Vector3d before_m = Eigen::Vector3d::Zero();
  std::string joint = "none";  ///< that turns it; none: fixed
  double share = 1.0;          ///< rotation of the link per rotation of the joint
  std::string second_joint = "none";
  double second_share = 1.0;
};

/// Keys: kind, axis, point_m, a_m, d_m, alpha_deg, offset_deg, before_m, joint, share, second_joint, second_share; of the
/// kind. `joints`: the names that a link may give.
void describe(FieldVisitor& v, DescribedLink& link, const std::vector<std::string>& joints);

using DescribedLinks = std::vector<std::pair<std::string, DescribedLink>>;

/// A pose with all joints at 0, root frame.
struct DescribedPose {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d forward = -Eigen::Vector3d::UnitX();  ///< the optical axis
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();        ///< in the image
};

/// Keys: position_m, forward, up.
void describe(FieldVisitor& v, DescribedPose& pose);

/// An eye of a described head.
struct DescribedEye {
  DescribedLinks links;  ///< after those of the neck; may be empty
  /// Where the eye is; without it the frame after the last row of a DH table times the two below.
  std::optional<DescribedPose> pose;
  std::array<double, 9> end_rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1};  ///< by rows
  Eigen::Vector3d end_position_m = Eigen::Vector3d::Zero();
};

/// A head from a file: head.file.
struct HeadDescription {
  std::string name = "described head";  ///< for messages
  std::vector<std::pair<std::string, DescribedJoint>> joints;
  /// The frame before the first row of a DH table: its rotation by rows, and its place; root frame.
  std::array<double, 9> base_rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  Eigen::Vector3d base_position_m = Eigen::Vector3d::Zero();
  DescribedLinks links;  ///< from the base to where the eyes branch off
  DescribedEye left_eye;
  std::optional<DescribedEye> right_eye;
  double encoder_step_deg = 0.0;      ///< default of plant.encoders.quantisation_deg
  std::int64_t command_delay_ms = 0;  ///< default of plant.command_delay_ms
  /// Orientation of the inertial measurement unit with all joints at 0, by rows, root frame.
  std::array<double, 9> imu_rotation = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  std::string mjcf;  ///< a model of the head's own; empty: it is made from the description
};

/// Keys: name, joints, base_rotation, base_position_m, links, left_eye, right_eye, encoder_step_deg, command_delay_ms,
/// imu_rotation, mjcf.
void describe(FieldVisitor& v, HeadDescription& head);

/// The head that is described. `head` fits its describe(). Throws InputError, whose places begin
/// with `head.`, with everything else that is wrong: joints that turn nothing or the same, names, order, an eye without
/// a place.
[[nodiscard]] std::shared_ptr<const HeadModel> described_head(const HeadDescription& head);

}  // namespace saccade
