#pragma once

#include <Eigen/Core>

namespace saccade {

/// Estimates position and velocity of a gaze target: a fading-memory filter of third order, without lag for a target of
/// constant acceleration.
///
/// Between targets the estimate is extrapolated. After time_constant_s without a target its motion decays with the same
/// time constant, so the estimate comes to rest. After `forget_s` the next target restarts the filter at rest.
/// Source: Brookner, Tracking and Kalman Filtering Made Easy, section 1.3 (critically damped g-h-k filter).
class TargetTrack {
 public:
  static constexpr double forget_s = 0.5;

  /// time_constant_s: of the memory; 0: the estimate is the newest target, at rest.
  explicit TargetTrack(double time_constant_s) : time_constant_s_(time_constant_s) {}

  void advance(double dt_s);
  /// Adds a target at the current time of advance(). Finite, m, root frame.
  void observe(const Eigen::Vector3d& target_m);
  void forget() { known_ = false; }
  /// Continues from here, at rest.
  void rest_at(const Eigen::Vector3d& position_m);
  /// Adds to the estimate: the motion of a new origin relative to the old one.
  void shift(const Eigen::Vector3d& position_m, const Eigen::Vector3d& velocity_m_s,
             const Eigen::Vector3d& acceleration_m_s2);
  /// From the next target on.
  void set_time_constant(double time_constant_s) { time_constant_s_ = time_constant_s; }

  [[nodiscard]] bool is_known() const { return known_; }  ///< otherwise position and velocity have no meaning
  [[nodiscard]] const Eigen::Vector3d& position_m() const { return position_m_; }
  [[nodiscard]] const Eigen::Vector3d& velocity_m_s() const { return velocity_m_s_; }
  [[nodiscard]] const Eigen::Vector3d& acceleration_m_s2() const { return acceleration_m_s2_; }
  /// Time since the newest target.
  [[nodiscard]] double since_s() const { return since_s_; }

 private:
  double time_constant_s_;
  bool known_ = false;
  double since_s_ = 0.0;  ///< since the newest target
  Eigen::Vector3d position_m_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d acceleration_m_s2_ = Eigen::Vector3d::Zero();
};

}  // namespace saccade
