#include "control/minimum_jerk_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <vector>

namespace saccade {
namespace {

constexpr double period_s = 0.01;
constexpr int ticks_per_period = 10;
constexpr double tick_s = period_s / ticks_per_period;

/// The position after every tick of a joint that follows its velocity command exactly.
std::vector<double> closed_loop(double time_s, double duration_s,
                                const std::function<double(double)>& reference,
                                double reference_velocity = 0.0) {
  MinimumJerkFilter filter(time_s, period_s);
  std::vector<double> positions;
  double position = 0.0, velocity = 0.0;
  for (int tick = 0; tick < static_cast<int>(duration_s / tick_s); ++tick) {
    if (tick % ticks_per_period == 0)
      velocity = filter.step(reference(tick * tick_s), reference_velocity, position);
    position += velocity * tick_s;
    positions.push_back(position);
  }
  return positions;
}

/// When the response reaches a share of its step, s.
double time_to(const std::vector<double>& response, double share) {
  const auto at = std::find_if(response.begin(), response.end(), [&](double p) { return p >= share; });
  const double after = *at, before = *(at - 1);
  return (static_cast<double>(at - response.begin()) + (share - before) / (after - before)) * tick_s;
}

TEST(MinimumJerkFilter, AStepFollowsTheTransferFunction) {
  for (const double time_s : {0.25, 0.75}) {
    const auto response = closed_loop(time_s, 4 * time_s, [](double) { return 1.0; });
    const double half = time_to(response, 0.50) / time_s;
    const double most = time_to(response, 0.90) / time_s;
    const double all = time_to(response, 0.99) / time_s;
    const double overshoot = *std::max_element(response.begin(), response.end()) - 1.0;
    double worst = 0.0;
    for (std::size_t i = 0; i < response.size(); ++i) {
      const double x = 5.3223 * static_cast<double>(i + 1) * tick_s / time_s;
      worst = std::max(worst, std::abs(response[i] - (1.0 - std::exp(-x) * (1.0 + x + x * x / 2))));
    }
    std::printf(
        "T = %.2f s: 50 %% at %.4f T, 90 %% at %.4f T, 99 %% at %.4f T, overshoot %.5f %%, off by %.4f\n",
        time_s, half, most, all, 100 * overshoot, worst);
    EXPECT_NEAR(half, 0.50, 0.02 * 0.50);
    EXPECT_NEAR(most, 1.00, 0.02 * 1.00);
    EXPECT_NEAR(all, 1.58, 0.02 * 1.58);
    EXPECT_LT(overshoot, 0.002);
    EXPECT_LT(worst, 0.002);  // of the triple pole's response, all the way
  }
}

TEST(MinimumJerkFilter, ARampIsFollowedLate) {
  for (const double time_s : {0.25, 0.75}) {
    const double duration_s = 8 * time_s;
    const auto response = closed_loop(
        time_s, duration_s, [](double t_s) { return 0.3 * t_s; }, 0.3);
    const double lag = static_cast<double>(response.size()) * tick_s - response.back() / 0.3;
    std::printf("T = %.2f s: a ramp is followed %.4f T late\n", time_s, lag / time_s);
    EXPECT_NEAR(lag / time_s, 0.564, 0.02 * 0.564);
  }
}

TEST(MinimumJerkFilter, ResetClearsTheState) {
  MinimumJerkFilter used(0.25, period_s), fresh(0.25, period_s);
  for (int i = 0; i < 7; ++i) (void)used.step(1.0, 0.2, 0.1 * i);
  used.reset();
  for (int i = 0; i < 7; ++i) EXPECT_EQ(used.step(0.5, 0.0, 0.1 * i), fresh.step(0.5, 0.0, 0.1 * i));
}

}  // namespace
}  // namespace saccade
