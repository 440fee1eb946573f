// Numbers of every magnitude, infinities, NaN and denormals, as a broken message or a faulty encoder can bring them: every
// solver returns, and every reference is finite and within the limits of the hardware.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <limits>

#include "control/bounded_qp.h"
#include "control/controller_registry.h"
#include "control/delay_compensation.h"
#include "control/gate_registry.h"
#include "control/neck_solver.h"
#include "control/stabilisation.h"
#include "control/target.h"
#include "core/random.h"
#include "head/icub_cameras.h"
#include "tests/control/genova02.h"

namespace saccade {
namespace {

/// Seeded numbers: a third of ordinary size, a third of any exponent, a third from a list of the awkward ones.
class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : random_(seed, "every magnitude") {}

  double next() {
    constexpr double inf = std::numeric_limits<double>::infinity();
    constexpr double most = std::numeric_limits<double>::max();
    constexpr std::array awkward = {0.0,
                                    -0.0,
                                    inf,
                                    -inf,
                                    std::numeric_limits<double>::quiet_NaN(),
                                    most,
                                    -most,
                                    std::numeric_limits<double>::min(),
                                    std::numeric_limits<double>::denorm_min(),
                                    -std::numeric_limits<double>::denorm_min(),
                                    -1e300,
                                    1e154,
                                    1e-154,
                                    1e-300,
                                    1.0,
                                    999.0};
    switch (random_.bits(0, ++count_) % 3) {
      case 0:
        return random_.uniform(-1.0, 1.0, 1, count_);
      case 1:
        return std::bit_cast<double>(random_.bits(2, count_));
      default:
        return awkward[random_.bits(3, count_) % awkward.size()];
    }
  }
  /// One in `share` of them is of any magnitude, the others are ordinary.
  double rare(std::uint64_t share) {
    return random_.bits(4, ++count_) % share == 0 ? next() : random_.uniform(-0.5, 0.5, 5, count_);
  }
  template <class Vector>
  Vector vector(std::uint64_t share) {
    Vector values;
    for (Eigen::Index i = 0; i < values.size(); ++i) values[i] = rare(share);
    return values;
  }

 private:
  RandomStream random_;
  std::uint64_t count_ = 0;
};

TEST(EveryMagnitude, TheNeckSolverReturnsAPoseWithinTheLimits) {
  const JointLimits limits = genova02_limits();
  const NeckVector min_rad = limits.min_rad.segment<3>(neck_pitch);
  const NeckVector max_rad = limits.max_rad.segment<3>(neck_pitch);
  const NeckSolver solver(default_head(), min_rad, max_rad);
  Numbers numbers(1);
  const auto expect_within = [&](const NeckSolver::Pose& pose) {
    EXPECT_LE(pose.iterations, NeckSolver::max_iterations);
    EXPECT_TRUE((pose.neck_rad.array() >= min_rad.array() - 1e-12).all() &&
                (pose.neck_rad.array() <= max_rad.array() + 1e-12).all())
        << pose.neck_rad.transpose();
  };
  expect_within(solver.solve(JointVector::Zero(), {-1e300, 0.0, 0.3}, NeckVector::Zero()));
  for (int i = 0; i < 3000; ++i) {
    expect_within(solver.solve(numbers.vector<JointVector>(30), numbers.vector<Eigen::Vector3d>(2),
                               numbers.vector<NeckVector>(6)));
  }
}

TEST(EveryMagnitude, TheBoundedQpStaysWithinItsBounds) {
  BoundedQp<6> qp;
  Numbers numbers(2);
  for (int i = 0; i < 3000; ++i) {
    using Vector = BoundedQp<6>::Vector;
    BoundedQp<6>::Matrix a;
    for (Eigen::Index j = 0; j < 6; ++j) a.col(j) = numbers.vector<Vector>(40);
    const BoundedQp<6>::Matrix h = a.transpose() * a + 1e-6 * BoundedQp<6>::Matrix::Identity();
    const auto found = qp.solve(h, numbers.vector<Vector>(10), Vector::Constant(-0.2), Vector::Constant(0.3));
    EXPECT_LE(found.iterations, BoundedQp<6>::max_iterations);
    EXPECT_TRUE((found.x.array() >= -0.2).all() && (found.x.array() <= 0.3).all()) << found.x.transpose();
  }
}

TEST(EveryMagnitude, EveryControllerReturnsReferencesWithinTheLimitsAndFollowsAgainAfterwards) {
  const JointLimits limits = genova02_limits();
  const ControllerRegistry registry = built_in_controllers();
  for (const GazeControllerRow& row : registry.rows()) {
    GazeControllerConfig config = registry.config();
    config.controller = row.name;
    const auto controller = make_gaze_controller(config, limits);
    Numbers numbers(3);
    HeadState state;
    const auto step = [&](const std::optional<Eigen::Vector3d>& target_m, double dt_s) {
      const HeadJointVector reference_rad = controller->step(state, target_m, dt_s);
      for (int j = 0; j < head_joint_count; ++j) {
        EXPECT_TRUE(reference_rad[j] >= limits.min_rad[torso_slots + j] - 1e-9 &&
                    reference_rad[j] <= limits.max_rad[torso_slots + j] + 1e-9)
            << row.name << " " << reference_rad.transpose();
      }
      return reference_rad;
    };
    for (int i = 0; i < 3000 && !HasFailure(); ++i) {
      state.position_rad = numbers.vector<JointVector>(60);
      state.velocity_rad_s = numbers.vector<JointVector>(20);
      const double dt_s = std::abs(numbers.rare(10));
      BodyRates rates;
      rates.torso_rad_s = numbers.vector<Eigen::Vector3d>(40);
      rates.base_rad_s = numbers.vector<Eigen::Vector3d>(40);
      controller->set_body_rates(rates);
      step(numbers.vector<Eigen::Vector3d>(4), dt_s > 0.0 ? dt_s : 1e-3);
    }
    // A head that follows: the last target is reached whatever came before.
    controller->set_body_rates({});
    controller->rest();
    state = {};
    const Eigen::Vector3d target_m(-0.5, 0.05, 0.35);
    for (int i = 0; i < 4000; ++i) state.position_rad.tail<gaze_slots>() = step(target_m, 1e-3);
    if (!row.follows_targets) continue;
    const Eigen::Vector3d seen =
        HeadKinematics(default_head()->chain, state.position_rad).root_from_eye(Eye::left).inverse() *
        target_m;
    EXPECT_LT(std::atan2(seen.head<2>().norm(), seen.z()), 0.5 * rad_per_deg) << row.name;
  }
}

TEST(EveryMagnitude, TargetsFartherThanAKilometreAreRejected) {
  const HeadKinematics head(default_head()->chain, JointVector::Zero());
  EXPECT_EQ(check_gaze_target({-999.0, 0.0, 0.3}, head), TargetStatus::ok);
  EXPECT_EQ(check_gaze_target({-1001.0, 0.0, 0.3}, head), TargetStatus::too_far);
  EXPECT_EQ(check_gaze_target({-1e300, 0.0, 0.3}, head), TargetStatus::too_far);
  EXPECT_EQ(check_gaze_target({-std::numeric_limits<double>::max(), 1e200, 0.3}, head),
            TargetStatus::too_far);
}

TEST(EveryMagnitude, GatesAndLocatorsReturnTargetsThatAreFiniteAndNearEnough) {
  const HeadKinematics head(default_head()->chain, JointVector::Zero());
  const Eigen::Isometry3d& eye = head.root_from_eye(Eye::left);
  for (const char* name : {"authors", "continuity"}) {
    GateConfig config = built_in_gates().config();
    config.gate = name;
    const auto gate = make_gate(config);
    Numbers numbers(4);
    for (std::int64_t t_us = 1000; t_us < 3'000'000; t_us += 1000) {
      Estimate estimate;
      estimate.valid = true;
      estimate.circle = {64.0 + numbers.rare(3), 64.0 + numbers.rare(3), 12.0 + numbers.rare(3)};
      estimate.score = 1.0 + numbers.rare(8);
      const auto target_m = gate->update(t_us, estimate, 0.5, icub_left_2016, eye);
      EXPECT_LE(target_m.value_or(Eigen::Vector3d::Zero()).norm(), TargetConfig{}.max_distance_m + 1.0)
          << name;
    }
  }
}

TEST(EveryMagnitude, StabiliserAndEstimatorOfDelaysRecover) {
  Numbers numbers(5);
  Stabiliser stabiliser({.torso = false, .gyroscope = true, .image = false}, default_head(),
                        Eigen::Isometry3d::Identity());
  MotionDelayEstimator delays;
  for (int i = 0; i < 3000; ++i) {
    HeadState state;
    ImuReading imu;
    imu.angular_velocity_rad_s = numbers.vector<Eigen::Vector3d>(4);
    const BodyRates& rates = stabiliser.update(state, &imu, 0.01, 1e-3, std::nullopt);
    EXPECT_TRUE(rates.base_rad_s.allFinite());
    delays.update(numbers.vector<HeadJointVector>(50), HeadJointVector::Constant(0.1 * std::sin(0.01 * i)),
                  1e-3);
    EXPECT_TRUE(std::isfinite(delays.neck_s()) && std::isfinite(delays.eyes_s()));
  }
}

}  // namespace
}  // namespace saccade
