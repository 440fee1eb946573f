#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/config.h"

namespace saccade {

/// How the ball or another thing is moved. Points are its centres in the root frame (x backward, y right, z up), m.
struct TrajectoryConfig {
  std::string kind = "hold";  ///< `hold`, `waypoints` or `circle`
  /// The commanded motion begins here; before it the thing is held at its first position.
  double start_s = 0.0;

  // hold and waypoints
  std::vector<std::vector<double>> points_m = {{-0.5, 0.0, 0.347}};  ///< hold: one; waypoints: in this order

  // waypoints
  std::string profile = "minimum_jerk";  ///< `minimum_jerk` or `constant_speed`
  /// Along every segment: the mean speed of a minimum-jerk move (its peak is 1.875 times that), the speed
  /// between the smooth ends of a constant-speed one.
  double speed_m_s = 0.1;
  double dwell_s = 0.0;  ///< rest at every point after the first
  bool loop = false;     ///< from the last point on to the first, for ever

  // circle: centre + a cos(angle) + b sin(angle), angle = phase + 2 pi frequency (t - start)
  std::vector<double> centre_m = {-0.5, 0.0, 0.347};
  std::vector<double> radius_a_m = {0.0, 0.1, 0.0};
  std::vector<double> radius_b_m = {0.0, 0.0, 0.1};  ///< zero for a to and fro along a
  double frequency_hz = 0.2;
  double phase_deg = 0.0;

  // waypoints with constant_speed, circle
  double ramp_s = 0.2;  ///< time to reach full speed, and to stop

  /// No hand is still: root mean square of the sway along each axis. 0 for none.
  double sway_m = 0.0015;
};

/// Keys as above; those that do not belong to `kind` and `profile` are not visited.
void describe(FieldVisitor& v, TrajectoryConfig& config);

/// Where the thing's centre is, as a function of time alone. Position, velocity and acceleration are
/// continuous. The sway is a sum of seeded sinusoids of 0.5 to 3 Hz, slow ones larger, that grows from
/// nothing in the first second.
class Trajectory {
 public:
  /// Throws InputError where the configuration breaks its ranges.
  Trajectory(const TrajectoryConfig& config, std::uint64_t seed);

  /// The centre, root frame, m. Times before 0 are those of 0.
  [[nodiscard]] Eigen::Vector3d position_m(std::int64_t t_us) const;
  /// Start of the commanded motion (sway does not count); 0 for a thing that is held.
  [[nodiscard]] std::int64_t first_motion_us() const;

 private:
  struct Segment {
    Eigen::Vector3d from_m;
    Eigen::Vector3d to_m;
    double start_s;  ///< after the start of the commanded motion
    double move_s;   ///< how long it moves; it rests from there to the next segment
    double ramp_s;
  };
  struct Sinusoid {
    double amplitude_m;
    double angular_rad_s;
    double phase_rad;
  };
  static constexpr int sway_terms = 8;

  [[nodiscard]] Eigen::Vector3d commanded_m(double t_s) const;
  [[nodiscard]] Eigen::Vector3d along_waypoints_m(double moving_s) const;
  [[nodiscard]] double sway_m(int axis, double t_s) const;

  TrajectoryConfig config_;
  std::vector<Segment> segments_;
  double lap_s_ = 0.0;  ///< duration of all segments with their rests
  std::array<std::array<Sinusoid, sway_terms>, 3> sway_{};
};

}  // namespace saccade
