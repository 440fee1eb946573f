#include "control/target_track.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "core/random.h"

namespace saccade {
namespace {

constexpr double dt = 1e-3;

TEST(TargetTrack, HasNoLagBehindATargetOfConstantAcceleration) {
  TargetTrack track(0.03);
  Eigen::Vector3d target;
  for (int i = 0; i <= 1000; ++i) {
    const double t = i * dt;
    target = Eigen::Vector3d(-0.5, 0.2 * t + 0.5 * 0.4 * t * t, 0.3 - 0.1 * t);
    track.advance(dt);
    track.observe(target);
  }
  EXPECT_LT((track.position_m() - target).norm(), 1e-9);
  EXPECT_LT((track.velocity_m_s() - Eigen::Vector3d(0.0, 0.6, -0.1)).norm(), 1e-6);
}

TEST(TargetTrack, IsIndependentOfTheRateOfTargets) {
  TargetTrack track(0.03);
  for (int i = 0; i <= 1000; ++i) {
    track.advance(dt);
    if (i % 5 == 0) track.observe({-0.5, 0.2 * i * dt, 0.3});
  }
  EXPECT_LT((track.position_m() - Eigen::Vector3d(-0.5, 0.2, 0.3)).norm(), 1e-9);
}

TEST(TargetTrack, RejectsNoiseFasterThanItsMemory) {
  // White noise of 2 mm at 1 kHz, memory of 30 samples.
  TargetTrack track(0.03);
  const RandomStream random(1, "targets");
  double squares = 0.0;
  int count = 0;
  for (int i = 0; i < 5000; ++i) {
    track.advance(dt);
    track.observe({-0.5, 0.002 * random.normal(0, static_cast<std::uint64_t>(i)), 0.3});
    if (i < 500) continue;
    squares += track.position_m().y() * track.position_m().y();
    ++count;
  }
  const double sd_m = std::sqrt(squares / count);
  std::cout << "2 mm of noise leave " << 1e3 * sd_m << " mm\n";
  EXPECT_LT(sd_m, 0.001);
}

TEST(TargetTrack, StopsSoonAfterTheLastTarget) {
  TargetTrack track(0.03);
  for (int i = 0; i <= 500; ++i) {
    track.advance(dt);
    track.observe({-0.5, 0.2 * i * dt, 0.3});
  }
  for (int i = 0; i < 400; ++i) track.advance(dt);
  // 0.2 m/s for 30 ms, and as far again while it fades.
  EXPECT_NEAR(track.position_m().y(), 0.1 + 2.0 * 0.2 * 0.03, 1e-3);
  EXPECT_LT(track.velocity_m_s().norm(), 1e-4);
}

TEST(TargetTrack, RestartsAtRestAfterALongPause) {
  TargetTrack track(0.03);
  for (int i = 0; i <= 500; ++i) {
    track.advance(dt);
    track.observe({-0.5, 0.2 * i * dt, 0.3});
  }
  track.advance(1.1 * TargetTrack::forget_s);
  track.observe({-0.4, -0.1, 0.2});
  EXPECT_EQ(track.position_m(), Eigen::Vector3d(-0.4, -0.1, 0.2));
  EXPECT_EQ(track.velocity_m_s(), Eigen::Vector3d::Zero());
}

}  // namespace
}  // namespace saccade
