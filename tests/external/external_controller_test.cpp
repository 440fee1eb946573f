// Gaze controllers in programs of their own: the protocol, and what happens when a program breaks it.
#include "external/external_controller.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <limits>

#include "core/error.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::ThrowsMessage;

MotionLimits half_rad_limits() {
  MotionLimits limits;
  limits.max_rad = limits.hardware_max_rad = HeadJointVector::Constant(0.5);
  limits.min_rad = limits.hardware_min_rad = HeadJointVector::Constant(-0.5);
  limits.speed_rad_s = HeadJointVector::Constant(2.0);
  limits.acceleration_rad_s2 = HeadJointVector::Constant(100.0);
  return limits;
}

/// A program in the shell: it reads both lines of the start; `rest` is what it does then.
class ShellController {
 public:
  explicit ShellController(const std::string& rest) : path_((folder_ / "mine").string()) {
    std::ofstream(path_) << "#!/bin/sh\nread a; read b; echo \"$b\" >> $0.log\n" << rest << "\n";
    ::chmod(path_.c_str(), 0755);
  }
  [[nodiscard]] ExternalController start() const {
    return ExternalController("mine", ProgramCall{{path_}}, {5.0, 0.3}, half_rad_limits());
  }
  [[nodiscard]] std::string log() const { return bytes_of(path_ + ".log"); }

 private:
  TempFolder folder_;
  std::string path_;
};

const Eigen::Vector3d ahead(-0.5, 0.0, 0.35);

TEST(ExternalController, GetsLimitsJointsAndTargetsAndItsAnswerIsTheReferenceWithinTheLimits) {
  const ShellController program(
      "echo ready; while read q; do echo \"$q\" >> $0.log; echo reference 0.1 -0.2 0 3 0 1e-3; done");
  ExternalController controller = program.start();
  HeadState state;
  state.position_rad.head<joint_count>() << 0.1, 0.2, 0.3, 0.4, 0.5, 0.25, 0.125, 0, -0.5;
  HeadJointVector expected = HeadJointVector::Zero();
  expected.head<head_joint_count>() << 0.1, -0.2, 0.0, 0.5, 0.0, 1e-3;
  EXPECT_EQ(controller.step(state, std::nullopt, 0.001), expected);
  EXPECT_EQ(controller.target_status(), TargetStatus::none);
  (void)controller.step(state, ahead, 0.001);
  EXPECT_EQ(controller.target_status(), TargetStatus::ok);
  controller.rest();
  (void)controller.step(state, std::nullopt, 0.002);
  EXPECT_THAT(controller.failure(), IsEmpty());
  const std::string joints = "0.1 0.2 0.3 0.4 0.5 0.25 0.125 0 -0.5";
  EXPECT_EQ(program.log(),
            "limits -0.5 -0.5 -0.5 -0.5 -0.5 -0.5 0.5 0.5 0.5 0.5 0.5 0.5 2 2 2 2 2 2\n"
            "step 0.001 " +
                joints +
                " none\n"
                "step 0.001 " +
                joints +
                " -0.5 0 0.35\n"
                "step 0.002 " +
                joints + " rest\n");
}

TEST(ExternalController, IsNotAskedWhileTheEncodersAreNotReadAndGetsNoTargetThatTheHeadCannotLookAt) {
  const ShellController program(
      "echo ready; while read q; do echo \"$q\" >> $0.log; echo reference 0 0 0 0 0 0; done");
  ExternalController controller = program.start();
  HeadState unread;
  unread.position_rad[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(controller.step(unread, ahead, 0.001), HeadJointVector::Zero().eval());
  (void)controller.step(HeadState{}, Eigen::Vector3d(1.0, 0.0, 0.35), 0.001);  // behind the robot
  EXPECT_EQ(controller.target_status(), TargetStatus::behind);
  EXPECT_THAT(program.log(), testing::EndsWith("step 0.001 0 0 0 0 0 0 0 0 0 none\n"));
}

TEST(ExternalController, ThatEndsAnswersNonsenseOrHangsKeepsItsLastReferencesAndSaysWhy) {
  const struct {
    const char* then;
    const char* reason;
  } cases[] = {
      {"exit 3", "mine ended at 0 s, with status 3"},
      {"read q; echo reference 0 0 0",
       "mine answered `reference 0 0 0` at 0 s, expected `reference` and six"},
      {"read q; echo failed no more of it; exit 3", "mine failed at 0 s: no more of it"},
      {"read q; echo reference 0 0 0 0 0 nan", "mine answered"},
      {"read q; echo reference 0 0 0 0 0 0 0", "mine answered"},
      {"sleep 600", "mine gave no answer at 0 s within 300 ms"},
  };
  for (const auto& [then, reason] : cases) {
    const ShellController program(std::string("echo ready; read q; echo reference 0.25 0 0 0 0 0; ") + then);
    ExternalController controller = program.start();
    const HeadJointVector first = controller.step(HeadState{}, std::nullopt, 0.001);
    EXPECT_EQ(first[0], 0.25);
    for (int again = 0; again < 2; ++again) {
      EXPECT_EQ(controller.step(HeadState{}, ahead, 0.001), first) << then;
      EXPECT_EQ(controller.target_status(), TargetStatus::ok);
      EXPECT_THAT(std::string(controller.failure()), HasSubstr(reason)) << then;
    }
  }
}

TEST(ExternalController, ThatDoesNotSayReadyIsARunError) {
  EXPECT_THAT([] { (void)ShellController("echo ready 0.5; sleep 600").start(); },
              ThrowsMessage<RunError>(HasSubstr("answered `ready 0.5` at its start, expected `ready`")));
  EXPECT_THAT([] { (void)ShellController("echo failed no limits; exit 1").start(); },
              ThrowsMessage<RunError>(HasSubstr("mine failed at its start: no limits")));
  EXPECT_THAT([] { (void)ShellController("exit 1").start(); },
              ThrowsMessage<RunError>(HasSubstr("gaze controller mine ended at its start, with status 1")));
}

}  // namespace
}  // namespace saccade
