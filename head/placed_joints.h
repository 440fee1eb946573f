#pragma once

#include <Eigen/Geometry>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "head/head_description.h"

namespace saccade {

/// A joint that turns about an axis, and where that is with all joints at 0. Limits that the source does not state are NaN.
struct PlacedJoint {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  std::string name;
  JointRole role = JointRole::neck;
  Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();    ///< root frame
  Eigen::Vector3d point_m = Eigen::Vector3d::Zero();  ///< root frame
  double min_rad = unknown;
  double max_rad = unknown;
  double max_speed_rad_s = unknown;
  std::string place;  ///< in the source, for messages: file, line and element
};

/// A chain of joints and one or two cameras at its ends, from a file in another format.
struct PlacedChain {
  std::vector<PlacedJoint> common;  ///< those that turn all cameras, from the root on
  std::array<std::vector<PlacedJoint>, 2>
      eye;  ///< those of the left camera alone, or the only one, and of the right one
  std::array<Eigen::Isometry3d, 2> root_from_camera = {
      Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity()};  ///< z: the optical axis
  int cameras = 1;
};

/// Which part of a model in URDF or MJCF is the head.
struct ChainRequest {
  std::string path;                 ///< of the file
  std::vector<std::string> joints;  ///< that move, in the order from the base to the cameras
  std::string camera;               ///< the left camera, or the only one
  std::optional<std::string> right_camera;
  std::optional<std::string> base;  ///< link that is the root; without it that above all others
  Eigen::Matrix3d root_from_base = Eigen::Matrix3d::Identity();  ///< orientation of that link
  bool optical =
      true;  ///< a link that is a camera has z along the optical axis; otherwise x forward and z up
};

/// The head with these joints and cameras: a link of each joint, by its axis. What the chain does not state is NaN or has its
/// default.
[[nodiscard]] HeadDescription description_of(const PlacedChain& chain, const std::string& name);

/// The root frame (x backward, y right, z up) in which a frame with these directions stands upright. `forward` and `up` are
/// two of x, -x, y, -y, z, -z. None where they are on one axis or another word.
[[nodiscard]] std::optional<Eigen::Matrix3d> root_from_axes(std::string_view forward, std::string_view up);

/// The rotation of a camera with x right, y down and z along the optical axis in a body with x forward, y left and z up.
[[nodiscard]] Eigen::Matrix3d body_from_optical();

/// How far a camera looks away from the root's forward direction, deg.
[[nodiscard]] double degrees_from_forward(const Eigen::Isometry3d& root_from_camera);

}  // namespace saccade
