#include "control/joint_limiter.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/error.h"
#include "head/head_model.h"
#include "tests/control/genova02.h"

namespace saccade {
namespace {

constexpr double dt = 1e-3;
constexpr double rounding = 1e-9;

MotionLimits limits() { return motion_limits(genova02_limits(), {}); }

/// The value for each joint of the head, 0 for the others.
HeadJointVector all(double value_rad) {
  HeadJointVector values = HeadJointVector::Zero();
  values.head(default_head()->gaze_joints()).setConstant(value_rad);
  return values;
}

/// Every tick of a stream of references: inside the limits of position, speed and acceleration.
class Watch {
 public:
  explicit Watch(const HeadJointVector& start) : last_(start) {}

  void see(const HeadJointVector& reference) {
    const MotionLimits l = limits();
    const HeadJointVector velocity = (reference - last_) / dt;
    ASSERT_TRUE(reference.allFinite());
    ASSERT_TRUE((reference.array() >= l.min_rad.array() && reference.array() <= l.max_rad.array()).all());
    ASSERT_TRUE((velocity.array().abs() <= l.speed_rad_s.array() + rounding).all());
    ASSERT_TRUE(
        (((velocity - velocity_) / dt).array().abs() <= l.acceleration_rad_s2.array() * (1.0 + 1e-6)).all());
    last_ = reference;
    velocity_ = velocity;
  }

 private:
  HeadJointVector last_ = HeadJointVector::Zero();
  HeadJointVector velocity_ = HeadJointVector::Zero();
};

HeadJointVector middle() { return 0.5 * (limits().min_rad + limits().max_rad); }

TEST(JointLimiter, PassesAGentleStreamUnchanged) {
  JointLimiter limiter(limits());
  for (int i = 0; i < 3000; ++i) {
    // From rest at the middle; 4 deg at 1 Hz needs 25 deg/s and 158 deg/s^2.
    const double angle = 2.0 * std::numbers::pi * i * dt;
    const HeadJointVector command = middle() + all(4.0 * rad_per_deg * (1.0 - std::cos(angle)) / 2.0);
    const JointLimiter::Result result = limiter.apply(command, middle(), dt);
    ASSERT_EQ(result.reference_rad, command);
    ASSERT_TRUE(result.position.none() && result.speed.none() && result.acceleration.none());
  }
}

TEST(JointLimiter, KeepsTheSpeedBelowTheAllowedShare) {
  for (const double share : {0.0, 0.1, 0.5}) {
    JointLimiter limiter(limits());
    const HeadJointVector goal = middle() + all(10.0 * rad_per_deg);
    HeadJointVector before = middle();
    HeadJointVector fastest = HeadJointVector::Zero();
    for (int i = 0; i < 500; ++i) {
      const HeadJointVector reference = limiter.apply(goal, middle(), dt, share).reference_rad;
      fastest = fastest.cwiseMax((reference - before).cwiseAbs() / dt);
      before = reference;
    }
    EXPECT_TRUE((fastest.array() <= share * limits().speed_rad_s.array() + rounding).all()) << share;
    EXPECT_TRUE((fastest.array() >= share * limits().speed_rad_s.array() - rounding).all()) << share;
  }
}

TEST(JointLimiter, AStepBecomesAMoveAtTheLimitsWithoutOvershoot) {
  JointLimiter limiter(limits());
  Watch watch(middle());
  const HeadJointVector goal = middle() + all(10.0 * rad_per_deg);
  int arrived = 0;
  for (int i = 1; i <= 1000; ++i) {
    const HeadJointVector reference = limiter.apply(goal, middle(), dt).reference_rad;
    ASSERT_NO_FATAL_FAILURE(watch.see(reference));
    ASSERT_TRUE((reference.array() <= goal.array() + rounding).all());
    if (arrived == 0 && reference == goal) arrived = i;
  }
  // Neck: 10 deg at 1000 deg/s^2 and at most 80 deg/s last 10 / 80 + 80 / 1000 = 0.205 s.
  EXPECT_NEAR(arrived, 205, 4);
}

TEST(JointLimiter, KeepsAnyStreamWithinEveryLimit) {
  const RandomStream random(1, "limiter");
  JointLimiter limiter(limits());
  Watch watch(middle());
  for (std::uint64_t i = 0; i < 50000; ++i) {
    HeadJointVector command = HeadJointVector::Zero();
    for (int j = 0; j < head_joint_count; ++j) {
      // Jumps, holds and jitter, often far outside.
      const auto s = static_cast<std::uint64_t>(j);
      command[j] = random.uniform(-1.5, 1.5, s, i / 137) + 0.02 * random.normal(10 + s, i);
    }
    ASSERT_NO_FATAL_FAILURE(watch.see(limiter.apply(command, middle(), dt).reference_rad)) << i;
  }
}

TEST(JointLimiter, ReportsWhichLimitActedOnWhichJoint) {
  const int yaw = neck_yaw - torso_joint_count;
  const int tilt = eyes_tilt - torso_joint_count;
  const auto only = [](int joint) { return JointMask().set(static_cast<std::size_t>(joint)); };
  JointLimiter limiter(limits());
  (void)limiter.apply(middle(), middle(), dt);

  HeadJointVector outside = middle();
  outside[tilt] = 40.0 * rad_per_deg;
  JointLimiter::Result result = limiter.apply(outside, middle(), dt);
  EXPECT_EQ(result.position, only(tilt));
  EXPECT_EQ(result.speed, only(tilt));

  JointLimiter other(limits());
  (void)other.apply(middle(), middle(), dt);
  HeadJointVector jump = middle();
  jump[yaw] += 0.05 * rad_per_deg;  // 50 deg/s out of rest: within the speed, not within the acceleration
  result = other.apply(jump, middle(), dt);
  EXPECT_TRUE(result.position.none());
  EXPECT_TRUE(result.speed.none());
  EXPECT_EQ(result.acceleration, only(yaw));
}

TEST(JointLimiter, KeepsTheLastCommandIfOneIsNotFinite) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    JointLimiter limiter(limits());
    const HeadJointVector goal = middle() + all(1.0 * rad_per_deg);
    (void)limiter.apply(goal, middle(), dt);
    HeadJointVector broken = middle();
    broken[2] = bad;
    JointLimiter::Result result;
    for (int i = 0; i < 500; ++i) {
      result = limiter.apply(broken, middle(), dt);
      ASSERT_TRUE(result.not_finite);
      ASSERT_TRUE(result.reference_rad.allFinite());
    }
    EXPECT_EQ(result.reference_rad, goal);
  }
}

TEST(JointLimiter, MovesAHeadThatStartsOutsideItsLimitsBackSmoothly) {
  const MotionLimits l = limits();
  for (const double beyond_deg : {0.03, -0.03, 5.0, -5.0}) {
    // 0.03 deg: in the margin; 5 deg: outside of what the hardware allows.
    const HeadJointVector stop = beyond_deg > 0 ? l.max_rad : l.min_rad;
    const HeadJointVector start = stop + all(beyond_deg * rad_per_deg);
    JointLimiter limiter(l);
    HeadJointVector last = inside_hardware(l, start);
    HeadJointVector velocity = HeadJointVector::Zero();
    for (int i = 0; i < 400; ++i) {
      const HeadJointVector reference = limiter.apply(start, start, dt).reference_rad;
      // A port refuses references outside of its limits.
      ASSERT_TRUE((reference.array() >= l.hardware_min_rad.array()).all());
      ASSERT_TRUE((reference.array() <= l.hardware_max_rad.array()).all());
      const HeadJointVector next_velocity = (reference - last) / dt;
      ASSERT_TRUE(
          ((next_velocity - velocity).array().abs() <= l.acceleration_rad_s2.array() * dt * 1.001).all());
      last = reference;
      velocity = next_velocity;
    }
    EXPECT_LT((last - stop).cwiseAbs().maxCoeff(), rounding) << beyond_deg;
  }
}

TEST(JointLimiter, StartsFromJointsThatAreNotFinite) {
  JointLimiter limiter(limits());
  const HeadJointVector nan = all(std::numeric_limits<double>::quiet_NaN());
  const JointLimiter::Result result = limiter.apply(nan, nan, dt);
  EXPECT_TRUE(result.reference_rad.allFinite());
}

TEST(AllowedVelocity, AlwaysAllowsToStopBeforeALimit) {
  // Takes the fastest allowed velocity every step, both ways, at several periods.
  const MotionLimits l = limits();
  for (const double step_s : {0.5e-3, 1e-3, 7e-3, 20e-3}) {
    for (int joint = 0; joint < head_joint_count; ++joint) {
      for (const bool up : {true, false}) {
        double q = 0.5 * (l.min_rad[joint] + l.max_rad[joint]);
        double v = 0.0;
        for (int i = 0; i < 4000; ++i) {
          const VelocityRange range = allowed_velocity(l, joint, q, v, step_s);
          ASSERT_LE(range.min, range.max);
          const double next = up ? range.max : range.min;
          ASSERT_LE(std::abs(next - v), l.acceleration_rad_s2[joint] * step_s * (1.0 + 1e-6));
          ASSERT_LE(std::abs(next), l.speed_rad_s[joint]);
          v = next;
          q += v * step_s;
          ASSERT_GE(q, l.min_rad[joint] - rounding);
          ASSERT_LE(q, l.max_rad[joint] + rounding);
        }
        EXPECT_NEAR(q, up ? l.max_rad[joint] : l.min_rad[joint], 1e-6);
      }
    }
  }
}

TEST(MotionLimits, StayInsideTheHardwareAndKeepItsSpeeds) {
  JointLimits hardware = genova02_limits();
  hardware.max_speed_rad_s[neck_yaw] = 0.1;
  const MotionLimits l = motion_limits(hardware, {});
  EXPECT_EQ(l.speed_rad_s[neck_yaw - torso_joint_count], 0.1);
  EXPECT_NEAR(l.max_rad[0], 16.95 * rad_per_deg, 1e-12);
  EXPECT_NEAR(l.min_rad[0], -29.95 * rad_per_deg, 1e-12);
  EXPECT_NEAR(l.speed_rad_s[0], 80.0 * rad_per_deg, 1e-12);
  EXPECT_NEAR(l.speed_rad_s[3], 350.0 * rad_per_deg, 1e-12);
}

TEST(MotionLimits, ARangeThatIsEmptyOrNotANumberIsAnInputError) {
  JointLimits hardware = genova02_limits();
  hardware.max_rad[neck_roll] = hardware.min_rad[neck_roll] + 0.05 * rad_per_deg;
  hardware.min_rad[eyes_tilt] = std::numeric_limits<double>::quiet_NaN();
  try {
    (void)motion_limits(hardware, {});
    FAIL() << "taken";
  } catch (const InputError& error) {
    ASSERT_EQ(error.problems().size(), 2u);
    EXPECT_NE(error.problems()[0].place.find("neck_roll"), std::string::npos);
  }
  MotionLimitsConfig config;
  config.eye_speed_deg_s = 0.0;
  EXPECT_THROW((void)motion_limits(genova02_limits(), config), InputError);
}

}  // namespace
}  // namespace saccade
