#include "worlds/random_world.h"

#include <algorithm>
#include <cmath>

#include "control/head_kinematics.h"
#include "core/units.h"
#include "worlds/camera_path.h"
#include "worlds/outline_contrast.h"
#include "worlds/random_world_parts.h"

namespace saccade {
namespace {

using namespace random_world;

constexpr double ball_share = 0.8;
/// From the middle of the furniture before the wall to the wall, and some room for the ball.
constexpr double furniture_depth_m = 1.3;

/// The left eye where all joints are at the mean of a script's points.
Eigen::Isometry3d mean_root_from_eye(const ScriptConfig& script, const HeadModel& head) {
  if (!head.has_icub_gaze()) return HeadKinematics(head.chain, JointVector::Zero()).root_from_eye(Eye::left);
  JointVector pose_rad = JointVector::Zero();
  for (const auto& eyes_deg : script.eyes_deg) {
    pose_rad[eyes_tilt] += eyes_deg[0];
    pose_rad[eyes_version] += eyes_deg[1];
  }
  for (const auto& neck_deg : script.neck_deg) {
    for (int j = 0; j < 3; ++j) pose_rad[neck_pitch + j] += neck_deg[static_cast<std::size_t>(j)];
  }
  pose_rad *= rad_per_deg / static_cast<double>(script.eyes_deg.size());
  return HeadKinematics(head.chain, pose_rad).root_from_eye(Eye::left);
}

/// Where the ball is in the middle of its motion, for a board to pass there.
Eigen::Vector3d middle_of(const TrajectoryConfig& t) {
  if (t.kind == TrajectoryKind::circle) return t.centre_m;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& point : t.points_m) sum += point;
  return sum / static_cast<double>(t.points_m.size());
}

/// Draws the ball's size and motion and a board that passes before it, until the ball is seen as it must be.
void draw_ball(RandomGenerator& random, std::uint64_t seed, const Stage& stage, const CameraPath& path,
               bool rests, DrawnWorld& world) {
  constexpr int all_attempts = 2000;
  constexpr int exact_attempts = 400;  // from then on without a board and without leaving the image
  const bool leaves = !rests && random.chance(0.25);
  const bool hidden = random.chance(0.2);
  const Camera& camera = world.sim.camera;
  const auto [low_px, high_px] = radius_range_px(camera.size);
  const double fastest_px_s = 14.0 * camera.size.width;
  const NamedObjects others = world.sim.world.objects;
  BallConfig& ball = world.sim.world.ball;
  ball = draw_ball_kind(random);
  // A hand of natural size hides a ball that is much smaller.
  const double smallest_m = ball.hand == Hand::fingers ? 0.03 : 0.015;
  for (int attempt = 0; attempt < all_attempts; ++attempt) {
    const bool exact = attempt < exact_attempts;
    const BallSize size = draw_ball_size(random, stage, smallest_m);
    ball.diameter_m = 2.0 * size.radius_m;
    ball.trajectory = draw_ball_motion(random, stage, ball, size, rests, leaves && exact);
    world.sim.world.objects = others;
    if (hidden && exact) {
      world.sim.world.objects.emplace_back(
          "board", draw_board(random, stage, middle_of(ball.trajectory), size.radius_m));
    }
    const BallView view = view_of(path, camera, Trajectory(ball.trajectory, seed), size.radius_m,
                                  world.sim.world.objects, seed);
    world.in_view_share = view.in_view_share;
    world.hidden_share = view.hidden_share;
    world.smallest_px = view.smallest_px;
    world.largest_px = view.largest_px;
    if (view.in_view_share < 0.6 || view.smallest_px < 1.01 * low_px || view.largest_px > 0.99 * high_px ||
        view.fastest_px_s > fastest_px_s) {
      continue;
    }
    const bool goes_out = view.in_view_share + view.hidden_share < 0.97;
    if (!exact || ((!leaves || goes_out) && (!hidden || view.hidden_share > 0.03))) return;
  }
}

/// Draws the ball's colours until most of its outline has contrast.
void colour_ball(RandomGenerator& random, std::uint64_t seed, const CameraPath& path, DrawnWorld& world) {
  constexpr double enough = 0.6;
  constexpr int attempts_with_tone = 40;
  constexpr int all_attempts = 80;
  constexpr BallTone tones[] = {BallTone::darker, BallTone::brighter, BallTone::middle};
  BallConfig& ball = world.sim.world.ball;
  const OutlineContrast contrast(world.sim.lab, seed, path, world.sim.camera,
                                 Trajectory(ball.trajectory, seed), 0.5 * ball.diameter_m);
  BallConfig candidate = ball;
  BallTone tone = one_of(random, tones);
  world.contrast_share = -1.0;
  for (int attempt = 0; attempt < all_attempts && world.contrast_share < enough; ++attempt) {
    if (attempt >= attempts_with_tone) tone = one_of(random, tones);
    draw_colours(random, tone, candidate);
    const double share = contrast.share(candidate, world.sim.emulator);
    if (share <= world.contrast_share) continue;
    ball = candidate;
    world.tone = tone;
    world.contrast_share = share;
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
  return random_world::draw_world(config, seed, camera, {});
}

DrawnWorld random_world::draw_world(const RandomWorldConfig& config, std::uint64_t seed,
                                    const std::optional<Camera>& camera, const HeadConfig& head) {
  // Parts with generators of their own: a change of one leaves the others as they are.
  RandomGenerator of_camera(seed, "random world camera");
  RandomGenerator of_room(seed, "random world room");
  RandomGenerator of_motion(seed, "random world motion");
  RandomGenerator of_objects(seed, "random world objects");
  RandomGenerator of_ball(seed, "random world ball");

  DrawnWorld world;
  world.sim.world.head = head;
  const auto model = valid_head(head);
  const bool drawn = of_motion.chance(ball_share);
  const bool with_ball = config.with_ball == WithBall::drawn ? drawn : config.with_ball == WithBall::always;
  world.duration_s = 0.1 * (40 + of_motion.index(21));
  const Camera any_camera = draw_camera(of_camera);
  world.sim.camera = camera.value_or(any_camera);
  world.sim.emulator = draw_sensor(of_camera);
  world.sim.emulator.readout_rate_hz = bus_rate_hz(world.sim.emulator, world.sim.camera.size);
  world.sim.lab = draw_lab(of_room);
  world.motion = draw_motion(of_motion);
  if (!model->has_icub_gaze()) world.motion = HeadMotion::still;
  const bool rests = with_ball && world.motion != HeadMotion::still && of_motion.chance(0.3);
  world.script = draw_script(of_motion, world.motion, rests);

  const Stage stage{world.sim.camera.without_lens(), mean_root_from_eye(world.script, *model),
                    std::min(1.5, world.sim.lab.wall_distance_m - furniture_depth_m)};
  const int distractors = with_ball ? of_objects.index(3) : 1 + of_objects.index(3);
  world.sim.world.objects = draw_distractors(of_objects, stage, distractors);
  world.sim.world.ball.present = with_ball;
  if (!with_ball) return world;
  const CameraPath path(world.motion != HeadMotion::still ? &world.script : nullptr, world.sim.world,
                        world.duration_s);
  draw_ball(of_ball, seed, stage, path, rests, world);
  colour_ball(of_ball, seed, path, world);
  return world;
}

}  // namespace saccade
