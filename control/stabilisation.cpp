#include "control/stabilisation.h"

#include <utility>

#include "control/head_kinematics.h"
#include "control/image_rotation.h"
#include "control/joint_limiter.h"
#include "core/units.h"

namespace saccade {
namespace {

constexpr double derivative_s = 0.01;
constexpr double image_time_constant_s = 0.012;
constexpr double image_period_s = 1e-6 * static_cast<double>(ImageRotation::period_us);
constexpr double image_fades_s = 0.1;
constexpr double image_lost_s = 0.05;
constexpr double most_seen_rad_s = 60.0 * rad_per_deg;
constexpr double slow_rad_s = 3.0 * rad_per_deg;

Eigen::Vector3d bounded(const Eigen::Vector3d& rate, double most) {
  const double size = rate.norm();
  return size > most ? Eigen::Vector3d(rate * (most / size)) : rate;
}

}  // namespace

void describe(FieldVisitor& v, StabilisationConfig& config) {
  v.boolean("torso", config.torso, "whether the eyes compensate the velocities of the torso's joints");
  v.boolean("gyroscope", config.gyroscope,
            "whether the eyes compensate the rotation of the head that the gyroscope measures and the neck "
            "does not cause");
  v.boolean("image", config.image,
            "whether the eyes compensate the rotation that the motion of the whole image shows and neck and "
            "eyes do not "
            "cause");
}

Eigen::Vector3d Stabiliser::Filtered::ahead(const Eigen::Vector3d& now, double lead_s, double dt_s) {
  slow += dt_s / (derivative_s + dt_s) * (now - slow);
  return now + lead_s / derivative_s * (now - slow);
}

Stabiliser::Stabiliser(const StabilisationConfig& config, std::shared_ptr<const HeadModel> head,
                       const Eigen::Isometry3d& eye_from_camera)
    : config_(config),
      head_(std::move(head)),
      eye_from_root_at_zero_(
          HeadKinematics(head_->chain, JointVector::Zero()).root_from_eye(Eye::left).linear().transpose()),
      eye_from_camera_(eye_from_camera.linear()) {
  static_assert(std::tuple_size_v<decltype(explained_)> * 1000 == ImageRotation::window_us);
}

const BodyRates& Stabiliser::update(const HeadState& state, const ImuReading* imu, double eyes_s, double dt_s,
                                    const std::optional<Eigen::Vector3d>& seen_rad_s) {
  if (config_.torso && is_reading(state.velocity_rad_s))
    rates_.torso_rad_s = torso_.ahead(state.velocity_rad_s.head<torso_slots>(), eyes_s, dt_s);
  if (config_.image) rates_.base_rad_s -= seen_all_;
  if (config_.gyroscope) {
    if (imu != nullptr && is_reading(imu->angular_velocity_rad_s)) {
      use_gyroscope(state, *imu, eyes_s, dt_s);
    } else {
      measured_base_rad_s_.setZero();
      rates_.base_rad_s.setZero();
    }
  }
  if (!config_.image) return rates_;
  use_image(state, seen_rad_s, dt_s);
  rates_.base_rad_s += seen_all_;
  turn_level(seen_base_, dt_s);
  return rates_;
}

void Stabiliser::turn_level(const Eigen::Vector3d& base_rad_s, double dt_s) {
  const double angle = base_rad_s.norm() * dt_s;
  if (angle > 0.0)
    rates_.level_from_root =
        (rates_.level_from_root * Eigen::AngleAxisd(angle, base_rad_s.normalized())).normalized();
}

void Stabiliser::use_gyroscope(const HeadState& state, const ImuReading& imu, double eyes_s, double dt_s) {
  // The head as the neck turns it: the pose of an eye whose own joints are 0.
  const int carried = torso_slots + head_->neck_joints();
  JointVector joints_rad = state.position_rad;
  joints_rad.tail(joint_slots - carried).setZero();
  const HeadKinematics head(head_->chain, joints_rad);
  const Eigen::Matrix3d root_from_head = head.root_from_eye(Eye::left).linear() * eye_from_root_at_zero_;
  const PointJacobian turned = head.jacobian(Eye::left).angular;
  Eigen::Vector3d by_neck = Eigen::Vector3d::Zero();
  for (int j = torso_slots; j < carried; ++j) by_neck += turned.col(j) * state.velocity_rad_s[j];
  const Eigen::Vector3d by_torso = turned.leftCols<torso_slots>() * state.velocity_rad_s.head<torso_slots>();
  const Eigen::Vector3d below_neck = root_from_head * imu.angular_velocity_rad_s - by_neck;
  measured_base_rad_s_ = below_neck - by_torso;
  turn_level(measured_base_rad_s_, dt_s);
  rates_.base_rad_s = base_.ahead(config_.torso ? measured_base_rad_s_ : below_neck, eyes_s, dt_s);
}

void Stabiliser::use_image(const HeadState& state, const std::optional<Eigen::Vector3d>& seen_rad_s,
                           double dt_s) {
  const HeadKinematics head(head_->chain, state.position_rad);
  const PointJacobian turned = head.jacobian(Eye::left).angular;
  Explained& now = explained_[ticks_++ % explained_.size()];
  now.by_torso = turned.leftCols<torso_slots>() * state.velocity_rad_s.head<torso_slots>();
  now.by_head = turned.rightCols<gaze_slots>() * state.velocity_rad_s.tail<gaze_slots>();
  now.by_base = measured_base_rad_s_;
  unseen_s_ += dt_s;
  if (unseen_s_ > image_lost_s) {
    const double share = dt_s / (image_fades_s + dt_s);
    seen_all_ -= share * seen_all_;
    seen_base_ -= share * seen_base_;
  }
  if (!seen_rad_s || ticks_ < explained_.size()) return;
  Explained mean;
  for (const Explained& tick : explained_) {
    mean.by_head += tick.by_head / static_cast<double>(explained_.size());
    mean.by_torso += tick.by_torso / static_cast<double>(explained_.size());
    mean.by_base += tick.by_base / static_cast<double>(explained_.size());
  }
  // Flows that agree on no rotation while the joints turn the camera measure nothing.
  if (seen_rad_s->isZero(0.0) && (mean.by_head + mean.by_torso).norm() > slow_rad_s) return;
  unseen_s_ = 0.0;
  const Eigen::Matrix3d root_from_camera = head.root_from_eye(Eye::left).linear() * eye_from_camera_;
  const Eigen::Vector3d base =
      bounded(root_from_camera * *seen_rad_s - mean.by_head - mean.by_torso - mean.by_base, most_seen_rad_s);
  const bool compensates_torso = config_.torso || config_.gyroscope;
  const double share = image_period_s / (image_time_constant_s + image_period_s);
  seen_base_ += share * (base - seen_base_);
  seen_all_ += share * (base + (compensates_torso ? Eigen::Vector3d::Zero() : mean.by_torso) - seen_all_);
}

}  // namespace saccade
