// What the head does, and what the log says of it, when targets go wrong.
#include "loop/loop.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <sstream>

#include "control/controller_registry.h"
#include "control/head_kinematics.h"
#include "control/open_gate.h"
#include "head/icub_cameras.h"
#include "loop/run_log.h"
#include "robot/fake/fake_robot.h"
#include "tests/control/genova02.h"

namespace saccade {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;

using Script = std::function<std::optional<Eigen::Vector3d>(std::int64_t t_us)>;

/// Sees a ball where the script has it, through the left eye, exactly.
class BallSeer final : public Detector {
 public:
  explicit BallSeer(Script ball_m) : ball_m_(std::move(ball_m)) {}
  void process(std::span<const Event>, const CameraMotion*) override {}
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override {
    estimate_ = {};
    const auto ball_m = ball_m_(now_us);
    if (!ball_m || motion == nullptr) return;
    const auto circle = icub_left_2016.project_sphere(motion->root_from_camera.inverse() * *ball_m, 0.0475);
    if (circle) estimate_ = {true, true, *circle, 1.0};
  }
  [[nodiscard]] Estimate estimate() override { return estimate_; }
  [[nodiscard]] double threshold() const override { return 0.5; }
  [[nodiscard]] RejectedEvents rejected() const override { return {}; }

 private:
  Script ball_m_;
  Estimate estimate_;
};

/// Hands over what the script says, whatever was seen.
class ScriptedGate final : public GazeGate {
 public:
  explicit ScriptedGate(Script target_m) : target_m_(std::move(target_m)) {}
  std::optional<Eigen::Vector3d> update(std::int64_t now_us, const Estimate&, double, const Camera&,
                                        const Eigen::Isometry3d&) override {
    return target_m_(now_us);
  }
  [[nodiscard]] RejectedTargets rejected() const override { return {}; }

 private:
  Script target_m_;
};

const Eigen::Vector3d ball_m(-0.5, 0.15, 0.40);
std::optional<Eigen::Vector3d> no_ball(std::int64_t) { return std::nullopt; }

/// A fake head that sees, by default a ball at ball_m in the first second, and what became of it.
struct Trial {
  Script ball = [](std::int64_t t_us) {
    return t_us <= 1'000'000 ? std::optional(ball_m) : std::optional<Eigen::Vector3d>();
  };
  std::unique_ptr<GazeGate> gate;
  FollowConfig follow{0.0, WhenLost::hold, 1.0};
  FakeRobotScript robot;
  HeadCommand limit_margin_rad = HeadCommand::Zero();  ///< the head's own limits lie that much further in
  /// After this tick a new controller takes over, or a second detector where it is given.
  std::int64_t take_over_us = 0;
  Script ball_of_the_other;

  std::vector<std::string> log;
  std::vector<HeadCommand> references_rad;  ///< of every millisecond
  HeadState head;                           ///< at the end

  void run(const std::string& controller, double duration_s) {
    GazeControllerConfig config = built_in_controllers().config();
    config.controller = controller;
    const JointLimits limits = genova02_limits();
    robot.limits = limits;
    robot.limits.max_rad.tail<gaze_slots>() -= limit_margin_rad;
    robot.lag_s = 0.02;
    FakeRobot fake(robot);
    if (!gate) gate = std::make_unique<OpenGate>(TargetConfig{});
    std::vector<LoopDetector> detectors;
    detectors.push_back({"seer", std::make_unique<BallSeer>(ball)});
    Loop loop(fake, MountedCamera{icub_left_2016, {}}, std::move(detectors),
              LoopGaze{0, std::move(gate),
                       LoopMotion{make_gaze_controller(config, limits),
                                  JointLimiter(motion_limits(limits, config.limits))},
                       follow});
    RunLog run_log([&](std::int64_t t_us, const std::string& text) {
      char time[32];
      std::snprintf(time, sizeof time, "%10.3f s  ", 1e-6 * static_cast<double>(t_us));
      log.push_back(time + text);
    });
    for (std::int64_t t_us = 1000; t_us <= std::llround(duration_s * 1e6); t_us += 1000) {
      loop.tick(t_us, run_log);
      references_rad.push_back(fake.reference_rad());
      ASSERT_TRUE(is_allowed(references_rad.back(), robot.limits));
      if (t_us != take_over_us) continue;
      if (!ball_of_the_other) {
        loop.set_controller(make_gaze_controller(config, limits));
        continue;
      }
      std::vector<LoopDetector> others;
      others.push_back({"seer", std::make_unique<BallSeer>(ball)});
      others.push_back({"other", std::make_unique<BallSeer>(ball_of_the_other)});
      loop.set_detectors(std::move(others), 1);
    }
    run_log.finish();
    robot.nan_us.reset();
    fake.read(head);
  }
  [[nodiscard]] double error_deg(const Eigen::Vector3d& target_m) const {
    const Eigen::Isometry3d eye =
        HeadKinematics(default_head()->chain, head.position_rad).root_from_eye(Eye::left);
    const Eigen::Vector3d to_target = target_m - eye.translation();
    return std::atan2(eye.linear().col(2).cross(to_target).norm(), eye.linear().col(2).dot(to_target)) /
           rad_per_deg;
  }
  [[nodiscard]] double furthest_from_neutral_deg() const {
    return head.head_position_rad().cwiseAbs().maxCoeff() / rad_per_deg;
  }
};

/// The widest way of the left eye's axis from a ball that the detector holds, deg, in the last of three seconds.
double widest_deg(double amplitude_deg) {
  Trial trial;
  trial.ball = [](std::int64_t) { return std::optional(ball_m); };
  trial.follow.fixational = {amplitude_deg, 0.3, 2.0};
  trial.run("qp", 3.0);
  double widest = 0.0;
  for (std::size_t i = 2000; i < 3000; ++i) {
    JointVector joints = JointVector::Zero();
    joints.tail<gaze_slots>() = trial.references_rad[i];
    const Eigen::Vector3d seen =
        HeadKinematics(default_head()->chain, joints).root_from_eye(Eye::left).inverse() * ball_m;
    widest = std::max(widest, std::atan2(seen.head<2>().norm(), seen.z()) / rad_per_deg);
  }
  EXPECT_EQ(trial.log.size(), 1u);  // it is never lost
  return widest;
}

TEST(FixationalMovements, TheEyesMoveAroundABallThatIsOnlyHeld) {
  EXPECT_LT(widest_deg(0.0), 0.1);
  const double widest = widest_deg(1.0);
  EXPECT_GT(widest, 0.8);
  EXPECT_LT(widest, 2.0);
}

class LostTargets : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(, LostTargets, testing::Values("qp", "ikingaze"),
                         [](const auto& name) { return name.param; });

TEST_P(LostTargets, TheHeadHoldsTheDirectionOfTheLastTarget) {
  Trial trial;
  trial.run(GetParam(), 4.0);
  EXPECT_LT(trial.error_deg(ball_m), 0.1);
  EXPECT_THAT(trial.log, ElementsAre("     0.001 s  ball found at (-0.500, 0.150, 0.400) m",
                                     "     2.000 s  target lost, last seen at 1.000 s: the head holds"));
}

TEST_P(LostTargets, TheHeadReturnsToRestAndFindsTheBallAgain) {
  Trial trial;
  trial.follow = {0.0, WhenLost::rest, 0.5};
  trial.run(GetParam(), 6.0);
  EXPECT_LT(trial.furthest_from_neutral_deg(), 0.2);
  EXPECT_THAT(trial.log,
              ElementsAre(HasSubstr("ball found"),
                          "     1.500 s  target lost, last seen at 1.000 s: the head returns to rest"));

  Trial again;
  again.follow = {0.0, WhenLost::rest, 0.5};
  again.ball = [](std::int64_t t_us) {
    return t_us <= 1'000'000 || t_us > 2'000'000 ? std::optional(ball_m) : std::optional<Eigen::Vector3d>();
  };
  again.run(GetParam(), 5.0);
  EXPECT_LT(again.error_deg(ball_m), 0.1);
  ASSERT_EQ(again.log.size(), 3u);
  EXPECT_EQ(again.log[2], "     2.001 s  ball found again at (-0.500, 0.150, 0.400) m");
}

TEST_P(LostTargets, TheHeadSearchesAroundAndFindsTheBallAgain) {
  Trial trial;
  trial.follow = {0.0, WhenLost::search, 0.5, 1.0};
  trial.ball = [](std::int64_t t_us) {
    return t_us <= 1'000'000 || t_us > 9'000'000 ? std::optional(ball_m) : std::optional<Eigen::Vector3d>();
  };
  trial.run(GetParam(), 11.0);
  EXPECT_THAT(trial.log, ElementsAre(HasSubstr("ball found at"), HasSubstr("1.500 s  target lost"),
                                     "     2.500 s  the head searches",
                                     "     9.001 s  ball found again at (-0.500, 0.150, 0.400) m"));
  double left_rad = 0.0, right_rad = 0.0, up_rad = 0.0, down_rad = 0.0;
  for (std::size_t i = 3000; i < 9000; ++i) {
    const HeadCommand& reference_rad = trial.references_rad[i];
    const double yaw_rad = reference_rad[head_index(neck_yaw)] - reference_rad[head_index(eyes_version)];
    const double pitch_rad = reference_rad[head_index(neck_pitch)] + reference_rad[head_index(eyes_tilt)];
    left_rad = std::max(left_rad, yaw_rad);
    right_rad = std::min(right_rad, yaw_rad);
    up_rad = std::max(up_rad, pitch_rad);
    down_rad = std::min(down_rad, pitch_rad);
  }
  EXPECT_GT(left_rad - right_rad, 20.0 * rad_per_deg);
  EXPECT_GT(up_rad - down_rad, 8.0 * rad_per_deg);
  EXPECT_LT(trial.error_deg(ball_m), 0.1);
}

TEST_P(LostTargets, ANewControllerKeepsLookingAtTheTargetOfTheOldOne) {
  Trial trial;
  trial.take_over_us = 2'000'000;
  trial.run(GetParam(), 4.0);
  EXPECT_LT(trial.error_deg(ball_m), 0.1);
  const double step_rad = (trial.references_rad[2000] - trial.references_rad[1999]).cwiseAbs().maxCoeff();
  EXPECT_LT(step_rad, 0.05 * rad_per_deg);
}

TEST_P(LostTargets, ANewDrivingDetectorMovesTheHead) {
  Trial trial;
  trial.ball = no_ball;
  trial.take_over_us = 1'000'000;
  trial.ball_of_the_other = [](std::int64_t) { return std::optional(ball_m); };
  trial.run(GetParam(), 4.0);
  EXPECT_LT(trial.error_deg(ball_m), 0.1);
  EXPECT_THAT(trial.log, ElementsAre("     1.001 s  ball found at (-0.500, 0.150, 0.400) m"));
}

TEST_P(LostTargets, AHeadWithoutATargetStaysAtRest) {
  Trial trial;
  trial.ball = no_ball;
  trial.run(GetParam(), 2.0);
  EXPECT_LT(trial.furthest_from_neutral_deg(), 0.1);
  EXPECT_THAT(trial.log, ElementsAre("     2.000 s  ball never found"));
}

TEST_P(LostTargets, ATargetBehindTheHeadTooNearOrNotFiniteIsRejectedAndTheHeadHolds) {
  const Eigen::Vector3d nan = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  for (const auto& [bad, why] : {std::pair{Eigen::Vector3d(0.5, 0.1, 0.4), "behind the head"},
                                 {Eigen::Vector3d(-0.12, -0.03, 0.34), "too near"},
                                 {nan, "not finite"}}) {
    Trial trial;
    trial.gate =
        std::make_unique<ScriptedGate>([bad = bad](std::int64_t t_us) -> std::optional<Eigen::Vector3d> {
          if (t_us <= 1'000'000) return ball_m;
          if (t_us > 2'000'000 && t_us <= 2'500'000) return bad;
          if (t_us == 3'000'000) return bad;
          return std::nullopt;
        });
    trial.run(GetParam(), 4.0);
    EXPECT_LT(trial.error_deg(ball_m), 0.1);
    EXPECT_THAT(trial.log, ElementsAre(HasSubstr("ball found"), HasSubstr("the head holds"),
                                       AllOf(HasSubstr(std::string("target rejected, ") + why),
                                             EndsWith(": 500 times from 2.001 to 2.500 s")),
                                       AllOf(HasSubstr(why), EndsWith(": once from 3.000 to 3.000 s"))));
  }
}

TEST_P(LostTargets, TheGateRejectsABallCloserThanTenCentimetres) {
  Trial trial;
  trial.ball = [](std::int64_t) { return std::optional(Eigen::Vector3d(-0.145, -0.034, 0.347)); };
  trial.run(GetParam(), 0.5);
  EXPECT_LT(trial.furthest_from_neutral_deg(), 0.1);
  EXPECT_THAT(trial.log,
              ElementsAre("     0.500 s  target rejected, too near: 500 times from 0.001 to 0.500 s",
                          "     0.500 s  ball never found"));
}

TEST_P(LostTargets, TheHeadHoldsWhileAnEncoderReadsNanAndContinuesAfterwards) {
  Trial trial;
  trial.ball = [](std::int64_t) { return std::optional(ball_m); };
  trial.robot.nan_us = {100'000, 300'000};
  trial.follow.lost_after_s = 0.15;
  trial.run(GetParam(), 4.0);
  for (std::size_t ms = 200; ms < 299; ++ms) {  // a neck at 80 deg/s has braked after 80 ms
    ASSERT_EQ(trial.references_rad[ms], trial.references_rad[199]) << ms;
  }
  EXPECT_NE(trial.references_rad[60], trial.references_rad[199]);
  EXPECT_LT(trial.error_deg(ball_m), 0.1);
  EXPECT_THAT(
      trial.log,
      ElementsAre(HasSubstr("ball found"), "     0.100 s  head state not finite: the head holds",
                  HasSubstr("0.249 s  target lost"), "     0.300 s  head state finite again, after 200 ticks",
                  HasSubstr("0.300 s  ball found again")));
}

/// Counts its runs and the events that it got, and is sure of a ball at the image centre.
class CountingDetector final : public Detector {
 public:
  struct Counts {
    int runs = 0;
    int events = 0;
  };
  explicit CountingDetector(Counts& counts) : counts_(counts) {}
  void process(std::span<const Event> events, const CameraMotion*) override {
    counts_.events += static_cast<int>(events.size());
  }
  void advance_to(std::int64_t, const CameraMotion*) override { ++counts_.runs; }
  [[nodiscard]] Estimate estimate() override { return {true, true, {64.0, 64.0, 10.0}, 1.0}; }
  [[nodiscard]] double threshold() const override { return 0.5; }
  [[nodiscard]] RejectedEvents rejected() const override { return {}; }

 private:
  Counts& counts_;
};

/// Ticks with an observation of any detector.
class ObservedTicks final : public LoopObserver {
 public:
  void on_tick(const Tick& tick) override {
    events += static_cast<int>(tick.events.size());
    for (const DetectorTick& detector : tick.detectors) observations += detector.observed ? 1 : 0;
    if (tick.right) observations += tick.right->observed ? 1 : 0;
  }
  int events = 0;
  int observations = 0;
};

TEST(LoopTest, NoDetectorRunsWhileAnEncoderReadsNan) {
  FakeRobotScript script;
  script.limits = genova02_limits();
  script.nan_us = {30'000, 70'000};
  for (int i = 1; i <= 200; ++i) {
    script.events.push_back({i * 500, 64, 64, true, static_cast<std::uint8_t>(i % 2)});
  }
  FakeRobot robot(script);
  CountingDetector::Counts driver, shadow, right;
  std::vector<LoopDetector> detectors;
  detectors.push_back({"driver", std::make_unique<CountingDetector>(driver)});
  detectors.push_back({"shadow", std::make_unique<CountingDetector>(shadow)});
  LoopGaze gaze{0,
                std::make_unique<OpenGate>(TargetConfig{}),
                LoopMotion{make_gaze_controller(built_in_controllers().config(), script.limits),
                           JointLimiter(motion_limits(script.limits, {}))},
                {.start_s = 0.0}};
  gaze.stereo.emplace(LoopStereo{std::make_unique<CountingDetector>(right),
                                 MountedCamera{icub_right_2016, {}}, StereoLocator({})});
  Loop loop(robot, MountedCamera{icub_left_2016, {}}, std::move(detectors), std::move(gaze));
  ObservedTicks ticks;
  for (std::int64_t t_us = 1000; t_us <= 100'000; t_us += 1000) loop.tick(t_us, ticks);
  EXPECT_EQ(ticks.events, 200) << "events are recorded throughout";
  for (const auto& counts : {driver, shadow, right}) {
    EXPECT_EQ(counts.runs, 60);
    EXPECT_EQ(counts.events, 60);
  }
  EXPECT_EQ(ticks.observations, 3 * 60);
}

TEST_P(LostTargets, AnEncoderThatReadsNanFromTheStartLeavesTheHeadAtItsNeutralPose) {
  Trial trial;
  trial.robot.nan_us = {0, 10'000'000};
  trial.run(GetParam(), 0.5);
  EXPECT_LT(trial.references_rad.back().cwiseAbs().maxCoeff(), 0.1 * rad_per_deg);
  EXPECT_THAT(trial.log, ElementsAre(HasSubstr("not finite"), HasSubstr("never found")));
}

TEST_P(LostTargets, RejectedCommandsAreOneMessage) {
  Trial trial;
  trial.limit_margin_rad[eyes_version - torso_joint_count] = 25.0 * rad_per_deg;  // the head's ends at 5 deg
  trial.ball = [](std::int64_t t_us) {
    return std::optional(t_us < 1'000'000 ? ball_m : Eigen::Vector3d(-0.5, 0.0, 0.35));
  };
  trial.run(GetParam(), 2.0);
  ASSERT_EQ(trial.log.size(), 3u);
  EXPECT_THAT(trial.log[1], HasSubstr("command rejected by the head"));
  EXPECT_THAT(trial.log[2], HasSubstr("the head accepts commands again, after"));
}

TEST(RunLogTest, HasNoMessagesAboutTargetsWithoutADrivingDetector) {
  std::vector<std::string> lines;
  RunLog log([&](std::int64_t, const std::string& text) { lines.push_back(text); });
  Tick tick;
  for (tick.t_us = 1000; tick.t_us < 5000; tick.t_us += 1000) log.on_tick(tick);
  log.finish();
  EXPECT_TRUE(lines.empty());
}

// ---- both eyes -----------------------------------------------------------------------------------

/// Sees the ball through an eye's camera as if it were larger than it is, and counts events.
class OneEyed final : public Detector {
 public:
  struct Seen {
    int events = 0;
    int of_the_other_eye = 0;
  };

  OneEyed(Eye eye, double radius_m, Seen& seen) : eye_(eye), radius_m_(radius_m), seen_(seen) {}
  void process(std::span<const Event> events, const CameraMotion*) override {
    for (const Event& event : events) {
      ++seen_.events;
      seen_.of_the_other_eye += event.camera == static_cast<std::uint8_t>(eye_) ? 0 : 1;
    }
  }
  void advance_to(std::int64_t, const CameraMotion* motion) override {
    if (motion == nullptr) return;
    const Camera camera = eye_ == Eye::left ? icub_left_2016 : icub_right_2016;
    const auto circle = camera.project_sphere(motion->root_from_camera.inverse() * ball_m, radius_m_);
    estimate_ = circle ? Estimate{true, true, *circle, 1.0} : Estimate{};
  }
  [[nodiscard]] Estimate estimate() override { return estimate_; }
  [[nodiscard]] double threshold() const override { return 0.5; }
  [[nodiscard]] RejectedEvents rejected() const override { return {}; }

 private:
  Eye eye_;
  double radius_m_;
  Seen& seen_;
  Estimate estimate_;
};

class Targets final : public LoopObserver {
 public:
  void on_tick(const Tick& tick) override {
    ASSERT_TRUE(tick.target_m);
    errors_m.push_back((*tick.target_m - ball_m).norm());
  }
  std::vector<double> errors_m;
};

TEST(BothEyes, EachDetectorGetsItsEyesEventsAndTheBallsDistanceComesFromBoth) {
  for (const bool stereo : {false, true}) {
    FakeRobotScript script;
    script.limits = genova02_limits();
    for (int i = 1; i <= 200; ++i) {
      script.events.push_back({i * 500, 64, 64, true, static_cast<std::uint8_t>(i % 3 == 0 ? 1 : 0)});
    }
    FakeRobot fake(script);
    OneEyed::Seen left, right;
    const double radius_m = 0.06;  // of a ball of 0.0475: by its radius it is 0.1 m too near
    std::vector<LoopDetector> detectors;
    detectors.push_back({"left", std::make_unique<OneEyed>(Eye::left, radius_m, left)});
    LoopGaze gaze{0,
                  std::make_unique<OpenGate>(TargetConfig{}),
                  LoopMotion{make_gaze_controller(built_in_controllers().config(), script.limits),
                             JointLimiter(motion_limits(script.limits, {}))},
                  {.start_s = 0.0}};
    if (stereo) {
      gaze.stereo.emplace(LoopStereo{std::make_unique<OneEyed>(Eye::right, radius_m, right),
                                     MountedCamera{icub_right_2016, {}}, StereoLocator({})});
    }
    Loop loop(fake, MountedCamera{icub_left_2016, {}}, std::move(detectors), std::move(gaze));
    Targets targets;
    for (std::int64_t t_us = 1000; t_us <= 100'000; t_us += 1000) loop.tick(t_us, targets);
    EXPECT_EQ(left.events, 134);
    EXPECT_EQ(right.events, stereo ? 66 : 0);
    EXPECT_EQ(left.of_the_other_eye + right.of_the_other_eye, 0);
    const double worst_m = *std::max_element(targets.errors_m.begin(), targets.errors_m.end());
    std::printf("%s: targets up to %.2g m off\n", stereo ? "both eyes" : "left eye", worst_m);
    if (stereo) {
      EXPECT_LT(worst_m, 1e-9);
    } else {
      EXPECT_GT(worst_m, 0.05);
    }
  }
}

}  // namespace
}  // namespace saccade
