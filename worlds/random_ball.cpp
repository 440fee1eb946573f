#include <algorithm>
#include <array>
#include <numbers>

#include "worlds/random_world_parts.h"

namespace saccade::random_world {
namespace {

using Eigen::Vector3d;

/// Centre of the range of the room's reflectances (sim/lab.cpp).
constexpr double room_reflectance = 0.33;

std::array<double, 3> tinted(RandomGenerator& random, double value) {
  const auto channel = [&] { return std::clamp(value * random.real(0.75, 1.25), 0.02, 0.95); };
  const double red = channel();
  const double green = channel();
  return {red, green, channel()};
}

Vector3d any_direction(RandomGenerator& random) {
  const double z = random.real(-1.0, 1.0);
  const double around = random.real(0.0, 2.0 * std::numbers::pi);
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(around), r * std::sin(around), z};
}

TrajectoryConfig through_points(RandomGenerator& random, const Stage& stage, const BallSize& size) {
  TrajectoryConfig t;
  t.kind = TrajectoryKind::waypoints;
  t.points_m.clear();
  const int count = 3 + random.index(5);
  for (int i = 0; i < count; ++i) {
    t.points_m.push_back(stage.any_point(random, size.nearest_m, size.farthest_m));
  }
  t.profile = random.chance(0.5) ? SpeedProfile::minimum_jerk : SpeedProfile::constant_speed;
  t.dwell_s = random.chance(0.4) ? 0.0 : random.real(0.05, 0.5);
  t.ramp_s = random.real(0.05, 0.25);
  t.loop = true;
  return t;
}

TrajectoryConfig round_about(RandomGenerator& random, const Stage& stage, const BallSize& size,
                             double speed_m_s) {
  TrajectoryConfig t;
  t.kind = TrajectoryKind::circle;
  t.centre_m = stage.any_point(random, size.nearest_m, size.farthest_m);
  const double z_m = (stage.root_from_eye.inverse() * t.centre_m).z();
  const double reach_m = stage.metres_per_px(z_m) * stage.camera.size.height * random.real(0.08, 0.4);
  const Vector3d a = any_direction(random);
  const Vector3d b = a.cross(any_direction(random));
  t.radius_a_m = reach_m * a;
  t.radius_b_m = reach_m * random.real(0.5, 1.0) * b;
  t.frequency_hz = std::clamp(speed_m_s / (2.0 * std::numbers::pi * reach_m), 0.05, 4.0);
  t.ramp_s = random.real(0.1, 0.6);
  return t;
}

}  // namespace

BallSize draw_ball_size(RandomGenerator& random, const Stage& stage, double smallest_m) {
  constexpr double nearest_m = 0.17;
  constexpr double least_ratio = 1.35;  // of the farthest to the nearest depth
  const auto [low_px, high_px] = radius_range_px(stage.camera.size);
  for (;;) {
    const double radius_m = random.real(smallest_m, 0.05);
    const double near_m = std::max(nearest_m, 1.06 * stage.camera.fx_px * radius_m / high_px);
    const double far_m = std::min(stage.farthest_m, 0.94 * stage.camera.fx_px * radius_m / low_px);
    if (far_m > least_ratio * near_m) return {radius_m, near_m, far_m};
    // Only a large ball is large enough in a small image.
    smallest_m = std::min(0.049, smallest_m + 0.002);
  }
}

BallConfig draw_ball_kind(RandomGenerator& random) {
  BallConfig ball;
  constexpr BallPattern patterns[] = {BallPattern::plain,   BallPattern::plain, BallPattern::plain,
                                      BallPattern::striped, BallPattern::seams, BallPattern::patches};
  ball.pattern = one_of(random, patterns);
  if (random.chance(0.25)) ball.gloss = random.real(0.4, 1.0);
  constexpr Hand hands[] = {Hand::fingers, Hand::fist,   Hand::palm, Hand::sleeve,
                            Hand::stick,   Hand::string, Hand::none, Hand::none};
  ball.hand = one_of(random, hands);
  const bool turns = ball.hand != Hand::string && ball.hand != Hand::none;
  if (turns) ball.hand_turn_deg = random.real(-70.0, 70.0);
  if (random.chance(0.4)) ball.sleeve = Sleeve::checked;
  ball.rolls = ball.hand == Hand::none && random.chance(0.5);
  return ball;
}

void draw_colours(RandomGenerator& random, BallTone tone, BallConfig& ball) {
  const double value = tone == BallTone::darker ? log_real(random, 0.02, 0.12)
                       : tone == BallTone::brighter
                           ? log_real(random, 0.6, 0.92)
                           : log_real(random, 0.5 * room_reflectance, 1.5 * room_reflectance);
  ball.rgb = tinted(random, value);
  if (ball.pattern == BallPattern::plain) return;
  const double other = value > room_reflectance ? log_real(random, 0.03, 0.15) : log_real(random, 0.5, 0.9);
  ball.pattern_rgb = tinted(random, other);
  for (double& turn_deg : ball.pattern_turn_deg) turn_deg = random.real(-100.0, 100.0);
}

TrajectoryConfig draw_ball_motion(RandomGenerator& random, const Stage& stage, const BallConfig& ball,
                                  const BallSize& size, bool rests, bool leaves) {
  const double speed_m_s = log_real(random, 0.05, 3.0);
  TrajectoryConfig t;
  if (rests) {
    t.points_m = {stage.any_point(random, size.nearest_m, size.farthest_m)};
  } else if (ball.rolls) {  // to and fro on a line in a horizontal plane
    t.kind = TrajectoryKind::waypoints;
    t.profile = SpeedProfile::constant_speed;
    const Vector3d from = stage.any_point(random, size.nearest_m, size.farthest_m);
    Vector3d to = stage.any_point(random, size.nearest_m, size.farthest_m);
    to.z() = from.z();
    t.points_m = {from, to};
    t.loop = true;
    t.ramp_s = random.real(0.05, 0.25);
    t.dwell_s = random.chance(0.5) ? 0.0 : random.real(0.0, 0.3);
  } else if (ball.hand == Hand::none) {  // thrown to and fro
    t = through_points(random, stage, size);
    t.profile = SpeedProfile::free_fall;
    t.dwell_s = random.chance(0.5) ? 0.0 : random.real(0.0, 0.2);
  } else if (ball.hand == Hand::string) {  // a pendulum
    t = round_about(random, stage, size, speed_m_s);
    t.radius_a_m.z() *= 0.1;
    t.radius_b_m *= random.chance(0.5) ? 0.0 : random.real(0.1, 0.6);
    t.radius_b_m.z() *= 0.1;
  } else if (random.chance(0.35)) {
    t = round_about(random, stage, size, speed_m_s);
  } else {
    t = through_points(random, stage, size);
  }
  if (leaves && t.kind == TrajectoryKind::waypoints) {
    const double beyond = random.chance(0.5) ? random.real(-0.5, -0.15) : random.real(1.15, 1.5);
    const double z_m = log_real(random, size.nearest_m, size.farthest_m);
    const bool across = random.chance(0.6);
    const double other = random.real(0.2, 0.8);
    Vector3d out = stage.point(across ? beyond : other, across ? other : beyond, z_m);
    if (ball.rolls) out = Vector3d(out.x(), out.y(), t.points_m.front().z());
    t.points_m.back() = out;
  }
  t.speed_m_s = ball.hand == Hand::none && !ball.rolls ? std::max(speed_m_s, 0.6) : speed_m_s;
  t.start_s = random.real(0.0, 0.08);
  t.sway_m = ball.hand == Hand::none || random.chance(0.3) ? 0.0 : random.real(0.0005, 0.002);
  return t;
}

}  // namespace saccade::random_world
