#include "apps/config/random_world.h"

#include <algorithm>
#include <cmath>

#include "apps/config/camera_path.h"
#include "apps/config/random_world_parts.h"
#include "control/head_kinematics.h"
#include "core/units.h"

namespace saccade {
namespace {

using namespace random_world;

constexpr double ball_share = 0.8;
/// From the middle of the furniture before the wall to the wall, and some room for the ball.
constexpr double furniture_depth_m = 1.3;

/// The left eye where all joints are at the mean of a script's points.
Eigen::Isometry3d mean_root_from_eye(const ScriptConfig& script) {
  JointVector pose_rad = JointVector::Zero();
  for (const auto& eyes_deg : script.eyes_deg) {
    pose_rad[eyes_tilt] += eyes_deg[0];
    pose_rad[eyes_version] += eyes_deg[1];
  }
  for (const auto& neck_deg : script.neck_deg) {
    for (int j = 0; j < 3; ++j) pose_rad[neck_pitch + j] += neck_deg[static_cast<std::size_t>(j)];
  }
  pose_rad *= rad_per_deg / static_cast<double>(script.eyes_deg.size());
  return HeadKinematics(pose_rad).root_from_eye(Eye::left);
}

/// Where the ball is in the middle of its motion, for a board to pass there.
Eigen::Vector3d middle_of(const TrajectoryConfig& t) {
  if (t.kind == TrajectoryKind::circle) return t.centre_m;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : t.points_m) sum += point;
  return sum / static_cast<double>(t.points_m.size());
}

/// Draws ball, its motion and a board until the ball is seen as it must be.
void draw_ball(RandomGenerator& random, std::uint64_t seed, const Stage& stage, DrawnWorld& world) {
  const bool moves = world.motion != HeadMotion::still;
  const bool leaves = random.chance(0.25);
  const bool hidden = random.chance(0.2);
  const CameraPath path(moves ? &world.script : nullptr, world.sim.world.initial_pose_deg, world.duration_s);
  const auto [low_px, high_px] = radius_range_px(stage.camera.size);
  const double fastest_px_s = 14.0 * stage.camera.size.width;
  const NamedObjects others = world.sim.world.objects;
  BallConfig ball = draw_ball_look(random);
  // A hand of natural size hides a ball that is much smaller.
  const double smallest_m = ball.hand == Hand::fingers ? 0.03 : 0.015;
  for (int attempt = 0;; ++attempt) {
    const BallSize size = draw_ball_size(random, stage, smallest_m);
    ball.diameter_m = 2.0 * size.radius_m;
    const bool may_leave = leaves && attempt < 300;
    ball.trajectory = draw_ball_motion(random, stage, ball, size, moves, may_leave);
    NamedObjects objects = others;
    if (hidden && attempt < 300) {
      objects.emplace_back("board", draw_board(random, stage, middle_of(ball.trajectory), size.radius_m));
    }
    const BallView view =
        view_of(path, stage.camera, Trajectory(ball.trajectory, seed), size.radius_m, objects, seed);
    const bool is_right =
        view.in_view_share >= 0.6 && view.smallest_px >= 1.01 * low_px && view.largest_px <= 0.99 * high_px &&
        view.fastest_px_s <= fastest_px_s &&
        (!may_leave || ball.trajectory.kind != TrajectoryKind::waypoints || view.in_view_share < 0.97);
    if (!is_right && attempt < 2000) continue;
    world.sim.world.ball = ball;
    world.sim.world.objects = objects;
    world.in_view_share = view.in_view_share;
    return;
  }
}

}  // namespace

void describe(FieldVisitor& v, RandomWorldConfig& c) {
  v.choice("family", c.family, "where the world comes from");
  v.choice("with_ball", c.with_ball, "whether there is a ball");
}

std::array<double, 2> radius_range_px(ImageSize size) { return {4.0, std::floor(0.3 * size.height)}; }

DrawnWorld draw_world(const RandomWorldConfig& config, std::uint64_t seed,
                      const std::optional<Camera>& camera) {
  // Parts with generators of their own: a change of one leaves the others as they are.
  RandomGenerator of_camera(seed, "random world camera");
  RandomGenerator of_room(seed, "random world room");
  RandomGenerator of_motion(seed, "random world motion");
  RandomGenerator of_objects(seed, "random world objects");
  RandomGenerator of_ball(seed, "random world ball");

  DrawnWorld world;
  const bool drawn = of_motion.chance(ball_share);
  const bool with_ball = config.with_ball == WithBall::drawn ? drawn : config.with_ball == WithBall::always;
  world.duration_s = 0.1 * (40 + of_motion.index(21));
  const Camera any_camera = draw_camera(of_camera);
  world.sim.camera = camera.value_or(any_camera);
  world.sim.emulator = draw_sensor(of_camera);
  world.sim.lab = draw_lab(of_room);
  world.motion = draw_motion(of_motion);
  world.script = draw_script(of_motion, world.motion, true);

  Stage stage{world.sim.camera, mean_root_from_eye(world.script),
              std::min(1.5, world.sim.lab.wall_distance_m - furniture_depth_m)};
  const int distractors = with_ball ? of_objects.index(3) : 1 + of_objects.index(3);
  world.sim.world.objects = draw_distractors(of_objects, stage, distractors);
  if (with_ball) {
    draw_ball(of_ball, seed, stage, world);
  } else {
    world.sim.world.ball.present = false;
  }
  return world;
}

}  // namespace saccade
