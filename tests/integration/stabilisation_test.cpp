#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <optional>
#include <vector>

#include "control/controller_registry.h"
#include "control/delay_compensation.h"
#include "control/head_kinematics.h"
#include "control/joint_limiter.h"
#include "control/qp_controller.h"
#include "control/stabilisation.h"
#include "core/camera.h"
#include "core/random.h"
#include "core/units.h"
#include "head/icub_cameras.h"
#include "sim/world.h"

/// Gaze stabilisation on the simulated plant, without images: torso or base oscillate while the head looks at a ball. The
/// input of the controllers is the centre of the ball in the true camera 8 ms ago, with an error of 0.3 px.

namespace saccade {
namespace {

constexpr double tick_s = 1e-3;
constexpr std::size_t begin_ticks = 3000;
constexpr std::size_t sight_ticks = 8;

enum class Carrier { torso, base };

struct Sway {
  Carrier carrier = Carrier::torso;
  double frequency_hz = 1.0;
  double amplitude_deg = 5.0;
  bool pitch = false;  ///< instead of yaw
  const char* controller = "qp";
  StabilisationConfig stabilisation;
  bool compensated = false;  ///< whether the delay of the eyes is estimated and compensated
  bool looks = true;         ///< false: the head does not move
  TrajectoryConfig ball;
};

struct Seen {
  std::complex<double> line_deg;  ///< of the ball's bearing in the eye, at the frequency of the sway
  double on_target = 0.0;
  double slip_px_s[2] = {0.0, 0.0};  ///< motion of the ball's image over 10 ms: median, 90 %
};

TrajectoryConfig resting_ball() {
  TrajectoryConfig ball;
  ball.points_m = {{-0.506, 0.0, 0.347}};
  ball.sway_m = 0.0;
  return ball;
}

Seen watch_sway(const Sway& sway) {
  WorldConfig config;
  config.ball.trajectory = sway.ball;
  config.imu = ImuConfig{};
  BodyMotionConfig motion;
  motion.start_s = 1.0;
  (sway.pitch ? motion.pitch : motion.yaw) = {sway.amplitude_deg, sway.frequency_hz, 0.0};
  (sway.carrier == Carrier::torso ? config.torso : config.base) = motion;
  World world(config, "", 1);
  GazeControllerConfig gaze = built_in_controllers().config();
  gaze.controller = sway.controller;
  gaze.get<QpConfig>().predict_motion = false;  // which would cancel a periodic sway too
  const auto controller = make_gaze_controller(gaze, world.limits());
  JointLimiter limiter(motion_limits(world.limits(), gaze.limits));
  Stabiliser stabiliser(sway.stabilisation, world.limits().head);
  MotionDelayEstimator delay;
  const RandomStream random(3, "test/sway");
  const double px_m = 0.3 / icub_left_2016.fx_px;
  // Whole periods, and at least 5 s.
  const auto watched =
      static_cast<std::size_t>(std::lround(std::ceil(5.0 * sway.frequency_hz) / sway.frequency_hz / tick_s));
  std::vector<Eigen::Vector3d> balls_m;       // in the camera, every tick
  std::vector<Eigen::Vector2d> bearings_deg;  // to the right, down
  for (std::size_t tick = 0; tick < begin_ticks + watched; ++tick) {
    world.step();
    const HeadState state = world.head_state();
    Eigen::Vector3d ball_m = world.root_from_left_cam().inverse() * world.target_position_m();
    bearings_deg.emplace_back(std::atan2(ball_m.x(), ball_m.z()) / rad_per_deg,
                              std::atan2(ball_m.y(), ball_m.z()) / rad_per_deg);
    ball_m.head<2>() += px_m * ball_m.z() * Eigen::Vector2d(random.normal(0, tick), random.normal(1, tick));
    balls_m.push_back(ball_m);
    std::optional<Eigen::Vector3d> target;
    if (sway.looks && tick > 500)
      target =
          camera_motion(world.limits().head->chain, state).root_from_camera * balls_m[tick - sight_ticks];
    const double eyes_s = sway.compensated ? delay.eyes_s() : 0.0;
    if (sway.compensated) controller->set_delays({0.0, delay.neck_s(), eyes_s});
    controller->set_body_rates(stabiliser.update(state, world.imu_reading(), eyes_s, tick_s));
    const HeadJointVector wanted = controller->step(state, target, tick_s);
    const HeadJointVector reference = limiter.apply(wanted, state.head_position_rad(), tick_s).reference_rad;
    EXPECT_TRUE(world.set_reference(reference));
    delay.update(state.head_position_rad(), reference, tick_s);
  }
  Seen seen;
  std::vector<double> slips_px_s;
  const double n = static_cast<double>(watched);
  for (std::size_t i = begin_ticks; i < bearings_deg.size(); ++i) {
    const double angle = 2.0 * std::numbers::pi * sway.frequency_hz * static_cast<double>(i) * tick_s;
    seen.line_deg += 2.0 / n * bearings_deg[i][sway.pitch ? 1 : 0] * std::polar(1.0, -angle);
    seen.on_target += (bearings_deg[i].norm() < 2.0) / n;
    slips_px_s.push_back((bearings_deg[i] - bearings_deg[i - 10]).norm() * rad_per_deg *
                         icub_left_2016.fx_px / (10.0 * tick_s));
  }
  std::ranges::sort(slips_px_s);
  seen.slip_px_s[0] = slips_px_s[watched / 2];
  seen.slip_px_s[1] = slips_px_s[9 * watched / 10];
  return seen;
}

/// The share of the image's motion that the eyes do not cancel. Prints a row of the table in docs/oculomotor.md.
double motion_left(Sway sway, const char* name) {
  sway.ball = resting_ball();
  sway.amplitude_deg = 20.0 / (2.0 * std::numbers::pi * sway.frequency_hz);  // 20 deg/s
  const Seen seen = watch_sway(sway);
  sway.looks = false;
  sway.controller = "qp";
  sway.stabilisation = {};
  const std::complex<double> gain = 1.0 - seen.line_deg / watch_sway(sway).line_deg;
  std::printf("| %s | %g | %s | %.2f | %.0f | %.3f | %.0f, %.0f |\n",
              sway.carrier == Carrier::torso ? "torso" : "base", sway.frequency_hz, name, std::abs(gain),
              std::arg(gain) / rad_per_deg, std::abs(1.0 - gain), seen.slip_px_s[0], seen.slip_px_s[1]);
  return std::abs(1.0 - gain);
}

TEST(GazeStabilisation, TorsoAndGyroscopeCancelASwayUpToTwoHertz) {
  for (const double hz : {0.2, 0.5, 1.0, 2.0, 4.0}) {
    const auto left = [&](const char* controller, bool torso, bool gyroscope, bool compensated,
                          const char* name) {
      Sway sway;
      sway.frequency_hz = hz;
      sway.controller = controller;
      sway.stabilisation = {torso, gyroscope};
      sway.compensated = compensated;
      return motion_left(sway, name);
    };
    const double off = left("qp", false, false, false, "qp, off");
    const double torso = left("qp", true, false, false, "qp, torso");
    const double gyroscope = left("qp", false, true, false, "qp, gyroscope");
    const double both = left("qp", true, true, false, "qp, both");
    EXPECT_LT(torso, 0.3 * off);
    EXPECT_LT(gyroscope, 0.3 * off);
    EXPECT_LT(both, std::min(0.3 * off, hz <= 2.0 ? 0.1 : 1.0));
    EXPECT_LT(left("qp", true, true, true, "qp, both, delay compensated"), 0.1);
    const double ikingaze_off = left("ikingaze", false, false, false, "ikingaze, off");
    EXPECT_LT(left("ikingaze", true, false, false, "ikingaze, torso"), 0.5 * ikingaze_off);
    left("ikingaze", false, true, false, "ikingaze, gyroscope");
  }
}

TEST(GazeStabilisation, TheGyroscopeCancelsASwayOfTheBaseThatNoEncoderMeasures) {
  for (const double hz : {1.0, 2.0, 4.0}) {
    Sway sway;
    sway.carrier = Carrier::base;
    sway.frequency_hz = hz;
    const double off = motion_left(sway, "qp, off");
    sway.stabilisation.gyroscope = true;
    EXPECT_LT(motion_left(sway, "qp, gyroscope"), 0.3 * off);
  }
}

TEST(GazeStabilisation, TheGazeStaysOnTheSquareWhileTheTorsoSways) {
  Sway sway;
  sway.ball.kind = TrajectoryKind::waypoints;
  sway.ball.points_m = {
      {-0.506, -0.13, 0.25}, {-0.506, -0.13, 0.45}, {-0.506, 0.13, 0.45}, {-0.506, 0.13, 0.25}};
  sway.ball.profile = SpeedProfile::constant_speed;
  sway.ball.dwell_s = 0.3;
  for (const double hz : {0.5, 1.0}) {
    for (const bool pitch : {false, true}) {
      sway.frequency_hz = hz;
      sway.pitch = pitch;
      sway.stabilisation = {};
      const Seen off = watch_sway(sway);
      sway.stabilisation = {true, false};
      const Seen torso = watch_sway(sway);
      sway.stabilisation = {false, true};
      const Seen gyroscope = watch_sway(sway);
      std::printf(
          "square, %s %g Hz: on target %.3f off, %.3f torso, %.3f gyroscope; image motion %.0f, %.0f, %.0f "
          "px/s\n",
          pitch ? "pitch" : "yaw", hz, off.on_target, torso.on_target, gyroscope.on_target, off.slip_px_s[0],
          torso.slip_px_s[0], gyroscope.slip_px_s[0]);
      EXPECT_GE(torso.on_target, 0.95);
      EXPECT_GE(gyroscope.on_target, 0.95);
    }
  }
}

}  // namespace
}  // namespace saccade
