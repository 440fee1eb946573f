#include "control/target_predictor.h"

#include <algorithm>
#include <cmath>

namespace saccade {
namespace {

constexpr double distance_memory_s = 0.03;
constexpr double share_of_amplitude = 0.25;
constexpr double fall_distance_m = 0.02;
constexpr double pause_after_failure_s = 0.3;
constexpr double longest_gap_s = 1.0;  // of a sinusoid without a target
constexpr double covered_after_s = 0.06, longest_cover_s = 1.0;
constexpr double periodic_memory = 2.0;  // of the track behind a sinusoid, in time constants

}  // namespace

TargetPredictor::TargetPredictor(double time_constant_s, bool models)
    : time_constant_s_(time_constant_s), models_(models), track_(time_constant_s) {}

TargetPredictor::Known TargetPredictor::known_at(double t_s) const {
  if (sinusoid_)
    return {sinusoid_->position_m(t_s), sinusoid_->velocity_m_s(t_s), sinusoid_->acceleration_m_s2(t_s)};
  if (fall_) {
    const double since_s = t_s - fall_->t0_s;
    const Eigen::Vector3d gained = since_s * gravity_m_s2();
    return {fall_->position_m + since_s * (fall_->velocity_m_s + 0.5 * gained), fall_->velocity_m_s + gained,
            gravity_m_s2()};
  }
  if (line_) {
    // The end of the line: longest_cover_s after the newest target.
    const double end_s = now_s_ - track_.since_s() + longest_cover_s;
    const Eigen::Vector3d velocity = t_s < end_s ? line_->velocity_m_s : Eigen::Vector3d::Zero();
    return {line_->position_m + (std::min(t_s, end_s) - line_->t0_s) * line_->velocity_m_s, velocity,
            Eigen::Vector3d::Zero()};
  }
  return {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
}

void TargetPredictor::use(const std::optional<Sinusoid>& sinusoid, const std::optional<FreeFall>& fall,
                          const std::optional<StraightPath>& line) {
  const double seen_s = now_s_ - age_s_;
  const bool starts = (sinusoid && !sinusoid_) || (fall && !fall_) || (line && !line_);
  const Known before = known_at(seen_s);
  const bool follows = sinusoid && sinusoid_;
  sinusoid_ = sinusoid;
  fall_ = fall;
  line_ = line;
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

double TargetPredictor::longest_gap() const { return sinusoid_ ? longest_gap_s : TargetTrack::forget_s; }

void TargetPredictor::advance(double dt_s) {
  now_s_ += dt_s;
  track_.advance(dt_s);
  if (!models_) return;
  if ((sinusoid_ || fall_) && track_.since_s() > longest_gap()) {
    use({}, {});
    forget_path();
  }
  fit_.search(path_);
  if (!sinusoid_ && !fall_ && !line_was_fitted_ && track_.since_s() > covered_after_s) {
    line_was_fitted_ = true;
    if (const auto line = fit_straight_path(path_)) use({}, {}, line);
  }
}

void TargetPredictor::observe(const Eigen::Vector3d& target_m, double age_s) {
  age_s_ = age_s;
  const double since_s = track_.since_s();
  const bool fresh = !track_.is_known() || since_s > longest_gap();
  if (fresh && models_) forget();
  if (line_) use({}, {});
  line_was_fitted_ = false;
  const Known known = known_at(now_s_ - age_s_);
  const Eigen::Vector3d rest_m = target_m - known.position_m;
  if (!fresh) {
    const double share = 1.0 - std::exp(-since_s / distance_memory_s);
    distance_m_ += share * ((rest_m - track_.position_m()).norm() - distance_m_);
  }
  track_.observe(rest_m);
  if (!models_) return;
  const Eigen::Vector3d velocity_m_s = track_.velocity_m_s() + known.velocity_m_s;
  update_known_motion(path_.observe(now_s_ - age_s_, target_m, velocity_m_s));
}

bool TargetPredictor::leaves_known_motion() const {
  const double limit_m = sinusoid_ ? share_of_amplitude * sinusoid_->amplitude_m() : fall_distance_m;
  return distance_m_ > limit_m || track_.position_m().norm() > 2.0 * limit_m;
}

void TargetPredictor::update_known_motion(bool new_average) {
  if ((sinusoid_ || fall_) && leaves_known_motion()) {
    rejected_until_s_ = now_s_ + pause_after_failure_s;
    if (sinusoid_) fit_.clear();
    use({}, {});
    return;
  }
  const std::optional<Sinusoid>& fitted = fit_.sinusoid();
  if (fitted && now_s_ >= rejected_until_s_) {
    if (!sinusoid_ || sinusoid_->t0_s != fitted->t0_s) use(fitted, {});
  } else if (sinusoid_) {
    use({}, {});
  } else if (!fall_ && new_average && now_s_ >= rejected_until_s_) {
    if (const auto fall = fit_free_fall(path_)) use({}, fall);
  }
}

void TargetPredictor::forget_path() {
  path_.clear();
  fit_.clear();
}

void TargetPredictor::forget() {
  sinusoid_.reset();
  fall_.reset();
  line_.reset();
  line_was_fitted_ = false;
  forget_path();
  track_.forget();
  track_.set_time_constant(time_constant_s_);
  distance_m_ = 0.0;
}

void TargetPredictor::set_time_constant(double time_constant_s) {
  time_constant_s_ = time_constant_s;
  use({}, {});
  forget_path();
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
  if (sinusoid_ || fall_ || line_) {
    const Known known = known_at(now_s_ + lead_s);
    motion.position_m += known.position_m;
    motion.velocity_m_s += known.velocity_m_s;
  }
  return motion;
}

}  // namespace saccade
