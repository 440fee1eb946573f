#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <optional>

#include "control/controller_registry.h"
#include "tests/control/genova02.h"

namespace saccade {

inline constexpr double dt = 1e-3;

/// Joints that follow their references with a first-order lag, sag under a constant load, and are read
/// with their true position. A time constant of 0 is the ideal plant: joints are where they were sent.
class Plant {
 public:
  explicit Plant(double time_constant_s = 0.02) : gain_(1.0 - std::exp(-dt / time_constant_s)) {}

  HeadState state;
  HeadJointVector sag_rad = HeadJointVector::Zero();

  void follow(const HeadJointVector& reference_rad) {
    const HeadJointVector before = state.head_position_rad();
    const HeadJointVector after = before + gain_ * (reference_rad + sag_rad - before);
    state.position_rad.tail<gaze_slots>() = after;
    state.velocity_rad_s.tail<gaze_slots>() = (after - before) / dt;
    state.t_us += 1000;
  }

 private:
  double gain_;
};

inline double angle_deg(Eye eye, const JointVector& q, const Eigen::Vector3d& target_m) {
  const Eigen::Isometry3d pose = HeadKinematics(default_head()->chain, q).root_from_eye(eye);
  const Eigen::Vector3d to_target = target_m - pose.translation();
  const Eigen::Vector3d z = pose.linear().col(2);
  return std::atan2(z.cross(to_target).norm(), z.dot(to_target)) / rad_per_deg;
}

/// A point seen from between the eyes at q = 0: azimuth to the right, elevation up, degrees.
inline Eigen::Vector3d seen_at(double azimuth_deg, double elevation_deg, double distance_m) {
  const double a = azimuth_deg * rad_per_deg, e = elevation_deg * rad_per_deg;
  return Eigen::Vector3d(-0.0564, 0.0, 0.34685) +
         distance_m * Eigen::Vector3d(-std::cos(e) * std::cos(a), std::cos(e) * std::sin(a), std::sin(e));
}

inline Eigen::Vector3d random_target(const RandomStream& random, std::uint64_t i) {
  return seen_at(random.uniform(-50, 50, 0, i), random.uniform(-30, 25, 1, i),
                 random.uniform(0.25, 0.6, 2, i));
}

inline std::unique_ptr<GazeController> controller(
    const GazeControllerConfig& config = built_in_controllers().config()) {
  return make_gaze_controller(config, genova02_limits());
}

/// A joint outside of the hardware's limits, of reference or plant.
inline bool violates(const HeadJointVector& q_rad) {
  const JointLimits limits = genova02_limits();
  const auto q = q_rad.array();
  return !((q >= limits.min_rad.tail<gaze_slots>().array()) &&
           (q <= limits.max_rad.tail<gaze_slots>().array()))
              .all();
}

/// Hands over `target` once, then lets time pass.
inline void run(GazeController& gaze, Plant& plant, const std::optional<Eigen::Vector3d>& target,
                double duration_s) {
  const int steps = static_cast<int>(duration_s / dt);
  for (int i = 0; i < steps; ++i) plant.follow(gaze.step(plant.state, i == 0 ? target : std::nullopt, dt));
}

}  // namespace saccade
