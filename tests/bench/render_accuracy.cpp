// Events from reprojected images and from images drawn as motion needs them, against those from images drawn with 8x8
// samples at 10 kHz, without noise; and the processor time of each. usage: render_accuracy [SECONDS [SCENE...]]
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "core/error.h"
#include "core/units.h"
#include "sim/sim_robot.h"

namespace saccade {
namespace {

using Events = std::vector<Event>;

/// A way to make images.
struct Method {
  const char* name;
  RenderMethod method;
  std::int64_t supersampling;
  std::int64_t keyframe_samples;
  double keyframe_error_px;
  SamplingConfig sampling;
};

constexpr Method reference{"direct 8x8 at 10 kHz", RenderMethod::direct, 8, 2, 1.0, {0.5, 0.1, 0.1}};
const EyeRenderConfig shipped;
const std::vector<Method> methods = {
    {"direct 2x2, 0.5 px", RenderMethod::direct, 2, 2, 1.0, {}},
    {"direct 8x8, 0.25 px", RenderMethod::direct, 8, 2, 1.0, {0.25, 5.0, 0.02}},
    {"keyframes 4, 0.25 px", RenderMethod::keyframes, 2, 4, shipped.keyframe_error_px, {0.25, 5.0, 0.02}},
    {"keyframes 5, 0.25 px", RenderMethod::keyframes, 2, 5, shipped.keyframe_error_px, {0.25, 5.0, 0.02}},
    {"keyframes 8, 0.25 px", RenderMethod::keyframes, 2, 8, 0.1, {0.25, 5.0, 0.02}},
};

const std::vector<std::string> scene_names = {"hand", "rolling", "objects", "rectilinear", "resting"};

SimConfig scene(const std::string& name) {
  SimConfig config;
  config.emulator.shot_noise_rate_hz = config.emulator.leak_rate_hz = 0.0;
  BallConfig& ball = config.world.ball;
  TrajectoryConfig& path = ball.trajectory;
  path.kind = TrajectoryKind::circle;
  path.centre_m = {-0.506, 0.0, 0.347};
  path.radius_a_m = {0.0, -0.07, 0.0};
  path.radius_b_m = {0.0, 0.0, 0.07};
  path.frequency_hz = 0.5;
  if (name == "rectilinear") config.lab.clutter = Clutter::rectilinear;
  if (name == "rolling") {
    ball.hand = Hand::none;
    ball.gloss = 0.6;
    ball.rolls = true;
    ball.pattern = BallPattern::patches;
    path.radius_a_m = {0.0, -0.12, 0.0};
    path.radius_b_m = {0.1, 0.0, 0.0};
  }
  if (name == "objects") {
    ObjectConfig tin;
    tin.shape = ObjectShape::cylinder;
    tin.size_m = {0.07, 0.07, 0.12};
    tin.trajectory = path;
    tin.trajectory.centre_m = {-0.6, 0.0, 0.35};
    tin.trajectory.radius_a_m = {0.0, 0.2, 0.0};
    tin.trajectory.radius_b_m = {0.0, 0.0, 0.15};
    tin.trajectory.frequency_hz = 0.3;
    ObjectConfig walker;
    walker.shape = ObjectShape::person;
    walker.trajectory.kind = TrajectoryKind::waypoints;
    walker.trajectory.points_m = {{-1.35, -0.5, -0.62}, {-1.35, 1.1, -0.62}};
    walker.trajectory.speed_m_s = 0.8;
    config.lab.wall_distance_m = 2.8;
    config.world.objects = {{"tin", tin}, {"walker", walker}};
  }
  return config;
}

/// Saccades of 12 degrees every 0.3 s while the neck turns; at rest in the scene `resting`.
HeadJointVector reference_at(const std::string& name, std::int64_t t_us) {
  HeadJointVector joints_rad = HeadJointVector::Zero();
  if (name == "resting") return joints_rad;
  const double turn = 2.0 * std::numbers::pi * static_cast<double>(t_us) * 1e-6;
  const std::int64_t corner = t_us / 300'000 % 4;
  joints_rad[neck_yaw - torso_joint_count] = 6.0 * rad_per_deg * std::sin(0.6 * turn);
  joints_rad[neck_pitch - torso_joint_count] = 3.0 * rad_per_deg * std::sin(0.4 * turn + 1.0);
  joints_rad[eyes_version - torso_joint_count] = (corner == 1 || corner == 2 ? 6.0 : -6.0) * rad_per_deg;
  joints_rad[eyes_tilt - torso_joint_count] = (corner >= 2 ? 5.0 : -5.0) * rad_per_deg;
  return joints_rad;
}

double processor_s() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Run {
  Events events;
  std::vector<EyeTruth> truth;  ///< every millisecond
  Camera camera;
  std::int64_t images = 0;
  double processor_s = 0.0;
};

Run run(const std::string& name, const Method& method, std::int64_t duration_us) {
  SimConfig config = scene(name);
  config.render.method = method.method;
  config.render.supersampling = method.supersampling;
  config.render.keyframe_samples = method.keyframe_samples;
  config.render.keyframe_error_px = method.keyframe_error_px;
  config.sampling = method.sampling;
  SimRobot robot(config, 1);
  Run done;
  done.camera = config.camera;
  const double begin_s = processor_s();
  for (std::int64_t t_us = World::tick_us; t_us <= duration_us; t_us += World::tick_us) {
    robot.command(reference_at(name, t_us));
    robot.wait_until(t_us);
    robot.read_until(t_us, done.events);
    done.truth.push_back(robot.truth().left);
  }
  done.processor_s = processor_s() - begin_s;
  done.images = robot.images();
  return done;
}

/// Speed of what a pixel shows, px/s: of the ball around its outline, of the room elsewhere.
double speed_px_s(const Run& run, const Event& event) {
  const auto now =
      std::clamp<std::size_t>(static_cast<std::size_t>(event.t_us / 1000), 1, run.truth.size() - 1);
  const EyeTruth& before = run.truth[now - 1];
  const EyeTruth& after = run.truth[now];
  if (before.circle && after.circle &&
      std::hypot(event.x - after.circle->x_px, event.y - after.circle->y_px) < 1.5 * after.circle->r_px) {
    return 1e3 *
           std::hypot(after.circle->x_px - before.circle->x_px, after.circle->y_px - before.circle->y_px);
  }
  const Eigen::Vector3d ray = before.root_from_cam.linear() * run.camera.ray(event.x, event.y);
  const auto moved_px = run.camera.project(after.root_from_cam.linear().transpose() * ray);
  return moved_px ? 1e3 * (*moved_px - Eigen::Vector2d(event.x, event.y)).norm() : 0.0;
}

/// The times of each pixel's events, those of one polarity one after the other.
std::vector<std::vector<std::int64_t>> times_of(const Run& run) {
  std::vector<std::vector<std::int64_t>> times(2 * static_cast<std::size_t>(run.camera.size.pixels()));
  for (const Event& e : run.events)
    times[2 * static_cast<std::size_t>(e.y * run.camera.size.width + e.x) + (e.on ? 1 : 0)].push_back(e.t_us);
  return times;
}

void print_comparison(const char* name, const Run& with, const Run& truth) {
  const auto expected = times_of(truth);
  const auto found = times_of(with);
  int pixels = 0;
  int alike = 0;
  for (std::size_t i = 0; i < expected.size(); i += 2) {
    const auto count = static_cast<double>(expected[i].size() + expected[i + 1].size());
    if (count < 10.0) continue;
    ++pixels;
    if (std::abs(static_cast<double>(found[i].size() + found[i + 1].size()) - count) <= 0.1 * count) ++alike;
  }
  std::vector<double> errors_px;
  for (const Event& e : with.events) {
    const auto& times =
        expected[2 * static_cast<std::size_t>(e.y * with.camera.size.width + e.x) + (e.on ? 1 : 0)];
    const auto after = std::lower_bound(times.begin(), times.end(), e.t_us);
    std::int64_t nearest_us = std::numeric_limits<std::int64_t>::max();
    if (after != times.end()) nearest_us = *after - e.t_us;
    if (after != times.begin()) nearest_us = std::min(nearest_us, e.t_us - *std::prev(after));
    constexpr std::int64_t longest_us = 20'000;
    if (nearest_us < longest_us)
      errors_px.push_back(static_cast<double>(nearest_us) * 1e-6 * speed_px_s(truth, e));
  }
  std::sort(errors_px.begin(), errors_px.end());
  const double median_px = errors_px.empty() ? 0.0 : errors_px[errors_px.size() / 2];
  std::printf(
      "  %-22s %7lld %9zu %+7.2f %% %8.1f %% %10.4f px %8.2f s\n", name, static_cast<long long>(with.images),
      with.events.size(),
      100.0 * (static_cast<double>(with.events.size()) / static_cast<double>(truth.events.size()) - 1.0),
      100.0 * alike / std::max(pixels, 1), median_px, with.processor_s);
  std::fflush(stdout);
}

}  // namespace
}  // namespace saccade

int main(int argc, char** argv) {
  using namespace saccade;
  setenv("LP_NUM_THREADS", "0", 1);  // the calling thread alone draws
  try {
    const double duration_s = argc > 1 ? std::atof(argv[1]) : 0.36;
    std::vector<std::string> scenes(argv + std::min(argc, 2), argv + argc);
    if (scenes.empty()) scenes = scene_names;
    std::printf(
        "                            images    events      more  alike px    timing median  processor\n");
    for (const std::string& name : scenes) {
      std::printf("%s\n", name.c_str());
      const Run truth = run(name, reference, std::llround(duration_s * 1e6));
      print_comparison(reference.name, truth, truth);
      for (const Method& method : methods)
        print_comparison(method.name, run(name, method, std::llround(duration_s * 1e6)), truth);
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "render_accuracy: %s\n", error.what());
    return 1;
  }
  return 0;
}
