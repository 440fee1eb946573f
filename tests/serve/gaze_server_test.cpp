#include "apps/serve/gaze_server.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "control/head_kinematics.h"
#include "core/random.h"
#include "head/icub_cameras.h"
#include "tests/control/genova02.h"

namespace saccade {
namespace {

/// A head that reaches each reference within one tick.
class Head {
 public:
  void run(double duration_s) {
    constexpr double dt_s = 0.001;
    for (int i = 0; i < std::lround(duration_s / dt_s); ++i) {
      const auto reference_rad = server.step(state, dt_s);
      state.velocity_rad_s.setZero();
      if (!reference_rad) continue;
      state.velocity_rad_s.tail<gaze_slots>() = (*reference_rad - state.head_position_rad()) / dt_s;
      state.position_rad.tail<gaze_slots>() = *reference_rad;
    }
  }
  [[nodiscard]] double miss_deg(Eye eye, const Eigen::Vector3d& point_m) const {
    const Eigen::Vector3d seen =
        HeadKinematics(default_head()->chain, state.position_rad).root_from_eye(eye).inverse() * point_m;
    return std::atan2(seen.head<2>().norm(), seen.z()) / rad_per_deg;
  }
  /// The numbers of a reply `[ack] (...)`.
  [[nodiscard]] std::vector<double> ask(const std::string& request) {
    std::string reply = server.answer(request);
    EXPECT_TRUE(reply.starts_with("[ack]")) << request << ": " << reply;
    reply.erase(0, 5);
    std::ranges::replace_if(
        reply, [](char c) { return c == '(' || c == ')'; }, ' ');
    std::istringstream stream(reply);
    std::vector<double> values;
    for (double value; stream >> value;) values.push_back(value);
    return values;
  }

  HeadState state;
  GazeServer server{{}, {}, genova02_limits(), icub_left_2016, icub_left_2016, JointVector::Zero()};
};

TEST(GazeServer, DoesNotMoveTheHeadBeforeTheFirstTarget) {
  Head head;
  EXPECT_FALSE(head.server.step(head.state, 0.001));
  EXPECT_EQ(head.server.answer("set Tneck 0.8"), "[ack]");
  EXPECT_FALSE(head.server.step(head.state, 0.001));
}

TEST(GazeServer, LooksAtAPointWithBothEyes) {
  Head head;
  const Eigen::Vector3d point_m(-0.5, 0.1, 0.4);
  EXPECT_EQ(head.server.answer("look 3D (-0.5 0.1 0.4)"), "[ack]");
  EXPECT_EQ(head.ask("get done"), std::vector{1.0});  // not stepped yet
  head.run(0.1);
  EXPECT_EQ(head.ask("get done"), std::vector{0.0});
  head.run(3.0);
  std::printf("misses: left %.4f, right %.4f deg\n", head.miss_deg(Eye::left, point_m),
              head.miss_deg(Eye::right, point_m));
  EXPECT_LT(head.miss_deg(Eye::left, point_m), 0.1);
  EXPECT_LT(head.miss_deg(Eye::right, point_m), 0.1);
  EXPECT_EQ(head.ask("get done"), std::vector{1.0});
  EXPECT_THAT(head.ask("get x"), testing::Pointwise(testing::DoubleNear(1e-3), {-0.5, 0.1, 0.4}));
}

TEST(GazeServer, ReportsTheStartAndTheEndOfAMovement) {
  Head head;
  EXPECT_EQ(head.server.answer("look 3D -0.5 0.1 0.4"), "[ack]");
  head.run(3.0);
  EXPECT_THAT(head.server.report().events,
              testing::ElementsAre("motion-onset", "saccade-onset", "saccade-done", "motion-done"));
  EXPECT_TRUE(head.server.report().events.empty());
}

TEST(GazeServer, HoldsTheHeadAfterAStop) {
  Head head;
  EXPECT_EQ(head.server.answer("look 3D (-0.5 0.2 0.4)"), "[ack]");
  head.run(0.3);
  const JointVector there = head.state.position_rad;
  EXPECT_EQ(head.server.answer("stop"), "[ack]");
  head.run(0.5);
  EXPECT_EQ(head.state.position_rad, there);
  EXPECT_EQ(head.server.answer("look 3D (-0.5 0.0 0.4)"), "[ack]");
  head.run(0.3);
  EXPECT_NE(head.state.position_rad, there);
}

TEST(GazeServer, AcceptsNoTargetWhileSuspended) {
  Head head;
  EXPECT_EQ(head.server.answer("susp"), "[ack]");
  EXPECT_EQ(head.server.answer("status"), "[ack] suspended");
  EXPECT_EQ(head.server.answer("look 3D (-0.5 0.2 0.4)"), "[nack]");
  EXPECT_EQ(head.server.answer("run"), "[ack]");
  EXPECT_EQ(head.server.answer("status"), "[ack] running");
  EXPECT_EQ(head.server.answer("look 3D (-0.5 0.2 0.4)"), "[ack]");
}

TEST(GazeServer, RejectsUnknownRequestsAndUnreachableTargets) {
  Head head;
  for (const char* request : {"",
                              "look",
                              "look 3D",
                              "look 3D (-0.5 0.1)",
                              "look 3D (-0.5 0.1 0.4 7)",
                              "look 3D (-0.5 nan 0.4)",
                              "look 3D (0.5 0 0.4)",
                              "look mono (up 64 64 0.4)",
                              "look mono (left 64 64 -1)",
                              "look ang (abs 1 2)",
                              "look ang (sideways 1 2 3)",
                              "get",
                              "get nothing",
                              "get 3D 3D (1 2 3)",
                              "set Tneck",
                              "set Tneck fast",
                              "set sinh -1",
                              "set nothing 1",
                              "bind roll 5",
                              "bind roll 5 -5",
                              "bind ears 0",
                              "clear ears",
                              "rest 9",
                              "del x",
                              "get ang (1 2)",
                              "register closing",
                              "quit",
                              "\"",
                              "((((",
                              "look 3D (1e999 0 0)"}) {
    EXPECT_EQ(head.server.answer(request), "[nack]") << request;
  }
  EXPECT_EQ(head.server.report().requests, 0);
  EXPECT_FALSE(head.server.step(head.state, 0.001));
}

TEST(GazeServer, ConvertsBetweenPixelsOfAnEyeAndPoints) {
  Head head;
  head.state.position_rad.head<joint_count>() << 0, 0, 0, 0.1, -0.05, 0.2, -0.1, 0.15, 0.12;
  head.run(0.001);
  const Camera camera = icub_left_2016;
  for (const char* eye : {"left", "right"}) {
    const auto pixel = head.ask(std::string("get 2D (") + eye + " -0.5 0.05 0.3)");
    const Eigen::Vector3d seen = HeadKinematics(default_head()->chain, head.state.position_rad)
                                     .root_from_eye(eye == std::string("left") ? Eye::left : Eye::right)
                                     .inverse() *
                                 Eigen::Vector3d(-0.5, 0.05, 0.3);
    std::ostringstream request;
    request.precision(12);
    request << "get 3D mono (" << eye << " " << pixel.at(0) << " " << pixel.at(1) << " " << seen.z() << ")";
    EXPECT_THAT(head.ask(request.str()), testing::Pointwise(testing::DoubleNear(1e-6), {-0.5, 0.05, 0.3}));
    EXPECT_NEAR(pixel.at(0), camera.fx_px * seen.x() / seen.z() + camera.cx_px, 1e-5);
  }
  const auto left = head.ask("get 2D (left -0.5 0.05 0.3)");
  const auto right = head.ask("get 2D (right -0.5 0.05 0.3)");
  std::ostringstream request;
  request.precision(12);
  request << "get 3D stereo (" << left[0] << " " << left[1] << " " << right[0] << " " << right[1] << ")";
  EXPECT_THAT(head.ask(request.str()), testing::Pointwise(testing::DoubleNear(1e-5), {-0.5, 0.05, 0.3}));
}

TEST(GazeServer, AnglesCountToTheRightAndUpFromTheHeadAtRest) {
  Head head;
  const auto ahead = head.ask("get 3D ang (abs 0 0 8)");
  const auto aside = head.ask("get 3D ang (abs 20 0 8)");
  const auto above = head.ask("get 3D ang (abs 0 10 8)");
  EXPECT_GT(aside[1], ahead[1] + 0.1);  // y is to the right
  EXPECT_GT(above[2], ahead[2] + 0.05);
  EXPECT_EQ(head.server.answer("look ang (abs 20 10 8)"), "[ack]");
  head.run(3.0);
  EXPECT_THAT(head.ask("get angles"), testing::Pointwise(testing::DoubleNear(0.7), {20.0, 10.0, 8.0}));
  EXPECT_EQ(head.server.answer("look ang (rel -5 0 0)"), "[ack]");
  head.run(3.0);
  EXPECT_THAT(head.ask("get angles"), testing::Pointwise(testing::DoubleNear(0.9), {15.0, 10.0, 8.0}));
}

TEST(GazeServer, TheAnglesOfAPointAreThoseOfItsLookRequest) {
  Head head;
  for (const char* angles : {"0 0 8", "20 0 8", "0 10 4", "-15 0 8"}) {
    const auto point_m = head.ask(fmt::format("get 3D ang (abs {})", angles));
    const auto found = head.ask(fmt::format("get ang ({})", fmt::join(point_m, " ")));
    const auto wanted = head.ask(fmt::format("get 3D ang (abs {})", fmt::join(found, " ")));
    EXPECT_THAT(wanted, testing::Pointwise(testing::DoubleNear(1e-6), point_m)) << angles;
  }
  // iKin's elevation is atan2(y, |z|), here of a direction 20 deg aside.
  const auto aside = head.ask("get 3D ang (abs 20 10 8)");
  const auto found = head.ask(fmt::format("get ang ({})", fmt::join(aside, " ")));
  EXPECT_NEAR(found[0], 20.0, 1e-6);
  EXPECT_NEAR(std::tan(found[1] * rad_per_deg), std::tan(10 * rad_per_deg) / std::cos(20 * rad_per_deg),
              1e-8);
}

TEST(GazeServer, ReportsWhatIKinGazeCtrlReports) {
  Head head;
  std::vector<std::string> events;
  const auto collect = [&] {
    for (std::string& event : head.server.report().events) events.push_back(std::move(event));
  };
  EXPECT_EQ(head.server.answer("look 3D (-0.4 0.3 0.25)"), "[ack]");
  head.run(3.0);
  collect();
  EXPECT_EQ(head.server.answer("susp"), "[ack]");
  EXPECT_EQ(head.server.answer("susp"), "[ack]");
  EXPECT_EQ(head.server.answer("run"), "[ack]");
  collect();
  EXPECT_THAT(events,
              testing::IsSupersetOf({"motion-onset", "saccade-onset", "saccade-done", "motion-done"}));
  EXPECT_EQ(std::ranges::count(events, "saccade-onset"), std::ranges::count(events, "saccade-done"));
  EXPECT_EQ(std::ranges::count(events, "suspended"), 1);
  EXPECT_EQ(events.back(), "resumed");
}

TEST(GazeServer, KeepsABoundJointInItsRange) {
  Head head;
  EXPECT_EQ(head.server.answer("bind roll 0 0"), "[ack]");
  EXPECT_EQ(head.server.answer("bind yaw -5 5"), "[ack]");
  EXPECT_THAT(head.ask("get yaw"), testing::Pointwise(testing::DoubleNear(1e-6), {-5.0, 5.0}));
  EXPECT_EQ(head.server.answer("look 3D (-0.4 0.25 0.25)"), "[ack]");
  head.run(3.0);
  EXPECT_LT(std::abs(head.state.position_rad[neck_roll]), 0.11 * rad_per_deg);
  EXPECT_LT(std::abs(head.state.position_rad[neck_yaw]), 5.0 * rad_per_deg);
  EXPECT_EQ(head.server.answer("clear yaw"), "[ack]");
  EXPECT_EQ(head.server.answer("look 3D (-0.4 0.25 0.25)"), "[ack]");
  head.run(3.0);
  EXPECT_GT(std::abs(head.state.position_rad[neck_yaw]), 10.0 * rad_per_deg);
}

TEST(GazeServer, SettingsAreReturnedStoredAndRestored) {
  Head head;
  EXPECT_EQ(head.server.answer("set Teyes 0.01"), "[ack]");
  EXPECT_EQ(head.ask("get Teyes"), std::vector{0.1});  // as fast as iKinGazeCtrl lets it be
  EXPECT_EQ(head.server.answer("set Tneck 0.8"), "[ack]");
  EXPECT_EQ(head.server.answer("set sacc 0"), "[ack]");
  EXPECT_EQ(head.server.answer("set track 1"), "[ack]");
  const auto id = head.ask("stor");
  EXPECT_EQ(head.server.answer("set Tneck 1.2"), "[ack]");
  EXPECT_EQ(head.ask("get Tneck"), std::vector{1.2});
  EXPECT_EQ(head.server.answer("rest " + std::to_string(static_cast<int>(id.at(0)))), "[ack]");
  EXPECT_EQ(head.ask("get Tneck"), std::vector{0.8});
  EXPECT_EQ(head.ask("get sacc"), std::vector{0.0});
  EXPECT_EQ(head.ask("get track"), std::vector{1.0});
}

TEST(GazeServer, ASettingDoesNotMakeTheReferenceJump) {
  Head head;
  EXPECT_EQ(head.server.answer("look 3D (-0.5 0.2 0.4)"), "[ack]");
  head.run(0.2);
  const JointVector there = head.state.position_rad;
  EXPECT_EQ(head.server.answer("bind pitch -1 1"), "[ack]");
  head.run(0.002);
  EXPECT_LT((head.state.position_rad - there).cwiseAbs().maxCoeff(), 1.0 * rad_per_deg);
}

TEST(GazeServer, AnswersTheRequestsOfAClientOfIKinGazeCtrl) {
  Head head;
  EXPECT_EQ(head.server.answer("stor"), "[ack] 1");
  EXPECT_EQ(head.server.answer("del 1"), "[ack]");
  EXPECT_EQ(head.server.answer("dele 1"), "[nack]") << "nobody sends that";
  EXPECT_EQ(head.server.answer("bind pitch -5 10"), "[ack]");
  EXPECT_EQ(head.server.answer("get pitch"), "[ack] -5 10") << "two values, not a list";
  EXPECT_EQ(head.server.answer("register motion-onset"), "[ack]");
  EXPECT_EQ(head.server.answer("list"), "[ack] (motion-onset)");
  EXPECT_EQ(head.server.answer("unregister motion-onset"), "[ack]");
  EXPECT_EQ(head.server.answer("register nonsense"), "[nack]");
  EXPECT_EQ(head.server.answer("rest 0"), "[ack]") << "the settings of the start";
  EXPECT_EQ(head.server.answer("del (1 2)"), "[ack]") << "unknown ones too";
  EXPECT_EQ(head.server.answer("del 0"), "[ack]");
  EXPECT_EQ(head.server.answer("rest 0"), "[ack]");
  EXPECT_EQ(head.ask("get q").size(), 9u) << "torso and head";
  for (const char* request : {"get des", "get vel"})
    EXPECT_EQ(head.ask(request).size(), 6u) << request << ": the head alone";
  EXPECT_EQ(head.ask("get ang").size(), 3u);
  EXPECT_EQ(head.ask("get sdon"), std::vector{1.0});
  EXPECT_EQ(head.server.answer("get pid"), "[ack] ()");
  // iKinGazeCtrl's client compares the version as text and ends if it is another one, or a number.
  EXPECT_THAT(head.server.answer("get info"), testing::HasSubstr("(server_version \"2.0\")"));
  EXPECT_THAT(head.server.answer("get info"), testing::HasSubstr("(head_version \"2.0\")"));
  for (const char* request : {"get info", "get tweak"}) {
    EXPECT_THAT(
        head.server.answer(request),
        testing::HasSubstr("(camera_intrinsics_right (99.45 0.0 64 0.0 0.0 99.75 69.18 0.0 0.0 0.0 1.0 0.0)) "
                           "(camera_width_right 128) (camera_height_right 128)"));
  }
}

TEST(GazeServer, TakesTheIntrinsicsThatItReports) {
  Head head;
  EXPECT_EQ(head.server.answer("set tweak (" + head.server.answer("get tweak").substr(6) + ")"), "[ack]");
  EXPECT_EQ(head.server.answer("set tweak ((camera_intrinsics_left (200 0 60 0 0 210 65 0 0 0 1 0)))"),
            "[ack]");
  EXPECT_THAT(head.server.answer("get tweak"),
              testing::HasSubstr("(camera_intrinsics_left (200 0.0 60 0.0 0.0 210 65 0.0"));
  for (const char* bad : {"camera_width_left 64", "camera_intrinsics_left (200 0 60)", "camera_left 1",
                          "camera_intrinsics_left (0 0 60 0 0 210 65 0 0 0 1 0)", "nonsense"})
    EXPECT_EQ(head.server.answer(std::string("set tweak (") + bad + ")"), "[nack]") << bad;
}

TEST(GazeServer, ReportsWhatJointsAreBoundTo) {
  Head head;
  EXPECT_EQ(head.server.answer("get eyes"), "[ack] -1");
  EXPECT_EQ(head.server.answer("bind eyes 6"), "[ack]");
  EXPECT_EQ(head.server.answer("get eyes"), "[ack] 6");
  EXPECT_EQ(head.server.answer("clear eyes"), "[ack]");
  EXPECT_EQ(head.server.answer("get eyes"), "[ack] -1");
  EXPECT_EQ(head.server.answer("bind pitch 3 3"), "[ack]");
  EXPECT_EQ(head.server.answer("get pitch"), "[ack] 3 3");
}

TEST(GazeServer, APixelAndAVergenceAreATarget) {
  Head head;
  EXPECT_EQ(head.server.answer("look mono (left 70 60 ver 8)"), "[ack]");
  EXPECT_EQ(head.server.answer("look mono (left 70 60 vor 8)"), "[nack]");
  const std::vector<double> eye = head.ask("get pose left");
  const auto distance_m = [&](const std::vector<double>& point) {
    return std::hypot(point.at(0) - eye[0], point.at(1) - eye[1], point.at(2) - eye[2]);
  };
  const double near_m = distance_m(head.ask("get 3D mono (left 64 69.18 ver 10)"));
  EXPECT_NEAR(near_m, 0.034 / std::tan(0.5 * 10 * rad_per_deg), 1e-3) << "eyes 68 mm apart";
  EXPECT_NEAR(distance_m(head.ask("get 3D mono (left 64 69.18 ver 5)")) / near_m, 2.0, 0.01);
}

TEST(GazeServer, ProjectsAPixelOntoAPlane) {
  Head head;
  const std::vector<double> met = head.ask("get 3D proj (left 64 69.18 1 0 0 0.6)");
  ASSERT_EQ(met.size(), 3u);
  EXPECT_NEAR(met[0], -0.6, 1e-6) << "on the plane x = -0.6";
  EXPECT_EQ(head.server.answer("get 3D proj (left 64 69.18 1 0 0 -0.6)"), "[nack]") << "behind the head";
}

TEST(GazeServer, AtRestTheFixationPointIsADistantOneAhead) {
  Head head;
  const std::vector<double> x = head.ask("get x");
  ASSERT_EQ(x.size(), 3u);
  EXPECT_LT(x[0], -2.0);
  EXPECT_NEAR(x[1], 0.0, 0.05);
}

/// The version of the eyes, deg, after half a second in which the gyroscope measures `left_deg_s` about the vertical axis while
/// the head does not move and a target lies straight ahead; `requests` come first.
double version_deg(double left_deg_s, const std::vector<std::string>& requests, bool has_imu = true,
                   std::int64_t age_us = 0) {
  Head head;
  GazeServer server({}, {}, genova02_limits(), icub_left_2016, icub_left_2016, JointVector::Zero(), has_imu);
  for (const std::string& request : requests) EXPECT_EQ(server.answer(request), "[ack]");
  EXPECT_EQ(server.answer("look 3D (-0.556 0 0.347)"), "[ack]");
  ImuReading imu;
  imu.angular_velocity_rad_s = {0.0, 0.0, left_deg_s * rad_per_deg};
  for (int i = 0; i < 500; ++i) {
    head.state.t_us = 1000 * i;
    imu.t_us = head.state.t_us - age_us;
    const auto reference_rad = server.step(head.state, 0.001, &imu);
    if (!reference_rad) continue;
    head.state.position_rad.tail<gaze_slots>() = *reference_rad;
    head.state.position_rad.segment<3>(neck_pitch).setZero();
  }
  return head.state.position_rad[eyes_version] / rad_per_deg;
}

TEST(GazeServer, VorTurnsTheEyesAgainstWhatTheGyroscopeMeasures) {
  // The target pulls the eyes back: their reference at 12.5/s, the eyes to the reference at 7.1/s, so that 20 deg/s hold them
  // 1.6 + 2.8 deg to the right.
  const double right_deg = version_deg(20.0, {});
  EXPECT_GT(right_deg, 1.5);
  EXPECT_LT(right_deg, 6.0);
  EXPECT_NEAR(version_deg(-20.0, {}), -right_deg, 0.3);
  EXPECT_NEAR(version_deg(20.0, {"set vor 0.5"}), 0.5 * right_deg, 0.3);
}

TEST(GazeServer, VorIgnoresSlowTurnsOldReadingsAndHeadsWithoutASensor) {
  EXPECT_NEAR(version_deg(4.9, {}), 0.0, 0.05);
  EXPECT_NEAR(version_deg(20.0, {}, true, 41'000), 0.0, 0.05);
  EXPECT_NEAR(version_deg(20.0, {}, false), 0.0, 0.05);
  EXPECT_NEAR(version_deg(20.0, {"set vor 0"}), 0.0, 0.05);
}

TEST(GazeServer, OcrIsTheShareOfTheNecksMotionThatTheEyesCompensate) {
  // The largest gaze error while the neck follows to a target 15 deg to the left, from when the eyes have arrived.
  const auto worst_deg = [](const char* request) {
    Head head;
    EXPECT_EQ(head.server.answer(request), "[ack]");
    const Eigen::Vector3d target_m(-0.49, -0.116, 0.347);
    EXPECT_EQ(head.server.answer("look 3D (-0.49 -0.116 0.347)"), "[ack]");
    double worst = 0.0;
    for (int i = 0; i < 200; ++i) {
      head.run(0.01);
      if (i > 40) worst = std::max(worst, head.miss_deg(Eye::left, target_m));
    }
    return worst;
  };
  EXPECT_GT(worst_deg("set ocr 0"), 1.5 * worst_deg("set ocr 1"));
}

TEST(GazeServer, VorAndOcrBeginWithOneAndZeroOnAHeadWithAnInertialSensor) {
  GazeServer with({}, {}, genova02_limits(), icub_left_2016, icub_left_2016, JointVector::Zero(), true);
  EXPECT_EQ(with.answer("get vor"), "[ack] 1");
  EXPECT_EQ(with.answer("get ocr"), "[ack] 0");
  GazeServer without({}, {}, genova02_limits(), icub_left_2016, icub_left_2016, JointVector::Zero());
  EXPECT_EQ(without.answer("get vor"), "[ack] 0");
  EXPECT_EQ(without.answer("get ocr"), "[ack] 1");
}

TEST(GazeServer, RequestsWithNumbersOfEveryMagnitudeAreAnsweredAndLeaveAHeadThatFollows) {
  Head head;
  EXPECT_EQ(head.server.answer("look 3D (-1e300 0 0.3)"), "[nack]");
  EXPECT_EQ(head.server.answer("look 3D (-1001 0 0.3)"), "[nack]");
  EXPECT_EQ(head.server.answer("look 3D (-900 0 0.3)"), "[ack]");
  EXPECT_EQ(head.server.answer("set vor 1e300"), "[nack]");
  const RandomStream random(1, "requests of every magnitude");
  std::uint64_t count = 0;
  const auto number = [&]() -> std::string {
    constexpr std::array awkward = {"-1e300", "1e300", "1e-300", "4.9e-324", "-0",     "0",
                                    "nan",    "inf",   "-inf",   "1e154",    "1",      "-1",
                                    "0.3",    "-0.5",  "99",     "1e9999",   "1e-9999"};
    const std::uint64_t bits = random.bits(0, ++count);
    if (bits % 2 == 0) return awkward[random.bits(1, count) % awkward.size()];
    std::ostringstream text;
    text << (bits % 3 == 0 ? std::bit_cast<double>(random.bits(2, count))
                           : random.uniform(-1.0, 1.0, 3, count));
    return text.str();
  };
  struct Form {
    const char* words;
    int numbers;
  };
  constexpr std::array forms = {Form{"look 3D", 3},
                                Form{"look mono left", 3},
                                Form{"look mono right", 3},
                                Form{"look stereo", 4},
                                Form{"look ang abs", 3},
                                Form{"look ang rel", 3},
                                Form{"get 2D left", 3},
                                Form{"get 3D proj left", 6},
                                Form{"get 3D mono left", 3},
                                Form{"get 3D ang abs", 3},
                                Form{"set Tneck", 1},
                                Form{"set Teyes", 1},
                                Form{"set sact", 1},
                                Form{"set sinh", 1},
                                Form{"set vor", 1},
                                Form{"set ocr", 1},
                                Form{"set track", 1},
                                Form{"bind pitch", 2},
                                Form{"bind yaw", 2},
                                Form{"bind eyes", 1},
                                Form{"clear pitch", 0},
                                Form{"clear eyes", 0},
                                Form{"stor", 0},
                                Form{"rest", 1},
                                Form{"set tweak camera_intrinsics_left", 12}};
  const JointLimits limits = genova02_limits();
  for (int i = 0; i < 4000 && !testing::Test::HasFailure(); ++i) {
    const Form& form = forms[random.bits(4, static_cast<std::uint64_t>(i)) % forms.size()];
    std::string request = form.words;
    for (int k = 0; k < form.numbers; ++k) request += " " + number();
    const std::string reply = head.server.answer(request);
    EXPECT_TRUE(reply.starts_with("[ack]") || reply == "[nack]") << request << ": " << reply;
    EXPECT_EQ(reply.find("nan"), std::string::npos) << request << ": " << reply;
    EXPECT_EQ(reply.find("inf"), std::string::npos) << request << ": " << reply;
    head.run(0.02);
    for (int j = torso_slots; j < torso_slots + head_joint_count; ++j) {
      EXPECT_TRUE(head.state.position_rad[j] >= limits.min_rad[j] - 1e-9 &&
                  head.state.position_rad[j] <= limits.max_rad[j] + 1e-9)
          << request << ": " << head.state.position_rad.transpose();
    }
  }
  for (const char* request :
       {"clear pitch", "clear roll", "clear yaw", "clear eyes", "set Tneck 0.75", "set Teyes 0.25",
        "set vor 0", "set ocr 1", "set sacc 1", "set sact 10", "set sinh 0.2", "run"})
    EXPECT_EQ(head.server.answer(request), "[ack]") << request;
  EXPECT_EQ(head.server.answer("look 3D (-0.5 0.1 0.4)"), "[ack]");
  head.run(6.0);
  EXPECT_LT(head.miss_deg(Eye::left, {-0.5, 0.1, 0.4}), 0.2);
}

}  // namespace
}  // namespace saccade
