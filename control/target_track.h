#pragma once

#include <Eigen/Core>

namespace saccade {

/// Where a gaze target is and how it moves, from the targets so far: a filter of third order with fading memory.
/// Behind a target of constant acceleration it has no lag.
///
/// Between targets the point goes on as it moved; after time_constant_s without one its motion fades out within that
/// time: a target that comes no more stays where it was last. After `forget_s` the next starts anew, at rest.
/// Source: Brookner, Tracking and Kalman Filtering Made Easy, section 1.3 (critically damped g-h-k filter).
class TargetTrack {
 public:
  static constexpr double forget_s = 0.5;

  /// time_constant_s of the memory; 0: the point is the newest target, at rest.
  explicit TargetTrack(double time_constant_s) : time_constant_s_(time_constant_s) {}

  void advance(double dt_s);
  /// A target at the time come to by advance(); finite, m, root frame.
  void observe(const Eigen::Vector3d& target_m);
  void forget() { known_ = false; }

  [[nodiscard]] bool is_known() const { return known_; }  ///< what follows means nothing otherwise
  [[nodiscard]] const Eigen::Vector3d& position_m() const { return position_m_; }
  [[nodiscard]] const Eigen::Vector3d& velocity_m_s() const { return velocity_m_s_; }

 private:
  double time_constant_s_;
  bool known_ = false;
  double since_s_ = 0.0;  ///< since the newest target
  Eigen::Vector3d position_m_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration_m_s2_ = Eigen::Vector3d::Zero();
};

}  // namespace saccade
