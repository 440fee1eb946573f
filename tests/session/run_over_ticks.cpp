#include "tests/session/run_over_ticks.h"

#include <cmath>
#include <fstream>
#include <optional>
#include <string>

#include "control/controller_registry.h"
#include "control/gate_registry.h"
#include "core/error.h"
#include "core/random.h"
#include "head/icub_cameras.h"
#include "loop/run_log.h"
#include "robot/fake/fake_robot.h"
#include "session/run_scores.h"
#include "session/run_tables.h"
#include "session/session.h"
#include "tests/control/genova02.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

/// Where the ball is: it circles in front of the head, and is hidden for a tenth of the time.
Eigen::Vector3d ball_at(std::int64_t t_us) {
  const double phase = 1e-6 * static_cast<double>(t_us);
  return {-0.5, 0.1 * std::cos(phase), 0.4 + 0.05 * std::sin(0.7 * phase)};
}

/// Detects the ball with an error that grows and falls, at scores that are all different.
class SweepingDetector final : public Detector {
 public:
  explicit SweepingDetector(std::string_view name) : random_(1, name) {}
  void process(std::span<const Event>, const CameraMotion*) override {}
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override {
    estimate_ = {};
    const auto circle =
        icub_left_2016.project_sphere(motion->root_from_camera.inverse() * ball_at(now_us), 0.03);
    if (!circle) return;
    const double error_px = random_.uniform(0.0, 8.0, 0, static_cast<std::uint64_t>(now_us));
    estimate_ = {true, false, {circle->x_px + error_px, circle->y_px, circle->r_px}, 9.0 - error_px};
  }
  [[nodiscard]] Estimate estimate() override { return estimate_; }
  [[nodiscard]] double threshold() const override { return 4.0; }
  [[nodiscard]] RejectedEvents rejected() const override { return {}; }

 private:
  RandomStream random_;
  Estimate estimate_;
};

/// The fake robot with an event each millisecond for as long as it runs: FakeRobotScript::events is a list.
class EndlessRobot final : public Robot, private EventSource {
 public:
  explicit EndlessRobot(FakeRobotScript script) : fake_(std::move(script)) {}
  Clock& clock() override { return fake_; }
  EventSource& events() override { return *this; }
  HeadPort* head() override { return &fake_; }

 private:
  [[nodiscard]] ImageSize image_size() const override { return fake_.image_size(); }
  PortStatus read_until(std::int64_t t_us, std::vector<Event>& events) override {
    events.push_back({t_us, static_cast<std::uint16_t>(t_us / 1000 % 128), 64, t_us / 1000 % 2 == 0, 0});
    return PortStatus::ok;
  }
  [[nodiscard]] std::int64_t heard_us() const override { return fake_.heard_us(); }
  [[nodiscard]] EventTraffic traffic() const override { return {}; }

  FakeRobot fake_;
};

/// The truth of such a world, before tables and scores read it.
class TruthObserver final : public LoopObserver {
 public:
  void on_tick(const Tick& tick) override {
    truth.t_us = tick.t_us;
    truth.ball_m = ball_at(tick.t_us);
    truth.plant_position_rad = tick.head->position_rad;
    truth.left.root_from_cam =
        HeadKinematics(default_head()->chain, tick.head->position_rad).root_from_eye(Eye::left);
    truth.left.visible = tick.t_us / 1'000'000 % 10 == 9 ? 0.0 : 1.0;
    truth.left.circle =
        icub_left_2016.project_sphere(truth.left.root_from_cam.inverse() * truth.ball_m, 0.03);
    if (!truth.left.circle) truth.left.visible = 0.0;
  }
  SimTruth truth;
};

/// Writes tables and starts them again in the same files before they fill the disk.
class RestartedTables final : public LoopObserver {
 public:
  explicit RestartedTables(std::function<std::unique_ptr<RunTables>()> make)
      : make_(std::move(make)), tables_(make_()) {}
  void on_tick(const Tick& tick) override {
    constexpr std::int64_t restart_us = 1'000'000'000;
    tables_->on_tick(tick);
    if (tick.t_us % restart_us != 0) return;
    tables_.reset();  // the files are removed, since they were not committed
    tables_ = make_();
  }

 private:
  std::function<std::unique_ptr<RunTables>()> make_;
  std::unique_ptr<RunTables> tables_;
};

class Sampler final : public LoopObserver {
 public:
  Sampler(std::int64_t sample_ticks, const std::function<void(std::int64_t)>& sample)
      : sample_ticks_(sample_ticks), sample_(sample) {}
  void on_tick(const Tick&) override {
    if (++done_ % sample_ticks_ == 0) sample_(done_);
  }

 private:
  std::int64_t sample_ticks_;
  const std::function<void(std::int64_t)>& sample_;
  std::int64_t done_ = 0;
};

}  // namespace

void run_over_ticks(std::int64_t ticks, std::int64_t sample_ticks,
                    const std::function<void(std::int64_t done)>& sample) {
  FakeRobotScript script;
  script.limits = genova02_limits();
  EndlessRobot robot(script);
  Scenario scenario;
  scenario.name = "endless";
  scenario.gaze.detector = "driver";
  scenario.gaze.gate = built_in_gates().config();
  scenario.gaze.controller = built_in_controllers().config();
  scenario.output.formats = built_in_formats();
  scenario.output.events = "aedat4";  // holds any time; a file of AEDAT 2.0 starts before 2147 s
  std::vector<LoopDetector> detectors;
  detectors.push_back({"driver", std::make_unique<SweepingDetector>("driver")});
  detectors.push_back({"shadow", std::make_unique<SweepingDetector>("shadow")});
  Loop loop(robot, MountedCamera{icub_left_2016, {}}, std::move(detectors),
            LoopGaze{0, make_gate(scenario.gaze.gate),
                     LoopMotion{make_gaze_controller(scenario.gaze.controller, script.limits),
                                JointLimiter(motion_limits(script.limits, scenario.gaze.controller.limits))},
                     scenario.gaze.follow});
  TruthObserver world;
  const GroundTruth truth(world.truth, [] { return std::span<const EventLabel>(); });
  TempFolder folder;
  std::filesystem::create_directories(folder / "tables");
  const auto make_tables = [&] {
    return std::make_unique<RunTables>(folder / "tables", scenario, truth, loop, nullptr);
  };
  RestartedTables tables(make_tables);
  RunScores scores(scenario, truth, script.limits, loop, nullptr);
  RunLog log([](std::int64_t, const std::string&) {});
  Sampler sampler(sample_ticks, sample);
  Session session(robot, loop);
  for (LoopObserver* const observer :
       std::initializer_list<LoopObserver*>{&world, &tables, &scores, &log, &sampler}) {
    session.add_observer(*observer);
  }
  session.run(1'000, ticks * 1'000);
  const Metrics metrics = scores.metrics();
  SACCADE_CHECK(metrics.detectors.size() == 2 && metrics.detectors.front().second.chances > 0);
}

std::int64_t resident_kb() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word != "VmRSS:") continue;
    std::int64_t kb = 0;
    status >> kb;
    return kb;
  }
  return 0;
}

}  // namespace saccade
