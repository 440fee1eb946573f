#include "control/stabilisation.h"

#include <utility>

#include "control/head_kinematics.h"

namespace saccade {
namespace {

constexpr double derivative_s = 0.01;

}  // namespace

void describe(FieldVisitor& v, StabilisationConfig& config) {
  v.boolean("torso", config.torso, "whether the eyes compensate the velocities of the torso's joints");
  v.boolean("gyroscope", config.gyroscope,
            "whether the eyes compensate the rotation of the head that the gyroscope measures and the neck "
            "does not cause");
}

Eigen::Vector3d Stabiliser::Filtered::ahead(const Eigen::Vector3d& now, double lead_s, double dt_s) {
  slow += dt_s / (derivative_s + dt_s) * (now - slow);
  return now + lead_s / derivative_s * (now - slow);
}

Stabiliser::Stabiliser(const StabilisationConfig& config, std::shared_ptr<const HeadModel> head)
    : config_(config),
      head_(std::move(head)),
      eye_from_root_at_zero_(
          HeadKinematics(head_->chain, JointVector::Zero()).root_from_eye(Eye::left).linear().transpose()) {}

const BodyRates& Stabiliser::update(const HeadState& state, const ImuReading* imu, double eyes_s,
                                    double dt_s) {
  const Eigen::Vector3d torso_rad_s = state.velocity_rad_s.head<torso_slots>();
  if (config_.torso) rates_.torso_rad_s = torso_.ahead(torso_rad_s, eyes_s, dt_s);
  if (!config_.gyroscope || imu == nullptr || !imu->angular_velocity_rad_s.allFinite()) return rates_;

  // The head as the neck turns it: the pose of an eye whose own joints are 0.
  const int carried = torso_slots + head_->neck_joints();
  JointVector joints_rad = state.position_rad;
  joints_rad.tail(joint_slots - carried).setZero();
  const HeadKinematics head(head_->chain, joints_rad);
  const Eigen::Matrix3d root_from_head = head.root_from_eye(Eye::left).linear() * eye_from_root_at_zero_;
  const PointJacobian turned = head.jacobian(Eye::left).angular;
  Eigen::Vector3d by_neck = Eigen::Vector3d::Zero();
  for (int j = torso_slots; j < carried; ++j) by_neck += turned.col(j) * state.velocity_rad_s[j];
  const Eigen::Vector3d by_torso = turned.leftCols<torso_slots>() * torso_rad_s;
  const Eigen::Vector3d below_neck = root_from_head * imu->angular_velocity_rad_s - by_neck;
  const Eigen::Vector3d base = below_neck - by_torso;
  const double angle = base.norm() * dt_s;
  if (angle > 0.0)
    rates_.level_from_root =
        (rates_.level_from_root * Eigen::AngleAxisd(angle, base.normalized())).normalized();
  rates_.base_rad_s = base_.ahead(config_.torso ? base : below_neck, eyes_s, dt_s);
  return rates_;
}

}  // namespace saccade
