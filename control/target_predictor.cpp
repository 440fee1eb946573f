#include "control/target_predictor.h"

#include <algorithm>
#include <cmath>

namespace saccade {
namespace {

constexpr double gravity_m_s2 = 9.81;
constexpr double distance_memory_s = 0.03;
constexpr double share_of_amplitude = 0.25;
constexpr double fall_distance_m = 0.02;
constexpr double fall_acceleration_error_m_s2 = 2.5;
constexpr double least_fall_s = 0.03;
constexpr double pause_after_failure_s = 0.3;
constexpr double longest_gap_s = 0.1;  // between observations of one fall
constexpr double periodic_memory = 2.0;  // of the track behind a sinusoid, in time constants

const Eigen::Vector3d gravity(0.0, 0.0, -gravity_m_s2);

}  // namespace

TargetPredictor::TargetPredictor(double time_constant_s, bool models)
    : time_constant_s_(time_constant_s), models_(models), track_(time_constant_s) {}

TargetPredictor::Known TargetPredictor::known_at(double t_s) const {
  if (sinusoid_) return {sinusoid_->position_m(t_s), sinusoid_->velocity_m_s(t_s), sinusoid_->acceleration_m_s2(t_s)};
  if (fall_) {
    const double since_s = t_s - fall_->t0_s;
    return {0.5 * since_s * since_s * gravity, since_s * gravity, gravity};
  }
  return {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
}

void TargetPredictor::use(const std::optional<Sinusoid>& sinusoid, const std::optional<FreeFall>& fall) {
  const double seen_s = now_s_ - age_s_;
  const bool starts = sinusoid && !sinusoid_;
  const Known before = known_at(seen_s);
  const bool follows = sinusoid && sinusoid_;
  sinusoid_ = sinusoid;
  fall_ = fall;
  if (follows) return;
  distance_m_ = 0.0;
  if (starts) {
    track_.rest_at(Eigen::Vector3d::Zero());
  } else {
    const Known after = known_at(seen_s);
    track_.shift(before.position_m - after.position_m, before.velocity_m_s - after.velocity_m_s,
                 before.acceleration_m_s2 - after.acceleration_m_s2);
  }
  track_.set_time_constant(time_constant_s_ * (sinusoid_ ? periodic_memory : 1.0));
}

void TargetPredictor::advance(double dt_s) {
  now_s_ += dt_s;
  track_.advance(dt_s);
  if (!models_) return;
  if ((sinusoid_ || fall_) && track_.since_s() > TargetTrack::forget_s) {
    use({}, {});
    fit_.clear();
  }
  fit_.search();
}

void TargetPredictor::observe(const Eigen::Vector3d& target_m, double age_s) {
  age_s_ = age_s;
  const double since_s = track_.since_s();
  const bool fresh = !track_.is_known() || since_s > TargetTrack::forget_s;
  if (fresh && models_) forget();
  const Known known = known_at(now_s_ - age_s_);
  const Eigen::Vector3d rest_m = target_m - known.position_m;
  if (!fresh) {
    const double share = 1.0 - std::exp(-since_s / distance_memory_s);
    distance_m_ += share * ((rest_m - track_.position_m()).norm() - distance_m_);
  }
  track_.observe(rest_m);
  if (!models_) return;
  fit_.observe(now_s_ - age_s_, target_m, track_.velocity_m_s() + known.velocity_m_s);
  if (since_s > longest_gap_s) falling_s_ = 0.0;
  const Eigen::Vector3d acceleration = track_.acceleration_m_s2() + known.acceleration_m_s2;
  const bool falls = (acceleration - gravity).norm() < fall_acceleration_error_m_s2;
  falling_s_ = falls ? falling_s_ + since_s : 0.0;
  update_motion();
}

void TargetPredictor::update_motion() {
  const double limit_m = sinusoid_ ? share_of_amplitude * sinusoid_->amplitude_m() : fall_distance_m;
  if ((sinusoid_ || fall_) && distance_m_ > limit_m) {
    if (sinusoid_) {
      fit_.clear();
      rejected_until_s_ = now_s_ + pause_after_failure_s;
    }
    falling_s_ = 0.0;
    use({}, {});
    return;
  }
  const std::optional<Sinusoid>& fitted = fit_.sinusoid();
  if (fitted && now_s_ >= rejected_until_s_) {
    if (!sinusoid_ || sinusoid_->t0_s != fitted->t0_s) use(fitted, {});
  } else if (sinusoid_) {
    use({}, {});
  } else if (!fall_ && falling_s_ >= least_fall_s) {
    use({}, FreeFall{now_s_ - age_s_});
  }
}

void TargetPredictor::forget() {
  sinusoid_.reset();
  fall_.reset();
  fit_.clear();
  track_.forget();
  track_.set_time_constant(time_constant_s_);
  falling_s_ = distance_m_ = 0.0;
}

void TargetPredictor::set_time_constant(double time_constant_s) {
  time_constant_s_ = time_constant_s;
  use({}, {});
  fit_.clear();
  falling_s_ = 0.0;
}

TargetMotion TargetPredictor::predict(double lead_s) const {
  const double ahead_s = age_s_ + lead_s;
  TargetMotion motion{track_.position_m(), track_.velocity_m_s()};
  if (ahead_s != 0.0) {
    // The acceleration is known for about the time of its estimate.
    const double bend_s = std::min(ahead_s, time_constant_s_);
    const Eigen::Vector3d gained = bend_s * track_.acceleration_m_s2();
    motion.position_m += ahead_s * track_.velocity_m_s() + (ahead_s - 0.5 * bend_s) * gained;
    motion.velocity_m_s += gained;
  }
  if (sinusoid_ || fall_) {
    const Known known = known_at(now_s_ + lead_s);
    motion.position_m += known.position_m;
    motion.velocity_m_s += known.velocity_m_s;
  }
  return motion;
}

}  // namespace saccade
