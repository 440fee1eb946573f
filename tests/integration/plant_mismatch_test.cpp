#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <deque>
#include <iostream>
#include <numbers>
#include <vector>

#include "control/controller_registry.h"
#include "control/head_kinematics.h"
#include "control/joint_limiter.h"
#include "control/qp_controller.h"
#include "core/camera.h"
#include "core/random.h"
#include "head/icub_cameras.h"
#include "sim/world.h"

/// The gaze controller `qp` on a head that differs from its model in every configurable way. Its input is that of an
/// event-driven tracker: the centre of the ball in the true camera 8 ms ago, with an error of 0.3 px, converted to the
/// root frame with the controller's kinematics and the encoder readings.

namespace saccade {
namespace {

constexpr double deg = std::numbers::pi / 180.0;
constexpr double dt_s = 1e-3;
constexpr std::size_t settled = 2000;  // ticks
constexpr std::size_t watched = 4000;  // ticks after that: lines of the spectrum are 0.25 Hz apart
constexpr double px_deg = 0.576;

PlantConfig apart() {
  PlantConfig plant;
  plant.axes = NeckAxes::cad;
  plant.encoders.noise_deg = 0.02;
  plant.encoders.quantisation_deg = 0.088;  // 12 bits per turn
  plant.command_delay_ms = 20;
  plant.neck = {0.05, 0.5};
  plant.eyes = {0.05, 0.3};
  return plant;
}

struct Watch {
  std::vector<HeadJointVector> joints_rad;  // every tick
  std::vector<double> error_deg;            // of the left eye
  bool kept_limits = true;

  [[nodiscard]] double on_target() const {
    const auto from = error_deg.begin() + settled;
    return static_cast<double>(std::count_if(from, error_deg.end(), [](double e) { return e < 2.0; })) /
           watched;
  }
  /// The quantile of the error over time.
  [[nodiscard]] double error_below_deg(double share) const {
    std::vector<double> sorted(error_deg.begin() + settled, error_deg.end());
    const auto at = sorted.begin() + static_cast<std::ptrdiff_t>(share * (watched - 1));
    std::nth_element(sorted.begin(), at, sorted.end());
    return *at;
  }
  [[nodiscard]] double median_deg() const { return error_below_deg(0.5); }
};

Watch look(const PlantConfig& plant, const TrajectoryConfig& ball, const QpConfig& qp = {}) {
  WorldConfig config;
  config.plant = plant;
  config.ball.trajectory = ball;
  World world(config, "", 1);
  GazeControllerConfig gaze = built_in_controllers().config();
  gaze.get<QpConfig>() = qp;
  const auto controller = make_gaze_controller(gaze, world.limits());
  JointLimiter limiter(motion_limits(world.limits(), gaze.limits));
  const RandomStream random(3, "test/tracker");
  const double px_m = 0.3 / icub_left_2016.fx_px;  // at unit depth
  std::deque<Eigen::Vector3d> seen;
  Watch run;
  for (std::uint64_t tick = 0; tick < settled + watched; ++tick) {
    world.step();
    const HeadState state = world.head_state();
    Eigen::Vector3d ball_m = world.root_from_left_cam().inverse() * world.target_position_m();
    run.error_deg.push_back(std::atan2(ball_m.head<2>().norm(), ball_m.z()) / deg);
    ball_m.head<2>() += px_m * ball_m.z() * Eigen::Vector2d(random.normal(0, tick), random.normal(1, tick));
    seen.push_back(HeadKinematics(default_head()->chain, state.position_rad).root_from_eye(Eye::left) *
                   ball_m);
    std::optional<Eigen::Vector3d> target;
    if (seen.size() > 8) {
      target = seen.front();
      seen.pop_front();
    }
    const HeadJointVector wanted = controller->step(state, target, dt_s);
    EXPECT_TRUE(world.set_reference(limiter.apply(wanted, state.head_position_rad(), dt_s).reference_rad));
    const JointVector joints = world.joints_rad();
    run.joints_rad.push_back(joints.tail<gaze_slots>());
    const JointLimits& limits = world.limits();
    run.kept_limits = run.kept_limits && (joints - limits.max_rad).maxCoeff() < 0.01 * deg &&
                      (limits.min_rad - joints).maxCoeff() < 0.01 * deg;
  }
  return run;
}

/// The part of the joints' velocities above 3 Hz.
struct Shaking {
  double rms_deg_s = 0.0;  // of all joints together
  double share = 0.0;      // of the power of all their velocities
  double line_deg = 0.0;   // amplitude of a joint in the strongest line
  double line_hz = 0.0;
};

Shaking shaking(const Watch& run, const char* what) {
  constexpr double n = watched;
  Shaking found;
  double all = 0.0;
  double fast = 0.0;
  for (int joint = 0; joint < head_joint_count; ++joint) {
    std::vector<double> velocity;
    double mean = 0.0;
    for (std::size_t t = settled; t < settled + watched; ++t) {
      velocity.push_back((run.joints_rad[t][joint] - run.joints_rad[t - 1][joint]) / dt_s / deg);
      mean += velocity.back() / n;
    }
    for (int k = 1; k <= 200; ++k) {  // to 50 Hz, above the bandwidth of the servos
      const double hz = k / (n * dt_s);
      const std::complex<double> turn = std::polar(1.0, -2.0 * std::numbers::pi * k / n);
      std::complex<double> phase = 1.0;
      std::complex<double> sum = 0.0;
      for (std::size_t t = 0; t < watched; ++t, phase *= turn) {
        const double hann = 1.0 - std::cos(2.0 * std::numbers::pi * (static_cast<double>(t) + 0.5) / n);
        sum += hann * (velocity[t] - mean) * phase;
      }
      const double power = 2.0 * std::norm(sum / n) / 1.5;  // 1.5: the window's mean square
      all += power;
      if (hz <= 3.0) continue;
      fast += power;
      const double amplitude_deg = 2.0 * std::abs(sum) / n / (2.0 * std::numbers::pi * hz);
      if (amplitude_deg > found.line_deg) {
        found.line_deg = amplitude_deg;
        found.line_hz = hz;
      }
    }
  }
  found.share = fast / all;
  found.rms_deg_s = std::sqrt(fast);
  std::cout << what << ": above 3 Hz " << found.rms_deg_s << " deg/s rms, a share of " << found.share
            << ", at most a line of " << found.line_deg << " deg at " << found.line_hz << " Hz; on target "
            << run.on_target() << ", median error " << run.median_deg() << " deg\n";
  return found;
}

TrajectoryConfig resting() {
  TrajectoryConfig ball;
  ball.points_m = {{-0.506, -0.10, 0.27}};
  ball.sway_m = 0.0;
  return ball;
}

/// One turn in 4 s, at the speed of the ball in gaze_square.
TrajectoryConfig circling() {
  TrajectoryConfig ball;
  ball.kind = TrajectoryKind::circle;
  ball.centre_m = {-0.506, 0.0, 0.347};
  ball.radius_a_m = {0.0, -0.07, 0.0};
  ball.radius_b_m = {0.0, 0.0, 0.07};
  ball.frequency_hz = 0.25;
  return ball;
}

TEST(PlantMismatch, TheHeadRestsOnABallThatRests) {
  const Watch run = look(apart(), resting());
  const Shaking found = shaking(run, "apart, at rest");
  // An amplitude of a twentieth of a pixel is not visible in the image.
  EXPECT_LT(found.line_deg, 0.05 * px_deg);
  EXPECT_LT(found.rms_deg_s, 2.0 * std::numbers::pi * 3.0 * 0.1 * px_deg);
  // Oscillations below 3 Hz would appear in the error: friction and backlash cause no limit cycle.
  EXPECT_LT(run.error_below_deg(0.95), 0.5 * px_deg);
  EXPECT_TRUE(run.kept_limits);
}

TEST(PlantMismatch, TheHeadFollowsWithoutOscillation) {
  const Watch run = look(apart(), circling());
  const Shaking found = shaking(run, "apart, following");
  // Joints that cross their backlash jump, which adds power at every frequency; no line may reach a quarter of a pixel.
  // An oscillation has nearly all of its power in one line (see below).
  EXPECT_LT(found.line_deg, 0.25 * px_deg);
  EXPECT_LT(found.share, 0.1);
  EXPECT_TRUE(run.kept_limits);
}

TEST(PlantMismatch, StaysOnTargetNearlyAsLongAsAHeadThatEqualsItsModel) {
  const Watch model = look({}, circling());
  const Watch other = look(apart(), circling());
  std::cout << "on target " << model.on_target() << " and " << other.on_target() << ", median error "
            << model.median_deg() << " and " << other.median_deg() << " deg\n";
  EXPECT_GT(other.on_target(), model.on_target() - 0.1);
  EXPECT_LT(other.median_deg(), model.median_deg() + 0.5 * px_deg);
}

TEST(PlantMismatch, AnEyeTooFastForTheDelayIsReportedAsOscillating) {
  QpConfig hasty;
  hasty.eye_time_constant_s = 0.012;
  const Shaking found = shaking(look(apart(), resting(), hasty), "apart, eyes five times as fast");
  EXPECT_GT(found.line_deg, px_deg);
  EXPECT_GT(found.share, 0.9);
}

}  // namespace
}  // namespace saccade
