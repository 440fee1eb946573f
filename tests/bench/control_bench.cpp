#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "control/controller_registry.h"
#include "control/delay_compensation.h"
#include "control/gaze_controller.h"
#include "control/hunting_detector.h"
#include "control/qp_controller.h"
#include "control/stabilisation.h"
#include "head/icub_cameras.h"
#include "tests/control/described_head.h"
#include "tests/control/genova02.h"
#include "tests/control/malloc_count.h"

namespace saccade {
namespace {

constexpr double dt = 1e-3;

Eigen::Vector3d random_target(const RandomStream& random, std::uint64_t i) {
  return {random.uniform(-0.65, -0.35, 0, i), random.uniform(-0.3, 0.3, 1, i),
          random.uniform(0.1, 0.6, 2, i)};
}

const std::shared_ptr<const HeadModel>& bench_head(const std::string& name) {
  static std::map<std::string, std::shared_ptr<const HeadModel>> heads;
  auto& head = heads[name];
  if (!head) head = name == "pan_tilt" ? described_head(pan_tilt()) : icub_head(name);
  return head;
}

/// Counters of a benchmark: percentiles of the time per step, us, and memory allocations per step.
class StepTimes {
 public:
  StepTimes() { step_us_.reserve(1 << 22); }

  void begin() {
    mallocs_before_ = malloc_count();
    start_ = std::chrono::steady_clock::now();
  }
  void end(benchmark::State& bench) {
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    mallocs_ += malloc_count() - mallocs_before_;
    bench.SetIterationTime(seconds);
    if (step_us_.size() < step_us_.capacity()) step_us_.push_back(seconds * 1e6);
  }
  void report(benchmark::State& bench) {
    std::ranges::sort(step_us_);
    const auto percentile = [&](double share) {
      return step_us_[static_cast<std::size_t>(share * static_cast<double>(step_us_.size() - 1))];
    };
    bench.counters["p50_us"] = percentile(0.50);
    bench.counters["p99_us"] = percentile(0.99);
    bench.counters["p99.9_us"] = percentile(0.999);
    bench.counters["mallocs"] = static_cast<double>(mallocs_);
  }

 private:
  std::vector<double> step_us_;
  std::chrono::steady_clock::time_point start_;
  long mallocs_before_ = 0;
  long mallocs_ = 0;
};

/// Closed loop with joints that lag by 20 ms, a new target every 100 ms.
void gaze_step(benchmark::State& bench, const std::string& controller, const std::string& head) {
  GazeControllerConfig config = built_in_controllers().config();
  config.controller = controller;
  const auto gaze = make_gaze_controller(config, limits_of(bench_head(head)));
  const RandomStream random(1, "bench");
  HeadState state;
  StepTimes times;
  std::uint64_t tick = 0;
  for (auto _ : bench) {
    std::optional<Eigen::Vector3d> target;
    if (tick % 100 == 0) target = random_target(random, tick);
    ++tick;
    times.begin();
    const HeadJointVector reference = gaze->step(state, target, dt);
    times.end(bench);
    state.position_rad.tail<gaze_slots>() += 0.05 * (reference - state.head_position_rad());
  }
  times.report(bench);
}

/// Pursuit of a circle of 1 Hz, a target every millisecond; `all`: with catch-up saccades, stabilisation, estimates of
/// delays and the detection of hunting.
void pursuit_step(benchmark::State& bench, const std::string& controller, const std::string& head, bool all) {
  GazeControllerConfig config = built_in_controllers().config();
  config.controller = controller;
  if (all) config.get<QpConfig>().catch_up_deg = 2.0;
  const auto gaze = make_gaze_controller(config, limits_of(bench_head(head)));
  const Eigen::Vector3d centre =
      HeadKinematics(bench_head(head)->chain, JointVector::Zero()).root_from_eye(Eye::left) *
      Eigen::Vector3d(0.0, 0.0, 0.45);
  Stabiliser stabiliser({true, true}, bench_head(head));
  MotionDelayEstimator delay;
  HuntingDetector hunting;
  const ImuReading imu;
  HeadState state;
  StepTimes times;
  std::uint64_t tick = 0;
  for (auto _ : bench) {
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(++tick) * dt;
    const Eigen::Vector3d target =
        centre + Eigen::Vector3d(0.0, 0.07 * std::cos(angle), 0.07 * std::sin(angle));
    times.begin();
    if (all) {
      gaze->set_delays({0.02, delay.neck_s(), delay.eyes_s()});
      gaze->set_body_rates(stabiliser.update(state, &imu, delay.eyes_s(), dt));
    }
    const HeadJointVector reference = gaze->step(state, target, dt);
    if (all) {
      delay.update(state.head_position_rad(), reference, dt);
      benchmark::DoNotOptimize(hunting.update(reference, dt));
    }
    times.end(bench);
    state.position_rad.tail<gaze_slots>() += 0.05 * (reference - state.head_position_rad());
  }
  times.report(bench);
}

/// Every shipped head with the controllers that work with it.
[[maybe_unused]] const bool registered = [] {
  for (const std::string head : {"1", "2", "2.8", "2.10", "3", "pan_tilt"}) {
    for (const std::string controller : {"qp", "ikingaze"}) {
      if (head == "pan_tilt" && controller == "ikingaze") continue;
      const std::string name = controller + "/" + head;
      benchmark::RegisterBenchmark(("gaze_step/" + name).c_str(), gaze_step, controller, head)
          ->UseManualTime();
      benchmark::RegisterBenchmark(("pursuit_step/" + name).c_str(), pursuit_step, controller, head, false)
          ->UseManualTime();
      benchmark::RegisterBenchmark(("pursuit_step_with_all/" + name).c_str(), pursuit_step, controller, head,
                                   true)
          ->UseManualTime();
    }
  }
  return true;
}();

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
