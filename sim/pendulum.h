#pragma once

#include <Eigen/Geometry>

#include "core/config.h"

namespace saccade {

/// An object that swings on a rod without mass and friction, in one plane.
struct PendulumConfig {
  Eigen::Vector3d pivot_m = {-0.5, 0.0, 0.95};
  double length_m = 0.6;  ///< from the pivot to the object's centre
  double amplitude_deg = 15.0;
  double plane_deg = 0.0;  ///< of the swing about z: 0 swings along y, 90 along x
};

/// Keys: pivot_m, length_m, amplitude_deg, plane_deg.
void describe(FieldVisitor& v, PendulumConfig& config);

/// The exact motion (Jacobi's elliptic functions), released from rest at the amplitude at time 0.
class Pendulum {
 public:
  explicit Pendulum(const PendulumConfig& config);

  /// Angle from the vertical, rad; before time 0 the amplitude.
  [[nodiscard]] double angle_rad(double t_s) const;
  [[nodiscard]] Eigen::Vector3d position_m(double t_s) const;
  /// The object turns with the rod: upright where it hangs straight down.
  [[nodiscard]] Eigen::Quaterniond turn(double t_s) const;

 private:
  Eigen::Vector3d pivot_m_;
  Eigen::Vector3d sideways_;  ///< unit vector of the swing
  double length_m_;
  double angular_rad_s_;  ///< of small swings
  double modulus_;        ///< sine of half the amplitude
};

}  // namespace saccade
