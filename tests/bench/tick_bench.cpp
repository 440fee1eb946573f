// A whole tick of a deployed loop: the watchdog, 100 events, a detector, the gate, the controller and its limits.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "apps/deploy/deploy_session.h"
#include "control/controller_registry.h"
#include "control/gate_registry.h"
#include "control/head_kinematics.h"
#include "core/detectors/built_in_detectors.h"
#include "head/icub_cameras.h"
#include "robot/fake/fake_robot.h"
#include "tests/bench/ball_in_clutter.h"
#include "tests/control/genova02.h"

namespace saccade {
namespace {

constexpr std::int64_t events_per_tick = 100;
constexpr std::int64_t duration_ms = 30'000;

class FakeActive final : public Robot {
 public:
  explicit FakeActive(FakeRobotScript script) : world_(std::move(script)) {}
  Clock& clock() override { return world_; }
  EventSource& events() override { return world_; }
  HeadPort* head() override { return &world_; }
  GazePort* gaze() override { return nullptr; }
  std::vector<StartUpCheck> check() override { return {}; }
  void activate() override {}
  void release() override {}

 private:
  FakeRobot world_;
};

class Nobody final : public DeployObserver {
 public:
  void on_tick(const Tick& tick, const TickTiming&) override { targets += tick.new_target_m ? 1 : 0; }
  void on_change(const DeployChange&) override {}
  void on_news(std::int64_t, const std::string&) override {}
  std::int64_t targets = 0;
};

void tick(benchmark::State& bench, const char* preset, const char* controller) {
  FakeRobotScript script;
  script.limits = genova02_limits();
  script.events = ball_in_clutter(events_per_tick, duration_ms);
  FakeActive robot(std::move(script));
  std::vector<LoopDetector> detectors;
  detectors.push_back({preset, make_detector(built_in_detectors().config(preset), icub_left_2016)});
  Loop loop(robot, MountedCamera{icub_left_2016, {}}, std::move(detectors),
            LoopGaze{0, make_gate(built_in_gates().config()), std::nullopt, FollowConfig{.start_s = 0.0}},
            Eye::left, LoopBudget{2'000, 500});
  GazeControllerConfig config = built_in_controllers().config();
  config.controller = controller;
  const auto motion = [&] {
    const JointLimits limits = genova02_limits();
    return LoopMotion{make_gaze_controller(config, limits), JointLimiter(motion_limits(limits, {}))};
  };
  OperatorRequests requests;
  Nobody nobody;
  DeploySession session(robot, loop, motion, requests, nobody, {});
  session.set_ready();
  requests.activate();
  for (int i = 0; i < 1000; ++i) session.tick();
  std::vector<double> tick_us;
  tick_us.reserve(1 << 16);
  for (auto _ : bench) {
    const auto begin = std::chrono::steady_clock::now();
    session.tick();
    const auto end = std::chrono::steady_clock::now();
    const double took_s = std::chrono::duration<double>(end - begin).count();
    bench.SetIterationTime(took_s);
    tick_us.push_back(took_s * 1e6);
  }
  const auto percentile = [&](double share) {
    const auto at =
        tick_us.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(tick_us.size() - 1));
    std::nth_element(tick_us.begin(), at, tick_us.end());
    return *at;
  };
  bench.counters["p50_us"] = percentile(0.50);
  bench.counters["p99_us"] = percentile(0.99);
  bench.counters["max_us"] = percentile(1.0);
  bench.counters["targets"] = static_cast<double>(nobody.targets);
}
constexpr int ticks = 20'000;
BENCHMARK_CAPTURE(tick, best_qp, "best", "qp")->UseManualTime()->Iterations(ticks);
BENCHMARK_CAPTURE(tick, best_ikingaze, "best", "ikingaze")->UseManualTime()->Iterations(ticks);
BENCHMARK_CAPTURE(tick, paper_directed_qp, "paper_directed", "qp")->UseManualTime()->Iterations(ticks);
BENCHMARK_CAPTURE(tick, paper_full_qp, "paper_full", "qp")->UseManualTime()->Iterations(ticks);

}  // namespace
}  // namespace saccade
