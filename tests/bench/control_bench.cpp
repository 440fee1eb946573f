#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <vector>

#include "control/controller_registry.h"
#include "control/delay_compensation.h"
#include "control/gaze_controller.h"
#include "control/hunting_detector.h"
#include "control/qp_controller.h"
#include "control/stabilisation.h"
#include "head/icub_cameras.h"
#include "tests/control/genova02.h"

namespace saccade {
namespace {

constexpr double dt = 1e-3;

Eigen::Vector3d random_target(const RandomStream& random, std::uint64_t i) {
  return {random.uniform(-0.65, -0.35, 0, i), random.uniform(-0.3, 0.3, 1, i),
          random.uniform(0.1, 0.6, 2, i)};
}

/// Closed loop with joints that lag by 20 ms, a new target every 100 ms. Counters: time per step, us.
void gaze_step(benchmark::State& bench, const char* controller) {
  GazeControllerConfig config = built_in_controllers().config();
  config.controller = controller;
  const auto gaze = make_gaze_controller(config, genova02_limits());
  const RandomStream random(1, "bench");
  HeadState state;
  std::vector<double> step_us;
  step_us.reserve(1 << 24);
  std::uint64_t tick = 0;
  for (auto _ : bench) {
    std::optional<Eigen::Vector3d> target;
    if (tick % 100 == 0) target = random_target(random, tick);
    ++tick;
    const auto start = std::chrono::steady_clock::now();
    const HeadJointVector reference = gaze->step(state, target, dt);
    const auto end = std::chrono::steady_clock::now();
    const double seconds = std::chrono::duration<double>(end - start).count();
    bench.SetIterationTime(seconds);
    if (step_us.size() < step_us.capacity()) step_us.push_back(seconds * 1e6);
    state.position_rad.tail<gaze_slots>() += 0.05 * (reference - state.head_position_rad());
  }
  const auto percentile = [&](double share) {
    const auto at =
        step_us.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(step_us.size() - 1));
    std::nth_element(step_us.begin(), at, step_us.end());
    return *at;
  };
  bench.counters["p50_us"] = percentile(0.50);
  bench.counters["p99_us"] = percentile(0.99);
}
BENCHMARK_CAPTURE(gaze_step, qp, "qp")->UseManualTime();
BENCHMARK_CAPTURE(gaze_step, ikingaze, "ikingaze")->UseManualTime();

/// Pursuit of a circle of 1 Hz, a target every millisecond, with prediction, stabilisation and estimates of delays.
void pursuit_step(benchmark::State& bench) {
  GazeControllerConfig config = built_in_controllers().config();
  config.get<QpConfig>().catch_up_deg = 2.0;
  const auto gaze = make_gaze_controller(config, genova02_limits());
  Stabiliser stabiliser({true, true}, default_head());
  MotionDelayEstimator delay;
  HuntingDetector hunting;
  const ImuReading imu;
  HeadState state;
  std::vector<double> step_us;
  step_us.reserve(1 << 24);
  std::uint64_t tick = 0;
  for (auto _ : bench) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(++tick) * dt;
    const Eigen::Vector3d target(-0.5, 0.07 * std::cos(angle), 0.35 + 0.07 * std::sin(angle));
    const auto start = std::chrono::steady_clock::now();
    gaze->set_delays({0.02, delay.neck_s(), delay.eyes_s()});
    gaze->set_body_rates(stabiliser.update(state, &imu, delay.eyes_s(), dt));
    const HeadJointVector reference = gaze->step(state, target, dt);
    delay.update(state.head_position_rad(), reference, dt);
    benchmark::DoNotOptimize(hunting.update(reference, dt));
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    bench.SetIterationTime(seconds);
    if (step_us.size() < step_us.capacity()) step_us.push_back(seconds * 1e6);
    state.position_rad.tail<gaze_slots>() += 0.05 * (reference - state.head_position_rad());
  }
  std::ranges::sort(step_us);
  const auto percentile = [&](double share) {
    return step_us[static_cast<std::size_t>(share * static_cast<double>(step_us.size() - 1))];
  };
  bench.counters["p50_us"] = percentile(0.50);
  bench.counters["p99_us"] = percentile(0.99);
}
BENCHMARK(pursuit_step)->UseManualTime();

void head_kinematics_with_fixation(benchmark::State& bench) {
  const RandomStream random(2, "bench");
  std::uint64_t i = 0;
  for (auto _ : bench) {
    const HeadKinematics head(default_head()->chain, random_configuration(random, i++));
    benchmark::DoNotOptimize(head.fixation_jacobian());
  }
}
BENCHMARK(head_kinematics_with_fixation);

void sphere_from_circle_over_the_image(benchmark::State& bench) {
  const RandomStream random(3, "bench");
  const Camera camera = icub_left_2016;
  std::uint64_t i = 0;
  for (auto _ : bench) {
    const Circle circle{random.uniform(0, 127, 0, i), random.uniform(0, 127, 1, i),
                        random.uniform(5, 30, 2, i)};
    benchmark::DoNotOptimize(sphere_from_circle(circle, camera, 0.0475));
    ++i;
  }
}
BENCHMARK(sphere_from_circle_over_the_image);

}  // namespace
}  // namespace saccade
