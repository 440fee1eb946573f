#include "control/hunting_detector.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/random.h"
#include "core/units.h"

namespace saccade {
namespace {

/// How often hunting is found in 5 s of an oscillation of version.
int finds(double frequency_hz, double amplitude_deg, double noise_deg = 0.0) {
  HuntingDetector detector;
  const RandomStream random(1, "test/hunting");
  int found = 0;
  for (std::uint64_t i = 0; i < 5000; ++i) {
    HeadJointVector reference = HeadJointVector::Zero();
    const double angle = 2.0 * std::numbers::pi * frequency_hz * static_cast<double>(i) * 1e-3;
    reference[head_index(eyes_version)] =
        (amplitude_deg * std::sin(angle) + noise_deg * random.normal(0, i)) * rad_per_deg;
    found += detector.update(reference, 1e-3);
  }
  return found;
}

TEST(HuntingDetector, FindsOscillationsAboveThreeHertz) {
  EXPECT_GT(finds(3.2, 2.0), 0);
  EXPECT_GT(finds(8.0, 0.6), 0);
  EXPECT_GT(finds(20.0, 0.6), 0);
}

TEST(HuntingDetector, FindsNoneInPursuitUpToTwoAndAHalfHertz) {
  EXPECT_EQ(finds(0.5, 15.0), 0);
  EXPECT_EQ(finds(2.0, 9.0), 0);
  EXPECT_EQ(finds(2.5, 9.0), 0);
}

TEST(HuntingDetector, FindsNoneInTheNoiseOfAHeadThatRests) { EXPECT_EQ(finds(5.0, 0.1, 0.04), 0); }

TEST(HuntingDetector, ReportsTheFrequency) {
  HuntingDetector detector;
  for (int i = 0; i < 3000; ++i) {
    HeadJointVector reference = HeadJointVector::Zero();
    reference[head_index(eyes_tilt)] = 0.05 * std::sin(2.0 * std::numbers::pi * 5.0 * i * 1e-3);
    detector.update(reference, 1e-3);
  }
  EXPECT_NEAR(detector.frequency_hz(), 5.0, 0.2);
}

}  // namespace
}  // namespace saccade
