// A whole tick of a deployed loop: the watchdog, 100 events, a detector, the gate, the controller and its limits.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <vector>

#include "apps/deploy/deploy_session.h"
#include "control/controller_registry.h"
#include "control/gate_registry.h"
#include "control/head_kinematics.h"
#include "core/detector_registry.h"
#include "head/icub_cameras.h"
#include "robot/fake/fake_robot.h"
#include "tests/control/genova02.h"

namespace saccade {
namespace {

constexpr std::int64_t events_per_tick = 100;
constexpr std::int64_t seconds = 30;

/// In each millisecond 60 events on the outline of a ball that goes round in the image and 40 anywhere.
std::vector<Event> ball_in_clutter() {
  const RandomStream random(1, "tick_bench");
  std::vector<Event> events;
  events.reserve(static_cast<std::size_t>(seconds * 1000 * events_per_tick));
  std::uint64_t i = 0;
  for (std::int64_t t_us = 0; t_us < seconds * 1'000'000; t_us += 1'000'000 / (1000 * events_per_tick)) {
    const double turn = 2.0 * std::numbers::pi * 0.2e-6 * static_cast<double>(t_us);
    double x = random.uniform(0.0, 127.0, 0, i);
    double y = random.uniform(0.0, 127.0, 1, i);
    if (i % 5 < 3) {
      const double around = random.uniform(0.0, 2.0 * std::numbers::pi, 2, i);
      x = 64.0 + 20.0 * std::cos(turn) + 11.0 * std::cos(around);
      y = 64.0 + 20.0 * std::sin(turn) + 11.0 * std::sin(around);
    }
    events.push_back({t_us + 1, static_cast<std::uint16_t>(std::lround(x)),
                      static_cast<std::uint16_t>(std::lround(y)), i % 2 == 0, 0});
    ++i;
  }
  return events;
}

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
  script.events = ball_in_clutter();
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
