#include "control/target_track.h"

#include <cmath>

namespace saccade {

void TargetTrack::advance(double dt_s) {
  since_s_ += dt_s;
  if (!known_ || time_constant_s_ == 0.0) return;
  position_m_ += velocity_m_s_ * dt_s + 0.5 * acceleration_m_s2_ * dt_s * dt_s;
  velocity_m_s_ += acceleration_m_s2_ * dt_s;
  if (since_s_ <= time_constant_s_) return;
  const double kept = std::exp(-dt_s / time_constant_s_);
  velocity_m_s_ *= kept;
  acceleration_m_s2_ *= kept;
}

void TargetTrack::observe(const Eigen::Vector3d& target_m) {
  if (!known_ || since_s_ > forget_s || time_constant_s_ == 0.0) {
    known_ = true;
    rest_at(target_m);
  } else if (since_s_ > 0.0) {
    const double kept = std::exp(-since_s_ / time_constant_s_);
    const double lost = 1.0 - kept;
    const Eigen::Vector3d innovation = target_m - position_m_;
    position_m_ += (1.0 - kept * kept * kept) * innovation;
    velocity_m_s_ += 1.5 * lost * lost * (1.0 + kept) / since_s_ * innovation;
    acceleration_m_s2_ += lost * lost * lost / (since_s_ * since_s_) * innovation;
  }
  since_s_ = 0.0;
}

void TargetTrack::rest_at(const Eigen::Vector3d& position_m) {
  position_m_ = position_m;
  velocity_m_s_.setZero();
  acceleration_m_s2_.setZero();
}

void TargetTrack::shift(const Eigen::Vector3d& position_m, const Eigen::Vector3d& velocity_m_s,
                        const Eigen::Vector3d& acceleration_m_s2) {
  position_m_ += position_m;
  velocity_m_s_ += velocity_m_s;
  acceleration_m_s2_ += acceleration_m_s2;
}

}  // namespace saccade
