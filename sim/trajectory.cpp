#include "sim/trajectory.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "core/random.h"
#include "core/units.h"
#include "head/minimum_jerk.h"

namespace saccade {
namespace {

using std::numbers::pi;
constexpr Range metres{-5.0, 5.0};
constexpr double gravity_m_s2 = 9.81;

/// Distance covered at u by a motion that accelerates from rest at u = 0 to unit speed at u = 1. The speed is a cubic
/// step, so the acceleration is continuous. The distance is 1/2 at u = 1.
double smooth_start(double u) {
  if (u <= 0.0) return 0.0;
  if (u >= 1.0) return u - 0.5;
  return u * u * u * (1.0 - 0.5 * u);
}

}  // namespace

void describe(FieldVisitor& v, TrajectoryConfig& c) {
  using Kind = TrajectoryKind;
  v.choice("kind", c.kind, "kind of motion");
  const bool has_points = c.kind == Kind::hold || c.kind == Kind::waypoints;
  if (v.fills_defaults() && !has_points && c.kind != Kind::circle) c.sway_m = 0.0;
  v.real("sway_m", c.sway_m, {0.0, 0.05}, "rms of the hand's unsteadiness along each axis");
  v.when(c.kind == Kind::circle, "kind: circle", [&] {
    v.reals("centre_m", c.centre_m, metres, "centre of the circle, root frame");
    v.reals("radius_a_m", c.radius_a_m, metres, "from the centre to the point at angle 0");
    v.reals("radius_b_m", c.radius_b_m, metres, "from the centre to the point at angle 90 degrees");
    v.real("frequency_hz", c.frequency_hz, {0.0, 5.0}, "turns per second");
    v.real("phase_deg", c.phase_deg, {-360.0, 360.0}, "angle of the first position");
  });
  v.when(has_points, "kind: hold or waypoints", [&] {
    v.points("points_m", c.points_m, metres, "centres of the object, root frame, x backward, y right, z up");
    const std::string found = std::to_string(c.points_m.size()) + " points";
    if (c.kind == Kind::waypoints) {
      v.require(c.points_m.size() >= 2, "points_m", found, "at least two points");
    } else {
      v.require(c.points_m.size() == 1, "points_m", found, "one point for kind hold");
    }
  });
  v.when(c.kind == Kind::waypoints, "kind: waypoints", [&] {
    v.choice("profile", c.profile, "speed along a segment");
    v.real("speed_m_s", c.speed_m_s, {0.001, 10.0},
           "mean (minimum_jerk, free_fall) or full speed along a segment");
    v.real("dwell_s", c.dwell_s, {0.0, 60.0}, "rest at every point after the first");
    v.boolean("loop", c.loop, "from the last point back to the first, without end");
    for (std::size_t i = 1; i < c.points_m.size(); ++i) {
      v.require(c.points_m[i] != c.points_m[i - 1], "points_m", "point " + std::to_string(i + 1) + " twice",
                "points that differ from the previous one (for a rest use dwell_s)");
    }
  });
  v.when(c.kind == Kind::csv, "kind: csv", [&] { describe(v, c.csv); });
  v.when(c.kind == Kind::pendulum, "kind: pendulum", [&] { describe(v, c.pendulum); });
  v.when(c.kind == Kind::ballistic, "kind: ballistic", [&] { describe(v, c.ballistic); });
  v.when(c.kind == Kind::pushed, "kind: pushed", [&] { describe(v, c.pushed); });
  v.when(c.kind != Kind::hold, "kind: any but hold", [&] {
    v.real("start_s", c.start_s, {0.0, 3600.0}, "start of the motion");
  });
  const bool has_ramps =
      c.kind == Kind::circle || (c.kind == Kind::waypoints && c.profile == SpeedProfile::constant_speed);
  v.when(has_ramps, "kind: circle, or profile: constant_speed", [&] {
    v.real("ramp_s", c.ramp_s, {0.01, 10.0}, "time to reach full speed, and to stop");
  });
}

Trajectory::Trajectory(const TrajectoryConfig& config, std::uint64_t seed, const BodyShape& shape,
                       const std::string& place)
    : config_(config) {
  check_config(place, config);
  if (config.kind == TrajectoryKind::waypoints) {
    const std::size_t count = config.points_m.size();
    for (std::size_t i = 0; i < (config.loop ? count : count - 1); ++i) {
      Segment segment{config.points_m[i], config.points_m[(i + 1) % count], lap_s_, 0.0, 0.0};
      const double length_m = (segment.to_m - segment.from_m).norm();
      if (length_m == 0.0) continue;  // a loop whose last point is its first
      segment.move_s = length_m / config.speed_m_s;
      if (config.profile == SpeedProfile::constant_speed) {
        // Both ramps together cover speed * ramp_s; a segment shorter than that is ramps only, slower.
        segment.ramp_s = config.ramp_s;
        segment.move_s = std::max(segment.move_s, config.ramp_s) + config.ramp_s;
      }
      lap_s_ += segment.move_s + config.dwell_s;
      segments_.push_back(segment);
    }
  }

  if (config.kind == TrajectoryKind::csv) {
    MotionTable table = read_motion_file(config.csv);
    turns_ = table.turns;
    track_ = std::make_shared<const MotionTrack>(std::move(table.track));
  }
  if (moves_as_free_body(config.kind)) {
    turns_ = true;
    track_ = std::make_shared<const MotionTrack>(config.kind == TrajectoryKind::ballistic
                                                     ? ballistic_motion(config.ballistic, shape, place)
                                                     : pushed_motion(config.pushed, shape, place));
  }
  if (config.kind == TrajectoryKind::pendulum) {
    turns_ = true;
    pendulum_.emplace(config.pendulum);
  }

  const RandomStream random(seed, "sim/trajectory/sway");
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double square_sum = 0.0;
    for (std::size_t i = 0; i < sway_terms; ++i) {
      const double frequency_hz = 0.5 * std::pow(6.0, random.uniform(axis, 2 * i));  // 0.5 to 3 Hz
      const double phase_rad = random.uniform(0.0, 2.0 * pi, axis, 2 * i + 1);
      sway_[axis][i] = {1.0 / frequency_hz, 2.0 * pi * frequency_hz, phase_rad};
      square_sum += 0.5 / (frequency_hz * frequency_hz);
    }
    for (Sinusoid& term : sway_[axis]) term.amplitude_m *= config.sway_m / std::sqrt(square_sum);
  }
}

std::int64_t Trajectory::first_motion_us() const {
  return config_.kind == TrajectoryKind::hold ? 0 : std::llround(config_.start_s * 1e6);
}

Eigen::Vector3d Trajectory::position_m(std::int64_t t_us) const {
  const double t_s = static_cast<double>(std::max<std::int64_t>(t_us, 0)) * 1e-6;
  return commanded_m(t_s) + Eigen::Vector3d(sway_m(0, t_s), sway_m(1, t_s), sway_m(2, t_s));
}

Eigen::Quaterniond Trajectory::turn(std::int64_t t_us) const {
  if (!turns_) return Eigen::Quaterniond::Identity();
  const double moving_s = 1e-6 * static_cast<double>(std::max<std::int64_t>(t_us, 0)) - config_.start_s;
  return pendulum_ ? pendulum_->turn(moving_s) : track_->turn(moving_s);
}

Eigen::Vector3d Trajectory::commanded_m(double t_s) const {
  const double moving_s = t_s - config_.start_s;
  if (track_) return track_->position_m(moving_s);
  if (pendulum_) return pendulum_->position_m(moving_s);
  if (config_.kind == TrajectoryKind::waypoints) return along_waypoints_m(moving_s);
  if (config_.kind == TrajectoryKind::circle) {
    const double turning_s = config_.ramp_s * smooth_start(moving_s / config_.ramp_s);
    const double angle_rad = config_.phase_deg * rad_per_deg + 2.0 * pi * config_.frequency_hz * turning_s;
    return config_.centre_m + std::cos(angle_rad) * config_.radius_a_m +
           std::sin(angle_rad) * config_.radius_b_m;
  }
  return config_.points_m.front();
}

Eigen::Vector3d Trajectory::along_waypoints_m(double moving_s) const {
  if (moving_s <= 0.0) return segments_.front().from_m;
  if (config_.loop) moving_s = std::fmod(moving_s, lap_s_);
  const auto next = std::upper_bound(segments_.begin(), segments_.end(), moving_s,
                                     [](double t_s, const Segment& s) { return t_s < s.start_s; });
  const Segment& segment = *std::prev(next);
  const double t_s = moving_s - segment.start_s;
  double share = 1.0;  // of the segment's length
  if (config_.profile == SpeedProfile::free_fall) {
    share = std::clamp(t_s / segment.move_s, 0.0, 1.0);
  } else if (segment.ramp_s == 0.0) {
    share = minimum_jerk(std::clamp(t_s / segment.move_s, 0.0, 1.0));
  } else if (t_s < segment.move_s) {
    const double ramp_s = segment.ramp_s;
    const double full_s = segment.move_s - ramp_s;
    share = ramp_s * (smooth_start(t_s / ramp_s) - smooth_start((t_s - full_s) / ramp_s)) / full_s;
  }
  Eigen::Vector3d at_m = segment.from_m + share * (segment.to_m - segment.from_m);
  if (config_.profile == SpeedProfile::free_fall) {
    at_m.z() += 0.5 * gravity_m_s2 * segment.move_s * segment.move_s * share * (1.0 - share);
  }
  return at_m;
}

double Trajectory::sway_m(int axis, double t_s) const {
  double sum_m = 0.0;
  for (const Sinusoid& term : sway_[static_cast<std::size_t>(axis)]) {
    sum_m += term.amplitude_m * std::sin(term.angular_rad_s * t_s + term.phase_rad);
  }
  return minimum_jerk(std::min(t_s, 1.0)) * sum_m;
}

}  // namespace saccade
