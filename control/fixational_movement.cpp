#include "control/fixational_movement.h"

#include <cmath>
#include <numbers>

#include "core/units.h"

namespace saccade {

void describe(FieldVisitor& v, FixationalConfig& config) {
  v.real("amplitude_deg", config.amplitude_deg, {0.0, 5.0},
         "amplitude of small eye movements around a target that makes no events; 0: none");
  v.when(config.amplitude_deg > 0.0, "amplitude_deg above 0", [&] {
    v.real("after_s", config.after_s, {0.01, 60.0},
           "time without a detection from current events until such a movement, and between two of them");
    v.real("frequency_hz", config.frequency_hz, {1.0, 20.0},
           "frequency of the movement, which lasts one period");
  });
}

FixationalMovement::FixationalMovement(const FixationalConfig& config)
    : config_(check_config("gaze.fixational", config)) {}

std::optional<Eigen::Vector2d> FixationalMovement::update(bool seen, bool follows, double dt_s) {
  if (config_.amplitude_deg <= 0.0) return std::nullopt;
  if (!follows) {
    unseen_s_ = 0.0;
    moving_s_.reset();
    return std::nullopt;
  }
  if (!moving_s_) {
    unseen_s_ = seen ? 0.0 : unseen_s_ + dt_s;
    if (unseen_s_ < config_.after_s) return std::nullopt;
    moving_s_ = 0.0;
  }
  *moving_s_ += dt_s;
  const double periods = *moving_s_ * config_.frequency_hz;
  if (periods >= 1.0) {
    moving_s_.reset();
    unseen_s_ = 0.0;
    return Eigen::Vector2d::Zero();
  }
  const double angle = 2.0 * std::numbers::pi * periods;
  return config_.amplitude_deg * rad_per_deg *
         Eigen::Vector2d(std::sin(angle), 0.5 * (1.0 - std::cos(angle)));
}

Eigen::Vector3d displaced(const Eigen::Vector3d& target_m, const Eigen::Vector2d& right_up_rad,
                          const HeadKinematics& head) {
  const Eigen::Isometry3d& eye = head.root_from_eye(Eye::left);
  const double distance_m = (target_m - eye.translation()).norm();
  return target_m + distance_m * (std::tan(right_up_rad[0]) * eye.linear().col(0) -
                                  std::tan(right_up_rad[1]) * eye.linear().col(1));
}

}  // namespace saccade
