#include "head/ergocub_heads.h"

#include <Eigen/Geometry>
#include <array>
#include <numbers>
#include <span>

#include "core/units.h"
#include "head/placed_joints.h"

namespace saccade {
namespace {

/// A joint as the URDF has it: its frame in that of the joint before, which is turned about y alone, and its axis. The URDF's
/// root has x forward, y left and z up.
struct UrdfJoint {
  std::string_view name;
  JointRole role;
  Eigen::Vector3d origin_m;
  double pitch_rad;
  Eigen::Vector3d axis;
  double min_rad, max_rad, max_speed_deg_s;
};

constexpr double torso_deg_s = 120.0;
constexpr double neck_deg_s = 50.0;
constexpr double tilt_deg_s = 150.0;  // the board's limit of 1000 is none of the motor's
constexpr double torso_roll_rad = 0.4363323129985824;
constexpr double eighth_turn_rad = std::numbers::pi / 4.0;
constexpr double neck_roll_rad = std::numbers::pi / 9.0;

/// What is the same in both versions.
UrdfJoint torso_joint(std::string_view name, double z_m, const Eigen::Vector3d& axis, double min_rad,
                      double max_rad) {
  return {name, JointRole::torso, {0.0, 0.0, z_m}, 0.0, axis, min_rad, max_rad, torso_deg_s};
}

std::array<UrdfJoint, 7> joints_of(std::string_view version) {
  const bool sn003 = version == "SN003";
  // The frames of neck roll and yaw of SN003 are turned by 1.6e-6 rad.
  const double small_rad = sn003 ? 1.5706357540212687e-6 : 0.0;
  const Eigen::Vector3d pitch_m = sn003 ? Eigen::Vector3d(-0.00375 + 0.00865, 0.0, 0.1823 + 0.045)
                                        : Eigen::Vector3d(0.004861512347971912, 0.0, 0.2253);
  const Eigen::Vector3d roll_m =
      sn003 ? Eigen::Vector3d(1.727699395961263e-8, 0.0, 0.011) : Eigen::Vector3d(0.0, 0.0, 0.0095);
  const Eigen::Vector3d yaw_m =
      sn003 ? Eigen::Vector3d(-1.2588645634161594e-7, 0.0, 0.06915) : Eigen::Vector3d(0.0, 0.0, 0.06915);
  return {{
      torso_joint("torso_roll", 0.0605, {-1.0, 0.0, 0.0}, -torso_roll_rad, torso_roll_rad),
      torso_joint("torso_pitch", 0.118, {0.0, 1.0, 0.0}, -neck_roll_rad, 1.1344640137963142),
      torso_joint("torso_yaw", sn003 ? 0.0745 : 0.06447, {0.0, 0.0, -1.0}, -eighth_turn_rad, eighth_turn_rad),
      {"neck_pitch",
       JointRole::neck,
       pitch_m,
       0.0,
       {0.0, -1.0, 0.0},
       -eighth_turn_rad,
       0.3839724354387525,
       neck_deg_s},
      {"neck_roll",
       JointRole::neck,
       roll_m,
       small_rad,
       {1.0, 0.0, small_rad},
       -neck_roll_rad,
       neck_roll_rad,
       neck_deg_s},
      {"neck_yaw",
       JointRole::neck,
       yaw_m,
       -small_rad,
       {small_rad, 0.0, 1.0},
       -eighth_turn_rad,
       eighth_turn_rad,
       neck_deg_s},
      {"camera_tilt",
       JointRole::eye,
       {0.06251, -0.00003, 0.0763925},
       2.5958199e-4,
       {0.0, -1.0, 0.0},
       -std::numbers::pi / 6.0,
       std::numbers::pi / 6.0,
       tilt_deg_s},
  }};
}

/// realsense_rgb_frame in the frame of the tilt.
const Eigen::Vector3d camera_m(0.007515481871156526, -0.0115, 1.7352099701550827e-8);

}  // namespace

HeadDescription ergocub_description(std::string_view version) {
  const Eigen::Matrix3d root_from_urdf = *root_from_axes("x", "z");
  Eigen::Isometry3d frame(root_from_urdf);
  PlacedChain chain;
  for (const UrdfJoint& joint : joints_of(version)) {
    frame.translate(joint.origin_m);
    frame.rotate(Eigen::AngleAxisd(joint.pitch_rad, Eigen::Vector3d::UnitY()));
    PlacedJoint placed;
    placed.name = joint.name;
    placed.role = joint.role;
    placed.axis = frame.linear() * joint.axis;
    placed.point_m = frame.translation();
    placed.min_rad = joint.min_rad;
    placed.max_rad = joint.max_rad;
    placed.max_speed_rad_s = joint.max_speed_deg_s * rad_per_deg;
    chain.common.push_back(placed);
  }
  frame.translate(camera_m);
  frame.rotate(body_from_optical());
  chain.root_from_camera[0] = frame;
  HeadDescription head = description_of(chain, "ergocub " + std::string(version));
  // head_imu: turned by pi about x, then by pi/2 about z, in the head, whose axes are the URDF root's with all joints at 0.
  Eigen::Matrix3d urdf_from_imu;
  urdf_from_imu << 0, 1, 0, 1, 0, 0, 0, 0, -1;
  const Eigen::Matrix3d imu = root_from_urdf * urdf_from_imu;
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      head.imu_rotation[static_cast<std::size_t>(3 * row + column)] = imu(row, column);
  }
  return head;
}

const std::vector<std::string>& ergocub_versions() {
  static const std::vector<std::string> names = {"SN001", "SN003"};
  return names;
}

}  // namespace saccade
