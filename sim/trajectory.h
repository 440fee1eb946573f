#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/config.h"
#include "sim/free_body.h"
#include "sim/motion_file.h"
#include "sim/pendulum.h"

namespace saccade {

/// Kind of an object's motion.
enum class TrajectoryKind { hold, waypoints, circle, csv, pendulum, ballistic, pushed };
constexpr auto words_of(TrajectoryKind) {
  return std::to_array<Word<TrajectoryKind>>({{TrajectoryKind::hold, "hold"},
                                              {TrajectoryKind::waypoints, "waypoints"},
                                              {TrajectoryKind::circle, "circle"},
                                              {TrajectoryKind::csv, "csv"},
                                              {TrajectoryKind::pendulum, "pendulum"},
                                              {TrajectoryKind::ballistic, "ballistic"},
                                              {TrajectoryKind::pushed, "pushed"}});
}

/// Whether MuJoCo computes the motion from the object's shape.
[[nodiscard]] constexpr bool moves_as_free_body(TrajectoryKind kind) {
  return kind == TrajectoryKind::ballistic || kind == TrajectoryKind::pushed;
}

/// Speed along a segment between two waypoints.
enum class SpeedProfile { minimum_jerk, constant_speed, free_fall };
constexpr auto words_of(SpeedProfile) {
  return std::to_array<Word<SpeedProfile>>({{SpeedProfile::minimum_jerk, "minimum_jerk"},
                                            {SpeedProfile::constant_speed, "constant_speed"},
                                            {SpeedProfile::free_fall, "free_fall"}});
}

/// The motion of the ball or of another object. Points are its centres in the root frame (x backward, y right, z up), m.
struct TrajectoryConfig {
  TrajectoryKind kind = TrajectoryKind::hold;
  /// Start of the commanded motion; before it the object stays at its first position.
  double start_s = 0.0;

  // hold and waypoints
  std::vector<Eigen::Vector3d> points_m = {
      Eigen::Vector3d(-0.5, 0.0, 0.347)};  ///< hold: one point; waypoints: in this order

  // waypoints
  SpeedProfile profile = SpeedProfile::minimum_jerk;
  /// Speed along every segment: the mean speed of a minimum-jerk move (the peak is 1.875 times as high), or the speed
  /// between the ramps of a constant-speed move. A throw (free_fall) takes length / speed, so that slow ones are high.
  double speed_m_s = 0.1;
  double dwell_s = 0.0;  ///< rest at every point after the first
  bool loop = false;     ///< from the last point back to the first, without end

  // circle: centre + a cos(angle) + b sin(angle), angle = phase + 2 pi frequency (t - start)
  Eigen::Vector3d centre_m = {-0.5, 0.0, 0.347};
  Eigen::Vector3d radius_a_m = {0.0, 0.1, 0.0};
  Eigen::Vector3d radius_b_m = {0.0, 0.0, 0.1};  ///< zero for an oscillation along a
  double frequency_hz = 0.2;
  double phase_deg = 0.0;

  // waypoints with constant_speed, circle
  double ramp_s = 0.2;  ///< time to reach full speed, and to stop

  /// Root mean square of the hand's unsteadiness along each axis; 0 for none. A scenario that does not give it has the
  /// default below with hold, waypoints and circle, else 0.
  double sway_m = 0.0015;

  MotionFileConfig csv;
  PendulumConfig pendulum;
  BallisticConfig ballistic;
  PushConfig pushed;
};

/// Keys as above; those that do not belong to `kind` and `profile` are not visited.
void describe(FieldVisitor& v, TrajectoryConfig& config);

/// Position of an object's centre as a function of time. Position, velocity and acceleration are continuous; with
/// free_fall the position is, and the velocity jumps where the object is thrown and caught; with csv position and velocity
/// are between the first row and the last; ballistic and pushed objects move as MuJoCo computes it. The sway is
/// a sum of seeded sinusoids of 0.5 to 3 Hz, with larger amplitudes at lower frequencies, that grows from 0 in the first
/// second.
class Trajectory {
 public:
  /// `shape`: of the object, for ballistic and pushed motions. Throws InputError at `place` for a configuration out of
  /// range, and as read_motion_file(), ballistic_motion() and pushed_motion().
  Trajectory(const TrajectoryConfig& config, std::uint64_t seed, const BodyShape& shape = {},
             const std::string& place = "trajectory");

  /// The centre, root frame, m. Times before 0 count as 0.
  [[nodiscard]] Eigen::Vector3d position_m(std::int64_t t_us) const;
  /// Whether the motion turns the object, and its orientation (root from object; without: the identity).
  [[nodiscard]] bool turns() const { return turns_; }
  [[nodiscard]] Eigen::Quaterniond turn(std::int64_t t_us) const;
  /// Start of the commanded motion (without sway); 0 for `hold`.
  [[nodiscard]] std::int64_t first_motion_us() const;

 private:
  struct Segment {
    Eigen::Vector3d from_m;
    Eigen::Vector3d to_m;
    double start_s;  ///< after the start of the commanded motion
    double move_s;   ///< duration of the motion; from its end to the next segment the object rests
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
  double lap_s_ = 0.0;                        ///< duration of all segments with their rests
  std::shared_ptr<const MotionTrack> track_;  ///< of a table, or as computed
  std::optional<Pendulum> pendulum_;
  bool turns_ = false;
  std::array<std::array<Sinusoid, sway_terms>, 3> sway_{};
};

}  // namespace saccade
