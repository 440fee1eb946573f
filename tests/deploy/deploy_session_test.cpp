// Activation, faults, timing and overload of a deployed robot, in fake time.
#include "apps/deploy/deploy_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "control/controller_registry.h"
#include "control/gate_registry.h"
#include "control/head_kinematics.h"
#include "control/open_gate.h"
#include "core/detectors/built_in_detectors.h"
#include "core/error.h"
#include "head/icub_cameras.h"
#include "loop/watchdog.h"
#include "robot/dry_robot.h"
#include "robot/fake/fake_robot.h"
#include "tests/control/genova02.h"
#include "tests/control/malloc_count.h"
#include "tests/deploy/fake_deployed.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::int64_t tick_us = 1000;
constexpr std::int64_t fault_us = 500'000;
const Eigen::Vector3d ball_m(-0.5, 0.15, 0.40);

/// Sees the ball through the left eye, exactly; each look takes `cost_us` of the robot's time, and `cost_us_per_ms` more for
/// each ms since the last one whose work was not left out.
class ExactDetector final : public Detector {
 public:
  struct Work {
    std::int64_t events = 0;
    std::int64_t looks = 0;
    std::int64_t first_event_us = 0;
  };
  ExactDetector(Work* work = nullptr, FakeRobot* world = nullptr, std::int64_t cost_us = 0,
                std::int64_t cost_us_per_ms = 0)
      : work_(work), world_(world), cost_us_(cost_us), cost_us_per_ms_(cost_us_per_ms) {}

  void process(std::span<const Event> events, const CameraMotion*) override {
    if (work_ == nullptr) return;
    if (work_->events == 0 && !events.empty()) work_->first_event_us = events.front().t_us;
    work_->events += static_cast<std::int64_t>(events.size());
  }
  void leave_out_work_before(std::int64_t t_us) override { work_from_us_ = t_us; }
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override {
    if (work_ != nullptr) ++work_->looks;
    const std::int64_t work_us = now_us - std::max(work_from_us_, std::exchange(worked_us_, now_us));
    const std::int64_t cost_us = cost_us_ + cost_us_per_ms_ * work_us / 1'000;
    if (world_ != nullptr && cost_us > 0) world_->wait_until(world_->now_us() + cost_us);
    estimate_ = {};
    if (motion == nullptr) return;
    const auto circle = icub_left_2016.project_sphere(motion->root_from_camera.inverse() * ball_m, 0.0475);
    if (circle) estimate_ = {true, true, *circle, 1.0};
  }
  [[nodiscard]] Estimate estimate() override { return estimate_; }
  [[nodiscard]] double threshold() const override { return 0.5; }
  [[nodiscard]] RejectedEvents rejected() const override { return {}; }

 private:
  Work* work_;
  FakeRobot* world_;
  std::int64_t cost_us_;
  std::int64_t cost_us_per_ms_;
  std::int64_t work_from_us_ = 0;
  std::int64_t worked_us_ = 0;
  Estimate estimate_;
};

/// Keeps all that it is called with; ticks in memory that is reserved.
class Notes final : public DeployObserver {
 public:
  Notes() { ticks.reserve(10'000); }
  void on_tick(const Tick& tick, const TickTiming& timing) override {
    ticks.push_back({tick.t_us, timing, tick.events_left_out, tick.command,
                     tick.detectors.size() > 1 && tick.detectors[1].skipped});
  }
  void on_change(const DeployChange& change) override { changes.push_back(change); }
  void on_news(std::int64_t, const std::string&) override {}

  struct Seen {
    std::int64_t t_us;
    TickTiming timing;
    std::size_t left_out;
    JointLimiter::Result command;
    bool shadow_skipped;
  };
  std::vector<Seen> ticks;
  std::vector<DeployChange> changes;
};

/// One session in fake time, ready, with a ball before it.
class Trial {
 public:
  struct Options {
    bool with_gaze = false;
    double ramp_in_s = 0.0;
    bool dry = false;
    std::optional<LoopBudget> budget = std::nullopt;
    std::int64_t driver_us = 0, shadow_us = 0;  ///< what a look costs
    std::int64_t driver_us_per_ms = 0;
    bool shadow = false;
    Overseer* overseer = nullptr;
  };
  explicit Trial(FakeRobotScript script = {}) : Trial(std::move(script), Options()) {}
  Trial(FakeRobotScript script, const Options& options) {
    script.limits = genova02_limits();
    script.lag_s = 0.02;
    auto owned = std::make_unique<FakeDeployed>(script, options.with_gaze);
    fake = owned.get();
    robot = std::move(owned);
    if (options.dry) robot = std::make_unique<DryRobot>(std::move(robot));
    std::vector<LoopDetector> detectors;
    detectors.push_back({"seer", std::make_unique<ExactDetector>(&driver, &fake->world, options.driver_us,
                                                                 options.driver_us_per_ms)});
    if (options.shadow)
      detectors.push_back(
          {"shadow", std::make_unique<ExactDetector>(&shadow, &fake->world, options.shadow_us)});
    loop.emplace(
        *robot, MountedCamera{icub_left_2016, {}}, std::move(detectors),
        LoopGaze{0, std::make_unique<OpenGate>(TargetConfig{}), std::nullopt, FollowConfig{.start_s = 0.0}},
        Eye::left, options.budget);
    const auto motion = [this, options] {
      const JointLimits limits = robot->head()->limits();
      LoopMotion made;
      made.ramp_in_s = options.ramp_in_s;
      if (robot->gaze() != nullptr) {
        made.port = robot->gaze();
      } else {
        made.controller = make_gaze_controller(built_in_controllers().config(), limits);
        made.limiter.emplace(motion_limits(limits, {}));
      }
      return made;
    };
    DeploySessionConfig config{tick_us, {}};
    config.joints_follow = !options.dry;
    if (options.overseer != nullptr) config.overseers = {options.overseer};
    session.emplace(*robot, *loop, motion, requests, notes, config);
  }
  /// Ready, and activated at once.
  void activate() {
    session->set_ready();
    requests.activate();
  }
  /// Ticks until the robot's clock says so, or the session is over (then false).
  bool run_until(std::int64_t t_us) {
    while (robot->clock().now_us() < t_us) {
      if (!session->tick()) return false;
    }
    return true;
  }
  [[nodiscard]] std::vector<DeployState> states() const {
    std::vector<DeployState> states;
    for (const DeployChange& change : notes.changes) states.push_back(change.state);
    return states;
  }

  FakeDeployed* fake = nullptr;
  std::unique_ptr<Robot> robot;
  ExactDetector::Work driver, shadow;
  std::optional<Loop> loop;
  OperatorRequests requests;
  Notes notes;
  std::optional<DeploySession> session;
};

// ---- what an operator does -----------------------------------------------------------------------

TEST(DeploySession, NothingIsSentToTheHeadBeforeActivation) {
  Trial trial;
  EXPECT_EQ(trial.session->state(), DeployState::unconfigured);
  trial.session->set_ready();
  ASSERT_TRUE(trial.run_until(1'000'000));
  EXPECT_EQ(trial.session->state(), DeployState::ready);
  EXPECT_EQ(trial.fake->commands, 0);
  EXPECT_FALSE(trial.fake->is_active);
  EXPECT_EQ(trial.driver.looks, 1000) << "the detector works before";

  trial.requests.activate();
  ASSERT_TRUE(trial.run_until(3'000'000));
  EXPECT_EQ(trial.session->state(), DeployState::active);
  EXPECT_EQ(trial.fake->commands, 2000);
  EXPECT_EQ(trial.fake->commands_while_not_active, 0);
  HeadState head;
  trial.fake->world.read(head);
  const Eigen::Isometry3d eye =
      HeadKinematics(default_head()->chain, head.position_rad).root_from_eye(Eye::left);
  const Eigen::Vector3d to_ball = (ball_m - eye.translation()).normalized();
  EXPECT_GT(eye.linear().col(2).dot(to_ball), std::cos(0.1 * rad_per_deg)) << "it looks at the ball";

  trial.requests.stop();
  ASSERT_TRUE(trial.run_until(3'500'000));
  EXPECT_EQ(trial.fake->commands, 2000);
  EXPECT_EQ(trial.fake->stops, 1);
  EXPECT_FALSE(trial.fake->is_active);
  EXPECT_THAT(trial.states(), ElementsAre(DeployState::ready, DeployState::active, DeployState::stopped));
}

TEST(DeploySession, ActivationNeedsPassedStartUpChecks) {
  Trial trial;
  trial.requests.activate();
  ASSERT_TRUE(trial.run_until(100'000));
  EXPECT_EQ(trial.session->state(), DeployState::unconfigured);
  ASSERT_EQ(trial.notes.changes.size(), 1u);
  EXPECT_THAT(trial.notes.changes[0].rejected, HasSubstr("start-up check"));
  EXPECT_EQ(trial.fake->commands, 0);
}

TEST(DeploySession, ARobotThatRejectsActivationStaysInactiveAndCanBeActivatedLater) {
  Trial trial;
  trial.fake->refuse_activation = true;
  trial.activate();
  ASSERT_TRUE(trial.run_until(100'000));
  EXPECT_EQ(trial.session->state(), DeployState::ready);
  EXPECT_EQ(trial.notes.changes.back().rejected, "neck_yaw is in HW_FAULT");
  trial.fake->refuse_activation = false;
  trial.requests.activate();
  ASSERT_TRUE(trial.run_until(200'000));
  EXPECT_EQ(trial.session->state(), DeployState::active);
}

TEST(DeploySession, ASlowActivationIsNotALateTick) {
  Trial trial;
  trial.fake->activation_us = 400'000;
  trial.activate();
  ASSERT_TRUE(trial.run_until(1'000'000));
  EXPECT_EQ(trial.session->state(), DeployState::active);
}

/// Notes how many events the detector had when the head became active.
class EventsAtActivation final : public Overseer {
 public:
  void on_tick() override {}
  std::optional<Fault> fault() override { return std::nullopt; }
  std::string why_not() override { return {}; }
  void activating() override {}
  void activated() override { events = work->events; }
  void stopped() override {}

  const ExactDetector::Work* work = nullptr;
  std::int64_t events = 0;
};

TEST(DeploySession, EventsThatComeDuringASlowActivationAreProcessedBeforeTheHeadIsActive) {
  FakeRobotScript script;
  for (std::int64_t t_us = 0; t_us < 1'000'000; t_us += 100) script.events.push_back({t_us, 64, 64, true, 0});
  EventsAtActivation seen;
  Trial::Options options;
  options.overseer = &seen;
  options.driver_us = 5'000;  // a tick that is behind; so are those after it
  Trial trial(std::move(script), options);
  seen.work = &trial.driver;
  trial.fake->activation_us = 400'000;
  trial.activate();
  ASSERT_TRUE(trial.session->tick());
  EXPECT_EQ(trial.session->state(), DeployState::active);
  EXPECT_GE(seen.events, 4'000) << "ten in a millisecond";
  EXPECT_EQ(trial.fake->commands, 0);
  for (const Notes::Seen& tick : trial.notes.ticks) EXPECT_EQ(tick.timing.state, DeployState::ready);
  const std::int64_t last_us = trial.notes.ticks.back().t_us;
  ASSERT_TRUE(trial.session->tick());
  EXPECT_GT(trial.notes.ticks.back().t_us, last_us) << "no tick twice";
}

TEST(DeploySession, QuittingStopsTheHeadFirst) {
  Trial trial;
  trial.activate();
  ASSERT_TRUE(trial.run_until(500'000));
  trial.requests.quit(StopCause::interrupted);
  EXPECT_FALSE(trial.session->tick());
  EXPECT_EQ(trial.fake->stops, 1);
  EXPECT_FALSE(trial.fake->is_active);
  ASSERT_TRUE(trial.session->last_stop());
  EXPECT_EQ(trial.session->last_stop()->cause, StopCause::interrupted);
}

TEST(DeploySession, TheEndOfARecordingStopsTheHeadAndIsNotAFault) {
  FakeRobotScript script;
  script.end_us = fault_us;
  Trial trial(script);
  trial.activate();
  EXPECT_FALSE(trial.run_until(1'000'000));
  EXPECT_EQ(trial.session->state(), DeployState::stopped);
  EXPECT_EQ(trial.session->last_stop()->cause, StopCause::ended);
  EXPECT_FALSE(is_fault(trial.session->last_stop()->cause));
}

TEST(DeploySession, ADryRunComputesCommandsAndSendsNone) {
  Trial trial({}, {.dry = true});
  trial.activate();
  ASSERT_TRUE(trial.run_until(1'000'000));
  EXPECT_EQ(trial.session->state(), DeployState::active);
  EXPECT_FALSE(trial.notes.ticks.back().command.reference_rad.isZero()) << "there was a command to send";
  trial.requests.stop();
  ASSERT_TRUE(trial.run_until(1'100'000));
  EXPECT_EQ(trial.fake->commands + trial.fake->stops + trial.fake->released, 0);
  EXPECT_FALSE(trial.fake->is_active);
}

// ---- a head that starts slowly -------------------------------------------------------------------

TEST(DeploySession, TheSpeedLimitGrowsOverTheRampIn) {
  Trial trial({}, {.ramp_in_s = 1.0});
  trial.activate();
  ASSERT_TRUE(trial.run_until(2'000'000));
  const MotionLimits limits = motion_limits(genova02_limits(), {});
  HeadJointVector before = HeadJointVector::Zero();
  double fastest = 0.0;
  for (const auto& seen : trial.notes.ticks) {
    const HeadJointVector speed = (seen.command.reference_rad - before).cwiseAbs() / 1e-3;
    const double share = std::min(1.0, 1e-6 * static_cast<double>(seen.t_us - tick_us + tick_us));
    ASSERT_TRUE((speed.array() <= share * limits.speed_rad_s.array() + 1e-9).all()) << seen.t_us;
    fastest = std::max(fastest, (speed.array() / limits.speed_rad_s.array()).maxCoeff());
    before = seen.command.reference_rad;
  }
  std::printf("fastest: %.2f of the speed limit\n", fastest);
  EXPECT_GT(fastest, 0.05);
}

TEST(DeploySession, TheRobotsGazeControllerGetsTargetsAfterTheRampInAndAStopCommand) {
  Trial trial({}, {.with_gaze = true, .ramp_in_s = 0.3});
  trial.activate();
  ASSERT_TRUE(trial.run_until(1'000'000));
  EXPECT_EQ(trial.fake->commands, 0) << "the head itself is only read";
  ASSERT_FALSE(trial.fake->targets.empty());
  EXPECT_GE(trial.fake->targets.front().first, 300'000);
  EXPECT_LT(trial.fake->targets.front().first, 303'000);
  EXPECT_LT((trial.fake->targets.back().second - ball_m).norm(), 1e-6);
  const std::size_t count = trial.fake->targets.size();
  trial.requests.stop();
  ASSERT_TRUE(trial.run_until(1'100'000));
  EXPECT_EQ(trial.fake->stops, 1);
  EXPECT_EQ(trial.fake->targets.size(), count);
  EXPECT_EQ(trial.fake->commands_while_not_active, 0);
}

// ---- faults --------------------------------------------------------------------------------------

struct FaultCase {
  std::string name;
  std::function<void(FakeRobotScript&)> happens;  ///< at fault_us
  StopCause cause;
  std::string words;
  bool passes = false;  ///< after 50 ms all is well again
  bool over = false;    ///< and the session is
};
void PrintTo(const FaultCase& fault, std::ostream* out) { *out << fault.name; }

class DeployFaults : public testing::TestWithParam<FaultCase> {};
INSTANTIATE_TEST_SUITE_P(
    , DeployFaults,
    testing::Values(FaultCase{"SilentCamera", [](auto& s) { s.silent_us = fault_us; },
                              StopCause::camera_silent, "no packet from the camera for 61.0 ms"},
                    FaultCase{"FrozenEncoders", [](auto& s) { s.freeze_us = fault_us; },
                              StopCause::joints_stale, "no reading of the joints for 61.0 ms"},
                    FaultCase{"LostConnection", [](auto& s) { s.lost_us = fault_us; }, StopCause::lost,
                              "lost the connection to the clock", false, true},
                    FaultCase{"EncoderReadsNan",
                              [](auto& s) {
                                s.nan_us = {fault_us, fault_us + 50'000};
                              },
                              StopCause::joints_not_finite, "neck_yaw is not a number", true},
                    FaultCase{"JointOutside", [](auto& s) { s.outside_us = fault_us; },
                              StopCause::joint_outside, "neck_yaw is 2.0 deg outside its limits"},
                    FaultCase{"JointSwitchedOff",
                              [](auto& s) {
                                s.drive_us = {fault_us, JointDrive::off};
                              },
                              StopCause::joint_off, "neck_yaw was switched off"},
                    FaultCase{"JointInFault",
                              [](auto& s) {
                                s.drive_us = {fault_us, JointDrive::fault};
                              },
                              StopCause::joint_fault, "neck_yaw is in hardware fault"},
                    FaultCase{"LateTick",
                              [](auto& s) {
                                s.late_us = {fault_us, 30'000};
                              },
                              StopCause::tick_late, "a tick came 30.0 ms late", true}),
    [](const auto& fault) { return fault.param.name; });

TEST_P(DeployFaults, StopTheHeadInTimeUntilTheOperatorActivatesAgain) {
  for (const bool with_gaze : {false, true}) {
    FakeRobotScript script;
    GetParam().happens(script);
    Trial trial(script, {.with_gaze = with_gaze});
    trial.activate();
    EXPECT_EQ(trial.run_until(1'000'000), !GetParam().over);
    EXPECT_EQ(trial.session->state(), DeployState::stopped);
    ASSERT_TRUE(trial.session->last_stop());
    EXPECT_EQ(trial.session->last_stop()->cause, GetParam().cause);
    EXPECT_EQ(trial.session->last_stop()->description(), GetParam().words);
    EXPECT_THAT(trial.states(), ElementsAre(DeployState::ready, DeployState::active, DeployState::stopped));
    EXPECT_EQ(trial.fake->stops, 1);
    EXPECT_GE(trial.fake->released, 1);
    EXPECT_EQ(trial.fake->commands_while_not_active, 0);
    const double after_ms = 1e-3 * static_cast<double>(trial.fake->first_stop_us - fault_us);
    const double took_ms = 1e-3 * static_cast<double>(trial.notes.changes.back().took_us);
    std::printf("%s: stopped %.1f ms after it happened, %.1f ms after its fact\n", GetParam().name.c_str(),
                after_ms, took_ms);
    EXPECT_LE(after_ms, WatchdogConfig{}.safe_within_ms);
    EXPECT_LE(took_ms, WatchdogConfig{}.safe_within_ms);
    EXPECT_GE(took_ms, after_ms - 1.0);

    if (GetParam().over) continue;
    trial.requests.activate();
    trial.run_until(1'100'000);
    EXPECT_EQ(trial.session->state(), GetParam().passes ? DeployState::active : DeployState::stopped)
        << "a fault that is still there keeps it from being activated";
  }
}

TEST(DeploySession, AJointWhoseModeAnotherProgramChangesStopsTheHeadWhichCanBeActivatedAgain) {
  FakeRobotScript script;
  script.drive_us = {fault_us, JointDrive::held};
  Trial trial(script);
  trial.activate();
  ASSERT_TRUE(trial.run_until(600'000));
  EXPECT_EQ(trial.session->state(), DeployState::stopped);
  EXPECT_EQ(trial.session->last_stop()->cause, StopCause::joint_taken);
  EXPECT_THAT(trial.session->last_stop()->description(), HasSubstr("neck_yaw no longer follows references"));
}

TEST(DeploySession, ARejectedReferenceStopsTheHead) {
  FakeRobotScript script;
  script.refuse_us = fault_us;
  Trial trial(script);
  trial.activate();
  ASSERT_TRUE(trial.run_until(600'000));
  EXPECT_EQ(trial.session->state(), DeployState::stopped);
  EXPECT_EQ(trial.session->last_stop()->cause, StopCause::command_refused);
  EXPECT_LE(trial.fake->first_stop_us - fault_us, 2 * tick_us);
}

TEST(DeploySession, AJointThatDoesNotFollowItsReferenceStopsTheHead) {
  FakeRobotScript script;
  script.stuck_us = 0;
  Trial trial(script);
  trial.activate();
  ASSERT_TRUE(trial.run_until(2'000'000));
  EXPECT_EQ(trial.session->state(), DeployState::stopped);
  EXPECT_EQ(trial.session->last_stop()->description(), "neck_yaw has not followed its reference for 501 ms");
}

TEST(FollowWatch, NoticesAJointThatRestsWhileItsReferenceSwingsAboutIt) {
  // Within 4 deg, less than lag_deg; the joint's encoder has noise of 0.05 deg.
  for (const double follows : {0.0, 0.3}) {
    FollowWatch watch(6.0);
    std::optional<std::int64_t> since_us;
    for (std::int64_t t_us = 0; t_us < 2'000'000; t_us += 1000) {
      const double swing_rad = 4.0 * rad_per_deg * std::sin(6.28e-6 * static_cast<double>(t_us));
      HeadJointVector reference = HeadJointVector::Zero(), position = HeadJointVector::Zero();
      reference[2] = swing_rad;
      position[2] = follows * swing_rad + (t_us % 2000 == 0 ? 0.05 : -0.05) * rad_per_deg;
      watch.update(t_us, reference, t_us, position);
      TickFacts facts;
      watch.add_to(facts);
      if (facts.lags_since_us) {
        EXPECT_EQ(facts.lagging, torso_slots + 2);
        since_us = facts.lags_since_us;
      }
    }
    EXPECT_EQ(since_us.has_value(), follows == 0.0);
    if (since_us) {
      EXPECT_LT(*since_us, 400'000);
    }
  }
  FollowWatch watch(6.0);
  TickFacts facts;
  HeadJointVector reference = HeadJointVector::Zero();
  for (int i = 0; i < 1000; ++i) {  // within what friction holds
    reference[1] = 2.5 * rad_per_deg * (i % 2);
    watch.update(i * 1000, reference, i * 1000, HeadJointVector::Zero());
  }
  watch.add_to(facts);
  EXPECT_FALSE(facts.lags_since_us.has_value());
}

TEST(FollowWatch, CountsFromTheFirstReadingThatIsTooFarAndForgetsWhenTheJointArrives) {
  FollowWatch watch(6.0);
  HeadJointVector position_rad = HeadJointVector::Zero();
  position_rad[1] = 7.0 * rad_per_deg;
  watch.update(1'000, HeadJointVector::Zero(), 1'000, position_rad);
  position_rad[4] = -7.0 * rad_per_deg;
  watch.update(2'000, HeadJointVector::Zero(), 2'000, position_rad);
  TickFacts facts;
  watch.add_to(facts);
  EXPECT_EQ(facts.lags_since_us, 1'000);
  EXPECT_EQ(facts.lagging, neck_roll);
  position_rad[1] = 0.0;
  watch.update(3'000, HeadJointVector::Zero(), 3'000, position_rad);
  facts = {};
  watch.add_to(facts);
  EXPECT_EQ(facts.lags_since_us, 2'000);
  EXPECT_EQ(facts.lagging, eyes_version);
}

TEST(FollowWatch, ComparesAReadingWithTheReferenceOfItsOwnTime) {
  // 120 deg/s with readings that are 50 ms old and arrive every 30 ms: 6 deg behind the newest reference, 3 deg behind that
  // of their time. A joint that is 7 deg behind does lag.
  for (const auto& [behind_deg, lags] : {std::pair{3.0, false}, {7.0, true}}) {
    FollowWatch watch(6.0);
    for (std::int64_t t_us = 0; t_us < 700'000; t_us += 1000) {
      const std::int64_t read_us = t_us / 30'000 * 30'000 - 20'000;
      HeadJointVector reference = HeadJointVector::Zero(), position = HeadJointVector::Zero();
      reference[2] = 120e-6 * static_cast<double>(t_us) * rad_per_deg;
      position[2] = 120e-6 * static_cast<double>(read_us) * rad_per_deg - behind_deg * rad_per_deg;
      watch.update(t_us, reference, read_us, position);
    }
    TickFacts facts;
    watch.add_to(facts);
    EXPECT_EQ(facts.lags_since_us.has_value(), lags) << behind_deg;
  }
}

// ---- activation that is tried again --------------------------------------------------------------

TEST(DeployActivation, IsRepeatedUntilTheRobotIsReadyAndReportsEachReasonOnce) {
  FakeRobotScript script;
  script.nan_us = {0, 300'000};  // an encoder that starts late
  Trial trial(script);
  trial.session->set_ready();
  trial.session->keep_activating(2'000'000);
  ASSERT_TRUE(trial.run_until(500'000));
  EXPECT_EQ(trial.session->state(), DeployState::active);
  EXPECT_TRUE(trial.session->not_activated().empty());
  ASSERT_EQ(trial.notes.changes.size(), 3u);
  EXPECT_EQ(trial.notes.changes[1].rejected, "neck_yaw is not a number");
}

TEST(DeployActivation, WaitsForATickInTimeAfterTheFirst) {
  FakeRobotScript script;
  script.late_us = {2'000, 60'000};  // the second tick begins late, and so the third
  Trial trial(script);
  trial.session->set_ready();
  trial.session->keep_activating(2'000'000);
  for (int tick = 0; tick < 3; ++tick) {
    ASSERT_TRUE(trial.session->tick());
    EXPECT_EQ(trial.session->state(), DeployState::ready);
  }
  ASSERT_TRUE(trial.session->tick());
  EXPECT_EQ(trial.session->state(), DeployState::active);
}

TEST(DeployActivation, EndsTheSessionWithTheReasonAfterItsTime) {
  Trial trial;
  trial.fake->refuse_activation = true;
  trial.session->set_ready();
  trial.session->keep_activating(1'000'000);
  EXPECT_FALSE(trial.run_until(5'000'000)) << "the session ends";
  EXPECT_LE(trial.robot->clock().now_us(), 1'100'000);
  EXPECT_EQ(trial.session->not_activated(), "not activated within 1.0 s: neck_yaw is in HW_FAULT");
  EXPECT_EQ(trial.fake->commands, 0);
}

TEST(DeployActivation, AStopEndsTheAttempts) {
  FakeRobotScript script;
  script.nan_us = {0, 300'000};  // the attempts have no success until then
  Trial trial(script);
  trial.session->set_ready();
  trial.session->keep_activating(2'000'000);
  ASSERT_TRUE(trial.run_until(100'000));
  trial.requests.stop();
  ASSERT_TRUE(trial.run_until(3'000'000));
  EXPECT_EQ(trial.session->state(), DeployState::ready);
  EXPECT_FALSE(trial.fake->is_active);
  EXPECT_EQ(trial.fake->commands, 0);
  EXPECT_EQ(trial.session->not_activated(), "the operator requested a stop");
  trial.requests.activate();
  ASSERT_TRUE(trial.run_until(3'100'000));
  EXPECT_EQ(trial.session->state(), DeployState::active) << "the operator can still activate it";
}

TEST(DeployActivation, AStopIsNotLostToAnActivationInTheSameTick) {
  Trial trial;
  trial.activate();
  ASSERT_TRUE(trial.run_until(100'000));
  for (const bool stop_first : {true, false}) {
    trial.requests.activate();
    ASSERT_TRUE(trial.run_until(trial.robot->clock().now_us() + 100'000));
    ASSERT_EQ(trial.session->state(), DeployState::active);
    if (stop_first) trial.requests.stop();
    trial.requests.activate();
    if (!stop_first) trial.requests.stop();
    ASSERT_TRUE(trial.session->tick());
    EXPECT_EQ(trial.session->state(), DeployState::stopped);
  }
}

TEST(DeployActivation, AJointThatIsSwitchedOffIsNotActivated) {
  FakeRobotScript script;
  script.drive_us = {0, JointDrive::off};
  Trial trial(script);
  trial.activate();
  ASSERT_TRUE(trial.run_until(100'000));
  EXPECT_EQ(trial.session->state(), DeployState::ready);
  EXPECT_EQ(trial.session->not_activated(), "neck_yaw was switched off");
  EXPECT_FALSE(trial.fake->is_active) << "the robot was not asked";
}

TEST(DeployActivation, AJointInAnotherModeThatHoldsItIsTakenOver) {
  FakeRobotScript script;
  script.drive_us = {0, JointDrive::held};
  Trial trial(script);
  trial.activate();
  ASSERT_TRUE(trial.run_until(tick_us));
  EXPECT_TRUE(trial.fake->is_active);
}

// ---- what watches from outside -------------------------------------------------------------------

/// Demands a stop, or refuses activation, when told to.
class ScriptedOverseer final : public Overseer {
 public:
  void on_tick() override { ++ticks; }
  std::optional<Fault> fault() override { return demanded; }
  std::string why_not() override { return reason; }
  void activating() override { order += "activating "; }
  void activated() override { order += "activated "; }
  void stopped() override { order += "stopped "; }
  void released() override { order += robot->is_active ? "too early " : "released "; }

  int ticks = 0;
  std::optional<Fault> demanded;
  std::string reason;
  std::string order;
  const FakeDeployed* robot = nullptr;
};

TEST(DeployOverseer, CanRefuseActivationAndStopTheHead) {
  ScriptedOverseer overseer;
  overseer.reason = "no guard";
  Trial trial({}, {.overseer = &overseer});
  overseer.robot = trial.fake;
  trial.activate();
  ASSERT_TRUE(trial.run_until(10'000));
  EXPECT_EQ(trial.session->not_activated(), "no guard");
  EXPECT_EQ(trial.fake->commands, 0);

  overseer.reason.clear();
  trial.requests.activate();
  ASSERT_TRUE(trial.run_until(fault_us));
  EXPECT_EQ(trial.session->state(), DeployState::active);
  overseer.demanded = Fault{StopCause::guard_lost, 0, {}, 41.0};
  ASSERT_TRUE(trial.run_until(fault_us + 10'000));
  EXPECT_EQ(trial.session->state(), DeployState::stopped);
  EXPECT_EQ(trial.fake->stops, 1);
  EXPECT_EQ(trial.session->last_stop()->description(), "no sign of the guard for 41.0 ms");
  EXPECT_NEAR(static_cast<double>(trial.notes.changes.back().took_us), 41e3, 1.0);
  EXPECT_EQ(overseer.order, "activating activated stopped released ");
  EXPECT_EQ(overseer.ticks, static_cast<int>(trial.notes.ticks.size()));
}

TEST(Watchdog, BoundsThatExceedSafeWithinAreRejected) {
  WatchdogConfig config;
  config.camera_silent_ms = 90.0;
  try {
    const Watchdog watchdog(config);
    FAIL() << "not refused";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("safe_within_ms: found 100, expected at least 127"));
  }
}

TEST(Watchdog, ToleratesASingleLatePacketAndReading) {
  const Watchdog watchdog({}, genova02_limits());
  HeadState head;
  head.t_us = 1'000'000 - 60'000;
  EXPECT_FALSE(watchdog.check({1'000'000 - 20'000, 1'000'000, 1'000'000 - 60'000, head}));
}

// ---- too much to do ------------------------------------------------------------------------------

TEST(DeployOverload, MissedTicksAreSkipped) {
  Trial trial({}, {.driver_us = 2'600});
  trial.activate();
  ASSERT_TRUE(trial.run_until(1'000'000));
  EXPECT_EQ(trial.session->state(), DeployState::active);
  std::int64_t missed = 0;
  for (std::size_t i = 0; i < trial.notes.ticks.size(); ++i) {
    const auto& seen = trial.notes.ticks[i];
    missed += seen.timing.missed;
    EXPECT_EQ(seen.t_us % tick_us, 0) << "on the grid of ticks";
    EXPECT_LE(seen.timing.begin_us - seen.t_us, tick_us / 2) << "the one that is due";
  }
  EXPECT_EQ(static_cast<std::int64_t>(trial.notes.ticks.size()) + missed,
            trial.notes.ticks.back().t_us / tick_us);
  EXPECT_NEAR(static_cast<double>(trial.notes.ticks.size()), 1e6 / 3'000, 5) << "each waits for the next";
}

// Without a pause, ticks with real-time priority would take a processor from the threads that receive events and readings.
TEST(DeployOverload, TicksThatTakeLongerThanTheirPeriodLeaveTheProcessorToTheInputs) {
  for (const std::int64_t driver_us : {1'100, 1'400, 1'900, 2'300, 2'700, 7'200}) {
    Trial trial({}, {.driver_us = driver_us});
    trial.activate();
    ASSERT_TRUE(trial.run_until(1'000'000));
    std::int64_t busy_us = 0;  // since the last pause
    std::int64_t longest_us = 0;
    std::int64_t end_us = 0;
    for (const auto& seen : trial.notes.ticks) {
      if (seen.timing.begin_us > end_us) busy_us = 0;
      busy_us += seen.timing.end_us - seen.timing.begin_us;
      longest_us = std::max(longest_us, busy_us);
      end_us = seen.timing.end_us;
    }
    // 1.1 ms: five ticks until they are half a period behind.
    EXPECT_LE(longest_us, std::max<std::int64_t>(5 * tick_us + tick_us / 2, driver_us)) << driver_us;
  }
}

TEST(DeployOverload, ATickThatIsALittleLateCostsNoOther) {
  FakeRobotScript script;
  script.late_us = {fault_us, 400};
  Trial trial(std::move(script));
  trial.activate();
  ASSERT_TRUE(trial.run_until(1'000'000));
  EXPECT_EQ(trial.notes.ticks.size(), 1'000U);
}

TEST(DeployOverload, ALateTickDoesNotMakeTheNextOneLater) {
  // 1.6 ms of work for each ms of the stream: with all of it every tick would be later than the one before.
  const auto latest_us = [](std::int64_t work_us) {
    Trial trial({}, {.budget = LoopBudget{2'000, 500, work_us}, .driver_us_per_ms = 1'600});
    trial.activate();
    EXPECT_TRUE(trial.run_until(1'000'000));
    std::int64_t latest_us = 0;
    for (const auto& seen : trial.notes.ticks)
      latest_us = std::max(latest_us, seen.timing.begin_us - seen.timing.due_us);
    return latest_us;
  };
  EXPECT_LE(latest_us(2'000), 3'000);
  EXPECT_GT(latest_us(1'000'000), 20'000);
}

TEST(DeployOverload, DetectorsGetTheNewestEventsAndNoQueueGrows) {
  FakeRobotScript script;
  for (std::int64_t i = 0; i < 50'000; ++i) script.events.push_back({100'000 + i / 10, 5, 5, true, 0});
  Trial trial(script, {.budget = LoopBudget{2'000, 500}});
  trial.activate();
  ASSERT_TRUE(trial.run_until(110'000));
  EXPECT_EQ(trial.driver.events, 5 * 2'000 + 10) << "10 events per us for 5 ms, at most 2000 in a tick";
  EXPECT_EQ(trial.driver.first_event_us, 100'000);
  std::size_t left_out = 0;
  for (const auto& seen : trial.notes.ticks) left_out += seen.left_out;
  EXPECT_EQ(static_cast<std::int64_t>(left_out), 50'000 - trial.driver.events);
}

TEST(DeployOverload, ShadowDetectorsAreSkippedFirstAndTheCommandDoesNotWaitForThem) {
  for (const std::int64_t driver_us : {200, 600}) {
    Trial trial({},
                {.budget = LoopBudget{2'000, 500}, .driver_us = driver_us, .shadow_us = 100, .shadow = true});
    trial.activate();
    ASSERT_TRUE(trial.run_until(200'000));
    const std::int64_t ticks = static_cast<std::int64_t>(trial.notes.ticks.size());
    EXPECT_EQ(ticks, 200);
    EXPECT_EQ(trial.driver.looks, ticks) << "the one that drives never is";
    EXPECT_EQ(trial.shadow.looks, driver_us < 500 ? ticks : 0);
    EXPECT_EQ(trial.notes.ticks.back().shadow_skipped, driver_us > 500);
    EXPECT_EQ(trial.fake->commands, ticks);
  }
}

// ---- memory --------------------------------------------------------------------------------------

TEST(DeploySession, ATickDoesNotAllocate) {
  if (!malloc_is_counted()) GTEST_SKIP() << "a sanitizer owns malloc";
  for (const char* preset : {"best", "paper_directed"}) {
    for (const bool with_gaze : {false, true}) {
      const FakeRobotScript script = script_with_busy_camera();
      FakeDeployed robot(script, with_gaze);
      std::vector<LoopDetector> detectors;
      detectors.push_back({"seer", std::make_unique<ExactDetector>()});
      detectors.push_back({preset, make_detector(built_in_detectors().config(preset), icub_left_2016)});
      Loop loop(robot, MountedCamera{icub_left_2016, {}}, std::move(detectors),
                LoopGaze{0, make_gate(built_in_gates().config()), std::nullopt, FollowConfig{.start_s = 0.0}},
                Eye::left, LoopBudget{2'000, 500});
      const auto motion = [&] {
        if (robot.gaze() != nullptr) return LoopMotion{nullptr, std::nullopt, robot.gaze()};
        return LoopMotion{make_gaze_controller(built_in_controllers().config(), script.limits),
                          JointLimiter(motion_limits(script.limits, {}))};
      };
      OperatorRequests requests;
      Notes notes;
      robot.targets.reserve(10'000);
      DeploySession session(robot, loop, motion, requests, notes, {});
      session.set_ready();
      requests.activate();
      for (int i = 0; i < 50; ++i) ASSERT_TRUE(session.tick());  // activation may allocate
      const long before = malloc_count();
      for (int i = 0; i < 500; ++i) ASSERT_TRUE(session.tick());
      EXPECT_EQ(malloc_count(), before) << preset << " with 100 events a tick";
      EXPECT_EQ(session.state(), DeployState::active);
    }
  }
}

}  // namespace
}  // namespace saccade
