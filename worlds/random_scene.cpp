#include <algorithm>
#include <array>
#include <string>

#include "core/units.h"
#include "worlds/random_world_parts.h"

namespace saccade::random_world {

using Eigen::Vector3d;

Vector3d Stage::point(double u, double v, double z_m) const {
  const Vector3d ray = camera.ray(u * camera.size.width - 0.5, v * camera.size.height - 0.5);
  return root_from_eye * (z_m * ray);
}

Vector3d Stage::any_point(RandomGenerator& random, double near_m, double far_m) const {
  const double u = random.real(0.12, 0.88);
  const double v = random.real(0.14, 0.86);
  return point(u, v, log_real(random, near_m, far_m));
}

Camera draw_camera(RandomGenerator& random) {
  constexpr ImageSize sizes[] = {{64, 64},   {96, 96},   {128, 128}, {160, 120},
                                 {240, 180}, {304, 240}, {346, 260}};
  Camera camera;
  camera.size = one_of(random, sizes);
  const double half_view_rad = 0.5 * rad_per_deg * random.real(42.0, 78.0);  // from left to right
  camera.fx_px = 0.5 * camera.size.width / std::tan(half_view_rad);
  camera.fy_px = camera.fx_px;
  const auto lens = [&] { return random.real(-0.12, -0.03); };  // k1
  if (random.chance(0.25)) camera.k1 = lens();
  camera.cx_px = 0.5 * (camera.size.width - 1) + 0.03 * camera.size.width * random.real(-1.0, 1.0);
  camera.cy_px = 0.5 * (camera.size.height - 1) + 0.03 * camera.size.height * random.real(-1.0, 1.0);
  while (!is_invertible(camera)) camera.k1 = lens();
  return camera;
}

double bus_rate_hz(const EmulatorConfig& preset, ImageSize size) {
  constexpr double dvs128_pixels = 128.0 * 128.0;
  const double ratio = static_cast<double>(size.pixels()) / dvs128_pixels;
  if (preset.readout_rate_hz == 0.0 || ratio <= 1.0) return preset.readout_rate_hz;
  constexpr double step_hz = 1000.0;  // so that the rate is the same number with every library of mathematics
  const double of_size_hz = step_hz * std::round(1e6 * std::pow(ratio, 1.459) / step_hz);
  return std::max(preset.readout_rate_hz, of_size_hz);
}

EmulatorConfig draw_sensor(RandomGenerator& random) {
  constexpr const char* sensors[] = {"ideal", "dvs128",     "noisy",     "davis346",
                                     "atis",  "few_events", "asymmetric"};
  return emulator_preset(one_of(random, sensors));
}

LabConfig draw_lab(RandomGenerator& random) {
  LabConfig lab;
  const auto families = words_of(Clutter{});
  lab.clutter = families[static_cast<std::size_t>(random.index(static_cast<int>(families.size())))].value;
  lab.density = random.real(0.4, 1.6);
  lab.contrast = random.real(0.5, 1.2);
  lab.brightness = log_real(random, 0.3, 1.2);
  lab.wall_distance_m = random.real(2.2, 3.4);
  const auto several = [&] { return random.chance(0.25) ? 1 + random.index(3) : 0; };
  lab.round.discs = several();
  lab.round.clocks = several();
  lab.round.wheels = several();
  lab.round.cups = several();
  lab.round.balls = several();
  if (random.chance(0.3)) lab.shapes = 1 + random.index(5);
  return lab;
}

HeadMotion draw_motion(RandomGenerator& random) {
  const double kind = random.real(0.0, 1.0);
  if (kind < 0.4) return HeadMotion::still;
  if (kind < 0.7) return HeadMotion::eyes;
  return kind < 0.85 ? HeadMotion::neck : HeadMotion::both;
}

ScriptConfig draw_script(RandomGenerator& random, HeadMotion motion, bool alone) {
  const bool eyes = motion == HeadMotion::eyes || motion == HeadMotion::both;
  const bool neck = motion == HeadMotion::neck || motion == HeadMotion::both;
  ScriptConfig script;
  script.eyes_deg.clear();
  const int count = 3 + random.index(4);
  for (int i = 0; i < count; ++i) {
    script.eyes_deg.push_back({eyes ? random.real(-10.0, 10.0) : 0.0, eyes ? random.real(-14.0, 14.0) : 0.0});
    if (neck) {
      script.neck_deg.push_back({random.real(-10.0, 8.0), random.real(-8.0, 8.0), random.real(-12.0, 12.0)});
    }
  }
  script.speed_deg_s = neck ? log_real(random, 10.0, 70.0) : log_real(random, 30.0, 300.0);
  script.dwell_s = alone ? random.real(0.03, 0.1) : log_real(random, 0.03, 0.5);
  return script;
}

namespace {

std::array<double, 3> any_rgb(RandomGenerator& random) {
  const double v = log_real(random, 0.05, 0.85);
  const auto channel = [&] { return std::clamp(v * random.real(0.7, 1.3), 0.02, 0.92); };
  const double red = channel();
  const double green = channel();
  return {red, green, channel()};
}

/// Back and forth between points, or round and round, with an image in motion from 0.1 s on.
TrajectoryConfig wander(RandomGenerator& random, const Stage& stage, double near_m, double far_m) {
  TrajectoryConfig t;
  t.sway_m = random.chance(0.5) ? 0.0 : 0.0015;
  t.start_s = random.real(0.0, 0.08);
  const Vector3d from = stage.any_point(random, near_m, far_m);
  if (random.chance(0.4)) {
    t.kind = TrajectoryKind::circle;
    t.centre_m = from;
    const double reach_m = 0.3 * (stage.root_from_eye.inverse() * from).z();
    t.radius_a_m = reach_m * Vector3d(random.real(-0.3, 0.3), random.real(-1.0, 1.0), random.real(-1.0, 1.0));
    t.radius_b_m = reach_m * Vector3d(random.real(-0.3, 0.3), random.real(-1.0, 1.0), random.real(-1.0, 1.0));
    t.frequency_hz = log_real(random, 0.1, 1.2);
    return t;
  }
  t.kind = TrajectoryKind::waypoints;
  t.points_m = {from};
  const int count = 2 + random.index(3);
  for (int i = 1; i < count; ++i) t.points_m.push_back(stage.any_point(random, near_m, far_m));
  t.profile = random.chance(0.5) ? SpeedProfile::minimum_jerk : SpeedProfile::constant_speed;
  t.speed_m_s = log_real(random, 0.08, 1.5);
  t.dwell_s = random.chance(0.5) ? 0.0 : random.real(0.0, 0.4);
  t.loop = true;
  return t;
}

ObjectConfig walker(RandomGenerator& random, const Stage& stage) {
  ObjectConfig person;
  person.shape = ObjectShape::person;
  person.rgb = any_rgb(random);
  TrajectoryConfig& t = person.trajectory;
  const double x = -(0.4 + random.real(0.9, 1.0) * stage.farthest_m);
  const double side = random.chance(0.5) ? 1.0 : -1.0;
  const double width = random.real(0.4, 0.9);
  t.kind = TrajectoryKind::waypoints;
  t.points_m = {{x, side * width * random.real(-0.5, 1.0), -0.62}, {x, -side * width, -0.62}};
  t.points_m.push_back({x, side * width, -0.62});
  t.profile = SpeedProfile::constant_speed;
  t.speed_m_s = random.real(0.4, 1.4);
  t.start_s = random.real(0.0, 0.08);
  t.dwell_s = random.real(0.0, 0.4);
  t.loop = true;
  t.sway_m = 0.0;
  return person;
}

ObjectConfig any_distractor(RandomGenerator& random, const Stage& stage) {
  // An ellipsoid stands for an ellipse, its axes' ratio below 0.85.
  constexpr ObjectShape shapes[] = {ObjectShape::box,       ObjectShape::prism,        ObjectShape::cylinder,
                                    ObjectShape::ellipsoid, ObjectShape::covered_disc, ObjectShape::hand,
                                    ObjectShape::person};
  const ObjectShape shape = one_of(random, shapes);
  if (shape == ObjectShape::person) return walker(random, stage);
  ObjectConfig object;
  object.shape = shape;
  object.rgb = any_rgb(random);
  const double near_m = shape == ObjectShape::hand ? 0.45 : 0.3;
  object.trajectory = wander(random, stage, near_m, std::max(stage.farthest_m, 1.2 * near_m));
  const TrajectoryConfig& t = object.trajectory;
  const Vector3d at_m = t.kind == TrajectoryKind::circle ? t.centre_m : t.points_m.front();
  const double across_m = 2.0 * random.real(5.0, std::max(6.0, 0.22 * stage.camera.size.height)) *
                          stage.metres_per_px((stage.root_from_eye.inverse() * at_m).z());
  const auto turns = [&](double largest_deg_s) { return random.real(-largest_deg_s, largest_deg_s); };
  switch (shape) {
    case ObjectShape::box:
      object.size_m = {across_m * random.real(0.2, 1.0), across_m, across_m * random.real(0.4, 1.6)};
      object.turn_deg = {turns(90.0), turns(40.0), turns(40.0)};
      if (random.chance(0.5)) object.turn_deg_s = {turns(180.0), turns(40.0), turns(40.0)};
      break;
    case ObjectShape::prism:
      object.size_m = {across_m * random.real(0.2, 1.0), across_m, across_m};
      object.turn_deg = {turns(30.0), turns(25.0), turns(25.0)};
      if (random.chance(0.5)) object.turn_deg_s = {turns(180.0), 0.0, 0.0};
      break;
    case ObjectShape::cylinder:
      object.size_m = {across_m, across_m, across_m * random.real(0.7, 2.0)};
      object.turn_deg = {turns(90.0), 0.0, 0.0};
      break;
    case ObjectShape::ellipsoid:
      object.size_m = {0.01, across_m, across_m * random.real(0.4, 0.8)};
      object.turn_deg = {turns(90.0), 0.0, 0.0};
      break;
    case ObjectShape::covered_disc:
      object.size_m = {0.01, across_m, across_m};
      object.shown_share = random.real(0.2, 0.58);
      object.cover_rgb = any_rgb(random);
      object.turn_deg = {turns(180.0), 0.0, 0.0};
      break;
    default:
      object.wave_hz = random.real(0.5, 3.0);
      object.turn_deg = {turns(40.0), 0.0, turns(40.0)};
  }
  return object;
}

}  // namespace

NamedObjects draw_distractors(RandomGenerator& random, const Stage& stage, int count) {
  NamedObjects objects;
  for (int i = 0; i < count; ++i) {
    objects.emplace_back("distractor_" + std::to_string(i + 1), any_distractor(random, stage));
  }
  return objects;
}

ObjectConfig draw_board(RandomGenerator& random, const Stage& stage, const Vector3d& ball_m,
                        double ball_radius_m) {
  ObjectConfig board;
  board.shape = ObjectShape::box;
  board.rgb = any_rgb(random);
  const Vector3d eye_m = stage.root_from_eye.translation();
  const double share = random.real(0.55, 0.8);  // of the way from the eye to the ball
  const Vector3d at_m = eye_m + share * (ball_m - eye_m);
  const double height_m = share * ball_radius_m * random.real(4.0, 7.0);
  board.size_m = {0.004, share * ball_radius_m * random.real(2.5, 5.0), height_m};
  TrajectoryConfig& t = board.trajectory;
  const double side = random.chance(0.5) ? 1.0 : -1.0;
  const double aside_m = share * 0.6 * stage.metres_per_px((ball_m - eye_m).norm()) * stage.camera.size.width;
  const Vector3d aside(0.0, side * aside_m, 0.0);
  t.kind = TrajectoryKind::waypoints;
  t.points_m = {at_m + aside, at_m - aside};
  t.profile = SpeedProfile::constant_speed;
  t.speed_m_s = std::max(0.02, 2.0 * aside_m / random.real(0.8, 2.5));
  t.start_s = random.real(0.3, 1.5);
  t.dwell_s = random.real(0.5, 1.5);
  t.loop = true;
  t.sway_m = 0.0;
  return board;
}

}  // namespace saccade::random_world
