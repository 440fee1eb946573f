#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <iostream>
#include <optional>
#include <vector>

#include "control/controller_registry.h"
#include "control/delay_compensation.h"
#include "control/head_kinematics.h"
#include "control/hunting_detector.h"
#include "control/joint_limiter.h"
#include "control/qp_controller.h"
#include "core/camera.h"
#include "core/random.h"
#include "core/units.h"
#include "head/icub_cameras.h"
#include "sim/world.h"

/// Pursuit with the controller `qp` on the simulated plant, without images. The input is that of a tracker: the centre of
/// the ball in the true camera some time ago, with an error of 0.3 px and 10 mm in depth.

namespace saccade {
namespace {

constexpr double step_s = 1e-3;
constexpr std::uint64_t run_ticks = 6000;
constexpr std::uint64_t settled_ticks = 2500;

struct Pursuit {
  double frequency_hz = 1.0;  ///< of the ball on a circle of 7 cm at 45 cm; 0: it rests
  PlantConfig plant;
  std::size_t sight_ms = 8;
  bool compensated = false;  ///< sight is known, motion estimated
  bool hunting = false;      ///< whether hunting is detected
  QpConfig qp;
};

struct Followed {
  double on_target = 0.0;   ///< share of the time within 2 deg, after 2.5 s
  double median_deg = 0.0;  ///< of the error
  double slowdown = 1.0;
};

PlantConfig mismatched() {
  PlantConfig plant;
  plant.axes = NeckAxes::cad;
  plant.encoders.noise_deg = 0.02;
  plant.encoders.quantisation_deg = 0.088;
  plant.command_delay_ms = 20;
  plant.neck = {0.05, 0.5};
  plant.eyes = {0.05, 0.3};
  return plant;
}

TrajectoryConfig circle_of(double frequency_hz) {
  TrajectoryConfig ball;
  if (frequency_hz == 0.0) {
    ball.points_m = {{-0.506, -0.10, 0.27}};
    ball.sway_m = 0.0;
    return ball;
  }
  ball.kind = TrajectoryKind::circle;
  ball.centre_m = {-0.506, 0.0, 0.347};
  ball.radius_a_m = {0.0, -0.07, 0.0};
  ball.radius_b_m = {0.0, 0.0, 0.07};
  ball.frequency_hz = frequency_hz;
  ball.start_s = 0.5;
  ball.ramp_s = 0.5;
  return ball;
}

Followed pursue(const Pursuit& pursuit, const char* what) {
  WorldConfig config;
  config.plant = pursuit.plant;
  config.ball.trajectory = circle_of(pursuit.frequency_hz);
  World world(config, "", 1);
  GazeControllerConfig gaze = built_in_controllers().config();
  gaze.get<QpConfig>() = pursuit.qp;
  const auto controller = make_gaze_controller(gaze, world.limits());
  JointLimiter limiter(motion_limits(world.limits(), gaze.limits));
  MotionDelayEstimator delay;
  HuntingDetector hunting;
  const RandomStream random(3, "test/pursuit");
  const double px_m = 0.3 / icub_left_2016.fx_px;
  struct Sight {
    Eigen::Vector3d ball_m;  // in the camera
    Eigen::Isometry3d root_from_camera;
  };
  std::deque<Sight> sights;
  std::vector<double> errors_deg;
  Followed followed;
  for (std::uint64_t tick = 0; tick < run_ticks; ++tick) {
    world.step();
    const HeadState state = world.head_state();
    Eigen::Vector3d ball_m = world.root_from_left_cam().inverse() * world.target_position_m();
    if (tick >= settled_ticks)
      errors_deg.push_back(std::atan2(ball_m.head<2>().norm(), ball_m.z()) / rad_per_deg);
    ball_m *= 1.0 + 0.01 * random.normal(2, tick) / ball_m.norm();
    ball_m.head<2>() += px_m * ball_m.z() * Eigen::Vector2d(random.normal(0, tick), random.normal(1, tick));
    sights.push_back(
        {ball_m, HeadKinematics(default_head()->chain, state.position_rad).root_from_eye(Eye::left)});
    std::optional<Eigen::Vector3d> target;
    if (sights.size() > pursuit.sight_ms) {
      const Eigen::Isometry3d& pose =
          pursuit.compensated ? sights.front().root_from_camera : sights.back().root_from_camera;
      if (tick >= 500) target = pose * sights.front().ball_m;
      sights.pop_front();
    }
    if (pursuit.compensated)
      controller->set_delays({static_cast<double>(pursuit.sight_ms) * 1e-3, delay.neck_s(), delay.eyes_s()});
    const HeadJointVector wanted = controller->step(state, target, step_s);
    const HeadJointVector reference = limiter.apply(wanted, state.head_position_rad(), step_s).reference_rad;
    EXPECT_TRUE(world.set_reference(reference));
    delay.update(state.head_position_rad(), reference, step_s);
    if (!pursuit.hunting || !hunting.update(reference, step_s)) continue;
    followed.slowdown = std::min(4.0, 1.5 * followed.slowdown);
    controller->set_slowdown(followed.slowdown);
  }
  followed.on_target =
      static_cast<double>(std::ranges::count_if(errors_deg, [](double e) { return e < 2.0; })) /
      static_cast<double>(errors_deg.size());
  std::ranges::sort(errors_deg);
  followed.median_deg = errors_deg[errors_deg.size() / 2];
  std::cout << what << ": on target " << followed.on_target << ", median " << followed.median_deg
            << " deg, eyes' delay " << delay.eyes_s() * 1e3 << " ms, slowdown " << followed.slowdown << "\n";
  return followed;
}

QpConfig without_prediction() {
  QpConfig qp;
  qp.predict_motion = false;
  return qp;
}

TEST(Pursuit, PredictionFollowsACircleOfTwoHertz) {
  Pursuit pursuit;
  pursuit.frequency_hz = 2.0;
  pursuit.qp = without_prediction();
  EXPECT_LT(pursue(pursuit, "2 Hz").on_target, 0.1);
  pursuit.qp = {};
  EXPECT_GT(pursue(pursuit, "2 Hz, predicted").on_target, 0.95);
  pursuit.compensated = true;
  const Followed best = pursue(pursuit, "2 Hz, predicted and compensated");
  EXPECT_GT(best.on_target, 0.95);
  EXPECT_LT(best.median_deg, 0.5);
}

TEST(Pursuit, CompensationFollowsEventsThatAreEightyMillisecondsOld) {
  Pursuit pursuit;
  pursuit.sight_ms = 80;
  EXPECT_LT(pursue(pursuit, "80 ms").on_target, 0.1);
  pursuit.compensated = true;
  EXPECT_GT(pursue(pursuit, "80 ms, compensated").on_target, 0.9);
}

TEST(Pursuit, CompensationStaysStableWithEightyMillisecondsToTheMotors) {
  Pursuit pursuit;
  pursuit.plant.command_delay_ms = 80;
  pursuit.frequency_hz = 0.5;
  pursuit.qp.eye_time_constant_s = 0.04;
  EXPECT_LT(pursue(pursuit, "80 ms to the motors, eyes twice as fast").on_target, 0.5);
  pursuit.compensated = true;
  EXPECT_GT(pursue(pursuit, "80 ms to the motors, eyes twice as fast, compensated").on_target, 0.9);
}

TEST(Pursuit, FollowsOneHertzWithTheMismatchedPlant) {
  Pursuit pursuit;
  pursuit.plant = mismatched();
  pursuit.compensated = true;
  const Followed followed = pursue(pursuit, "mismatched plant, 1 Hz");
  EXPECT_GT(followed.on_target, 0.9);
  EXPECT_LT(followed.median_deg, 0.7);
}

TEST(Pursuit, HuntingEndsInSlowerTimeConstants) {
  Pursuit pursuit;
  pursuit.plant = mismatched();
  pursuit.frequency_hz = 0.0;
  pursuit.qp.eye_time_constant_s = 0.08 / 6.0;
  pursuit.hunting = true;
  const Followed followed = pursue(pursuit, "mismatched plant, eyes six times as fast");
  EXPECT_GT(followed.slowdown, 1.0);
  EXPECT_LT(followed.median_deg, 0.5);
  pursuit.qp = {};
  EXPECT_EQ(pursue(pursuit, "mismatched plant, at rest").slowdown, 1.0);
}

}  // namespace
}  // namespace saccade
