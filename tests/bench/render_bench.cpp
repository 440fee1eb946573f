// One image of the left eye, 2x2 samples per pixel, in both labs; one whole tick of the simulator, with the images
// that it takes; and what it costs to ask whether one is due.
#include <benchmark/benchmark.h>

#include <cmath>
#include <memory>
#include <vector>

#include "sim/sim_robot.h"
#include "threads/worker_threads.h"

namespace saccade {
namespace {

SimConfig lab_of(Clutter clutter) {
  SimConfig config;
  config.lab.clutter = clutter;
  config.world.ball.trajectory.kind = TrajectoryKind::circle;
  return config;
}

/// The head sweeps, so that every image differs.
HeadJointVector sweep(std::int64_t i) {
  HeadJointVector reference_rad = HeadJointVector::Zero();
  reference_rad[neck_yaw - torso_joint_count] = 0.3 * std::sin(static_cast<double>(i) * 0.01);
  return reference_rad;
}

void eye_image(benchmark::State& state, Clutter clutter) {
  const SimConfig config = lab_of(clutter);
  const Lab lab(config.lab, 1);
  World world(config.world, lab.mjcf(), 1);
  const auto gl = GlContext::create("auto");
  lab.paint(world.model());
  EyeRenderer eye(world.model(), *gl, config.camera, config.render);
  std::vector<float> luminance(static_cast<std::size_t>(config.camera.size.pixels()));
  std::int64_t i = 0;
  for (auto _ : state) {
    state.PauseTiming();
    world.set_reference(sweep(i++));
    world.step();
    state.ResumeTiming();
    eye.render(world.data(), world.left_eye_camera(), luminance);
    benchmark::DoNotOptimize(luminance.data());
  }
}
BENCHMARK_CAPTURE(eye_image, textured, Clutter::textured)->Unit(benchmark::kMicrosecond)->UseRealTime();
BENCHMARK_CAPTURE(eye_image, rectilinear, Clutter::rectilinear)->Unit(benchmark::kMicrosecond)->UseRealTime();

/// The same reprojected, with the keyframes that it needs.
void reprojected_image(benchmark::State& state, Clutter clutter) {
  const SimConfig config = lab_of(clutter);
  const Lab lab(config.lab, 1);
  World world(config.world, lab.mjcf(), 1);
  const auto gl = GlContext::create("auto");
  lab.paint(world.model());
  KeyframeRenderer eye(world.model(), *gl, config.camera, config.render, std::make_shared<WorkerThreads>(1));
  std::vector<float> luminance(static_cast<std::size_t>(config.camera.size.pixels()));
  std::int64_t i = 0;
  for (auto _ : state) {
    state.PauseTiming();
    world.set_reference(sweep(i++));
    world.step();
    state.ResumeTiming();
    eye.render(world.data(), world.left_eye_camera(), luminance);
    benchmark::DoNotOptimize(luminance.data());
  }
  state.counters["keyframes per image"] = benchmark::Counter(
      static_cast<double>(eye.counts().room + eye.counts().bodies), benchmark::Counter::kAvgIterations);
}
BENCHMARK_CAPTURE(reprojected_image, textured, Clutter::textured)
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(reprojected_image, rectilinear, Clutter::rectilinear)
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

void simulated_tick(benchmark::State& state, Clutter clutter) {
  SimRobot robot(lab_of(clutter), 1);
  std::vector<Event> events;
  std::int64_t i = 0;
  for (auto _ : state) {
    robot.command(sweep(i++));
    robot.wait_until(robot.now_us() + World::tick_us);
    events.clear();
    robot.read_until(robot.now_us(), events);
    benchmark::DoNotOptimize(events.data());
  }
  state.counters["images per tick"] =
      benchmark::Counter(static_cast<double>(robot.images()), benchmark::Counter::kAvgIterations);
}
BENCHMARK_CAPTURE(simulated_tick, textured, Clutter::textured)->Unit(benchmark::kMicrosecond)->UseRealTime();
BENCHMARK_CAPTURE(simulated_tick, rectilinear, Clutter::rectilinear)
    ->Unit(benchmark::kMicrosecond)
    ->UseRealTime();

void image_motion(benchmark::State& state) {
  const SimConfig config = lab_of(Clutter::textured);
  World world(config.world, "", 1);
  ImageMotion motion(world.model(), world.left_eye_camera(), config.camera);
  motion.start_from(world.data());
  world.set_reference(sweep(1));
  world.step();
  for (auto _ : state) {
    double moved_px = motion.displacement_px(world.data());
    benchmark::DoNotOptimize(moved_px);
  }
}
BENCHMARK(image_motion)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace saccade
