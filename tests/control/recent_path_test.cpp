#include "control/recent_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "control/periodic_fit.h"
#include "control/reference_history.h"

namespace saccade {
namespace {

constexpr double two_pi = 2.0 * std::numbers::pi;

TEST(RecentPath, AveragesTwentyMillisecondsAtTheirMiddle) {
  RecentPath path;
  EXPECT_EQ(path.newest(), -1);
  EXPECT_EQ(path.length(), 0);
  const Eigen::Vector3d speed(1.0, -2.0, 0.5);
  int closed = 0;
  for (int ms = 0; ms <= 100; ++ms) {
    const double t_s = 1e-3 * ms;
    closed += path.observe(t_s, speed * t_s, speed) ? 1 : 0;
  }
  EXPECT_EQ(closed, 5);
  EXPECT_EQ(path.newest(), 4);
  EXPECT_EQ(path.length(), 5);
  for (std::int64_t back = 0; back < 5; ++back) {
    ASSERT_TRUE(path.at(back).known);
    EXPECT_LT((path.at(back).point_m - speed * RecentPath::time_s(4 - back)).norm(), 1e-12) << back;
  }
}

TEST(RecentPath, HasGapsWhereNothingWasObserved) {
  RecentPath path;
  for (const double t_s : {0.001, 0.081, 0.101})
    path.observe(t_s, Eigen::Vector3d::Ones(), Eigen::Vector3d::Zero());
  EXPECT_EQ(path.newest(), 4);
  EXPECT_EQ(path.length(), 5);
  EXPECT_TRUE(path.at(0).known);
  EXPECT_FALSE(path.at(1).known);
  EXPECT_FALSE(path.at(3).known);
  EXPECT_TRUE(path.at(4).known);
  path.clear();
  EXPECT_EQ(path.length(), 0);
}

TEST(RecentPath, KeepsTheLastAveragesOfALongPath) {
  RecentPath path;
  for (int i = 0; i < 1000; ++i)
    path.observe(RecentPath::spacing_s * i, Eigen::Vector3d::Constant(i), Eigen::Vector3d::Zero());
  EXPECT_EQ(path.length(), RecentPath::capacity);
  EXPECT_EQ(path.at(0).point_m.x(), 998.0);
  EXPECT_EQ(path.at(RecentPath::capacity - 1).point_m.x(), 998.0 - (RecentPath::capacity - 1));
}

/// The fit after a path of 2.5 s in ticks of 1 ms.
template <class Motion>
std::optional<Sinusoid> fit_of(const Motion& motion) {
  RecentPath path;
  PeriodicFit fit;
  for (int ms = 0; ms < 2500; ++ms) {
    const double t_s = 1e-3 * ms;
    path.observe(t_s, motion(t_s), Eigen::Vector3d::Zero());
    fit.search(path);
  }
  return fit.sinusoid();
}

TEST(PeriodicFit, FindsFrequencyAndPlaceOfAnEllipse) {
  for (const double hz : {0.6, 1.0, 2.3}) {
    const auto ellipse = [&](double t_s) {
      return Eigen::Vector3d(-0.5, 0.1 * std::cos(two_pi * hz * t_s),
                             0.3 + 0.05 * std::sin(two_pi * hz * t_s));
    };
    const auto found = fit_of(ellipse);
    ASSERT_TRUE(found) << hz;
    EXPECT_NEAR(found->frequency_hz, hz, 0.02);
    EXPECT_LT((found->position_m(2.5) - ellipse(2.5)).norm(), 0.01);
    EXPECT_LT((found->velocity_m_s(2.5) - (ellipse(2.501) - ellipse(2.499)) / 0.002).norm(), 0.1);
    EXPECT_NEAR(found->amplitude_m(), std::hypot(0.1, 0.05), 0.01);
  }
}

TEST(PeriodicFit, FindsNoneInAStraightMotionAtRestAndBelowACentimetre) {
  EXPECT_FALSE(fit_of([](double t_s) { return Eigen::Vector3d(0.2 * t_s, 0.0, 0.0); }));
  EXPECT_FALSE(fit_of([](double) { return Eigen::Vector3d(0.2, 0.0, 0.0); }));
  EXPECT_FALSE(fit_of([](double t_s) { return Eigen::Vector3d(0.002 * std::cos(two_pi * t_s), 0.0, 0.0); }));
}

TEST(Sinusoid, VelocityAndAccelerationAreItsDerivatives) {
  const Sinusoid s{1.3, 0.2, {1, 2, 3}, {0.1, 0.0, -0.2}, {0.0, 0.3, 0.1}};
  constexpr double h = 1e-5;
  const Eigen::Vector3d velocity = (s.position_m(1.0 + h) - s.position_m(1.0 - h)) / (2.0 * h);
  const Eigen::Vector3d acceleration = (s.velocity_m_s(1.0 + h) - s.velocity_m_s(1.0 - h)) / (2.0 * h);
  EXPECT_LT((s.velocity_m_s(1.0) - velocity).norm(), 1e-6);
  EXPECT_LT((s.acceleration_m_s2(1.0) - acceleration).norm(), 1e-5);
}

TEST(ReferenceHistory, ReturnsReferencesBeforeTheNewest) {
  ReferenceHistory history;
  EXPECT_TRUE(history.at(3.0).isZero());
  for (int i = 1; i <= 600; ++i) history.push(HeadJointVector::Constant(i));
  EXPECT_EQ(history.at(0.0)[0], 600.0);
  EXPECT_EQ(history.at(2.4)[0], 598.0);
  EXPECT_EQ(history.at(2.6)[0], 597.0);
  EXPECT_EQ(history.at(1e6)[0], 600.0 - 511.0) << "the oldest known";
  history.clear();
  history.push(HeadJointVector::Constant(7));
  EXPECT_EQ(history.at(100.0)[0], 7.0);
}

}  // namespace
}  // namespace saccade
