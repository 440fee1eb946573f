#include "control/delay_compensation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <deque>
#include <numbers>

#include "core/random.h"
#include "core/units.h"

namespace saccade {
namespace {

constexpr double tick_s = 1e-3;

/// References of one hertz, joints that follow them after a dead time, encoders with noise and steps of 0.088 deg.
MotionDelayEstimator estimate_after(double duration_s, std::size_t neck_ms, std::size_t eyes_ms,
                                    double amplitude_deg) {
  MotionDelayEstimator estimator;
  const RandomStream random(1, "test/delay");
  std::deque<HeadJointVector> sent(200, HeadJointVector::Zero());
  for (std::uint64_t i = 0; static_cast<double>(i) * tick_s < duration_s; ++i) {
    HeadJointVector measured = HeadJointVector::Zero();
    for (int j = 0; j < head_joint_count; ++j) {
      const double true_rad = sent[(j < neck_joint_count ? neck_ms : eyes_ms)][j];
      const double noisy_deg =
          true_rad / rad_per_deg + 0.02 * random.normal(static_cast<std::uint64_t>(j), i);
      measured[j] = 0.088 * std::round(noisy_deg / 0.088) * rad_per_deg;
    }
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(i) * tick_s;
    HeadJointVector reference = HeadJointVector::Constant(amplitude_deg * rad_per_deg * std::sin(angle));
    estimator.update(measured, reference, tick_s);
    sent.push_front(reference);
    sent.pop_back();
  }
  return estimator;
}

TEST(MotionDelayEstimator, FindsTheDelaysOfNeckAndEyesThroughNoisyEncoders) {
  const MotionDelayEstimator estimator = estimate_after(5.0, 55, 30, 8.0);
  EXPECT_NEAR(estimator.neck_s(), 0.055, 0.003);
  EXPECT_NEAR(estimator.eyes_s(), 0.030, 0.003);
}

TEST(MotionDelayEstimator, FindsDelaysOfUpToATenthOfASecondAndMore) {
  EXPECT_NEAR(estimate_after(6.0, 120, 100, 8.0).eyes_s(), 0.100, 0.003);
  EXPECT_NEAR(estimate_after(6.0, 0, 0, 8.0).eyes_s(), 0.0, 0.003);
}

TEST(MotionDelayEstimator, ReportsNoDelayWhileTheHeadRests) {
  EXPECT_EQ(estimate_after(5.0, 55, 30, 0.0).eyes_s(), 0.0);
}

}  // namespace
}  // namespace saccade
