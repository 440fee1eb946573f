#include "control/head_kinematics.h"

#include <Eigen/LU>
#include <cmath>
#include <numbers>

namespace saccade {
namespace {

/// One row of the DH table: H = Rz(q + offset) Tz(d) Tx(a) Rx(twist * 90 deg).
struct Link {
  double a_m;
  double d_m;
  double twist;  // +1 or -1, exact where sin(pi / 2) and cos(pi / 2) are not
  double offset_rad;
};

constexpr double quarter_turn_rad = std::numbers::pi / 2;
constexpr std::array<Link, 6> neck_links = {{
    {0.032, 0.0, 1.0, 0.0},                      // torso pitch
    {0.0, -0.0055, 1.0, -quarter_turn_rad},      // torso roll
    {0.0, -0.2233, -1.0, -quarter_turn_rad},     // torso yaw
    {0.0095, 0.0, 1.0, quarter_turn_rad},        // neck pitch
    {0.0, 0.0, -1.0, -quarter_turn_rad},         // neck roll
    {-0.0509, 0.08205, -1.0, quarter_turn_rad},  // neck yaw
}};
constexpr Link left_tilt_link{0.0, -0.034, -1.0, 0.0};
constexpr Link right_tilt_link{0.0, 0.034, -1.0, 0.0};
constexpr Link pan_link{0.0, 0.0, 1.0, -quarter_turn_rad};

// sin^2 of the smallest angle between optical axes that counts as an intersection: 0.1 deg.
constexpr double min_sine_squared = 3.0462e-6;

Eigen::Isometry3d transform(const Link& link, double q_rad) {
  const double c = std::cos(q_rad + link.offset_rad);
  const double s = std::sin(q_rad + link.offset_rad);
  Eigen::Isometry3d t;
  t.matrix() << c, 0.0, s * link.twist, link.a_m * c,  //
      s, 0.0, -c * link.twist, link.a_m * s,           //
      0.0, link.twist, 0.0, link.d_m,                  //
      0.0, 0.0, 0.0, 1.0;
  return t;
}

Eigen::Isometry3d base() {
  Eigen::Isometry3d t;
  t.matrix() << 0.0, -1.0, 0.0, 0.0,  //
      0.0, 0.0, -1.0, 0.0,            //
      1.0, 0.0, 0.0, 0.0,             //
      0.0, 0.0, 0.0, 1.0;
  return t;
}

Eigen::Matrix3d across(const Eigen::Vector3d& z) { return Eigen::Matrix3d::Identity() - z * z.transpose(); }

}  // namespace

HeadKinematics::HeadKinematics(const JointVector& q) {
  const auto axis_of = [](const Eigen::Isometry3d& frame) {
    return Axis{frame.linear().col(2), frame.translation()};
  };
  Eigen::Isometry3d frame = base();
  for (std::size_t i = 0; i < neck_links.size(); ++i) {
    axes_[i] = axis_of(frame);
    frame = frame * transform(neck_links[i], q[static_cast<int>(i)]);
  }
  axes_[eyes_tilt] = axis_of(frame);
  const Eigen::Isometry3d left = frame * transform(left_tilt_link, q[eyes_tilt]);
  const Eigen::Isometry3d right = frame * transform(right_tilt_link, q[eyes_tilt]);
  axes_[eyes_version] = axis_of(left);
  axes_[eyes_vergence] = axis_of(right);
  root_from_eye_[index(Eye::left)] = left * transform(pan_link, q[eyes_version] + q[eyes_vergence] / 2);
  root_from_eye_[index(Eye::right)] = right * transform(pan_link, q[eyes_version] - q[eyes_vergence] / 2);
}

EyeJacobian HeadKinematics::jacobian(Eye eye) const {
  const Eigen::Vector3d centre = root_from_eye(eye).translation();
  EyeJacobian j;
  for (int i = 0; i <= eyes_tilt; ++i) {
    const Axis& axis = axes_[static_cast<std::size_t>(i)];
    j.angular.col(i) = axis.direction;
    j.linear.col(i) = axis.direction.cross(centre - axis.point_m);
  }
  // The pan axis goes through the eye centre: panning turns the eye and does not move it.
  const bool left = eye == Eye::left;
  const Eigen::Vector3d& pan_axis = axes_[left ? eyes_version : eyes_vergence].direction;
  j.angular.col(eyes_version) = pan_axis;
  j.angular.col(eyes_vergence) = (left ? 0.5 : -0.5) * pan_axis;
  j.linear.rightCols<2>().setZero();
  return j;
}

FixationPoint HeadKinematics::fixation() const {
  // The point p nearest to both lines solves sum P_i (p - o_i) = 0, P_i the projector across axis i.
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const Eigen::Isometry3d& eye : root_from_eye_) {
    const Eigen::Matrix3d p = across(eye.linear().col(2));
    a += p;
    b += p * eye.translation();
  }
  const Eigen::Vector3d z_left = root_from_eye_[0].linear().col(2);
  const Eigen::Vector3d z_right = root_from_eye_[1].linear().col(2);
  if (!(z_left.cross(z_right).squaredNorm() > min_sine_squared)) return {};
  const Eigen::Vector3d point = a.inverse() * b;
  const bool in_front = z_left.dot(point - root_from_eye_[0].translation()) > 0.0 &&
                        z_right.dot(point - root_from_eye_[1].translation()) > 0.0;
  if (!in_front) return {};
  return {true, point};
}

PointJacobian HeadKinematics::fixation_jacobian() const {
  const FixationPoint at = fixation();
  if (!at.valid) return PointJacobian::Zero();
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  PointJacobian b = PointJacobian::Zero();
  for (const Eye eye : {Eye::left, Eye::right}) {
    const Eigen::Vector3d z = root_from_eye(eye).linear().col(2);
    const Eigen::Vector3d arm = at.point_m - root_from_eye(eye).translation();
    const Eigen::Matrix3d p = across(z);
    const EyeJacobian j = jacobian(eye);
    a += p;
    b += p * j.linear;
    for (int i = 0; i < joint_count; ++i) {
      const Eigen::Vector3d dz = j.angular.col(i).cross(z);
      b.col(i) += dz * z.dot(arm) + z * dz.dot(arm);
    }
  }
  return a.inverse() * b;
}

Eigen::Isometry3d root_from_left_cam(const JointVector& q) {
  return HeadKinematics(q).root_from_eye(Eye::left);
}
Eigen::Isometry3d root_from_right_cam(const JointVector& q) {
  return HeadKinematics(q).root_from_eye(Eye::right);
}

CameraMotion camera_motion(const HeadState& state, Eye eye, const Eigen::Isometry3d& eye_from_camera) {
  const HeadKinematics head(state.position_rad);
  const Eigen::Isometry3d pose = head.root_from_eye(eye) * eye_from_camera;
  const EyeJacobian j = head.jacobian(eye);
  const Eigen::Vector3d angular = j.angular * state.velocity_rad_s;
  const Eigen::Vector3d arm_m = pose.translation() - head.root_from_eye(eye).translation();
  const Eigen::Vector3d linear = j.linear * state.velocity_rad_s + angular.cross(arm_m);
  return {pose, pose.linear().transpose() * linear, pose.linear().transpose() * angular};
}

}  // namespace saccade
