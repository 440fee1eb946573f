#include "core/tracker/disc_network.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

namespace saccade {
namespace {

constexpr ImageSize network_image{128, 128};
constexpr std::int64_t all = 1'000'000'000;

/// Events of a dark disc that moves to the right over a bright ground: OFF in front, ON behind.
std::vector<Event> moving_disc(double x_px, double y_px, double r_px, double speed_px_s, double seconds) {
  std::vector<Event> events;
  const double start_px = x_px - speed_px_s * seconds;
  const auto inside = [&](int x, int y, double centre_px) {
    return std::hypot(x - centre_px, y - y_px) < r_px;
  };
  for (double px = 0.5; px <= speed_px_s * seconds; px += 0.5) {
    const auto t_us = static_cast<std::int64_t>(px / speed_px_s * 1e6);
    for (int y = 0; y < network_image.height; ++y) {
      for (int x = 0; x < network_image.width; ++x) {
        const bool was = inside(x, y, start_px + px - 0.5);
        const bool is = inside(x, y, start_px + px);
        if (was != is)
          events.push_back({t_us, static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), was, 0});
      }
    }
  }
  return events;
}

TimeSurface disc_surface(const std::vector<Event>& events) {
  TimeSurface surface(network_image);
  for (const Event& event : events) surface.add(event);
  return surface;
}

DiscNetwork new_network() { return DiscNetwork(best_model_of({}), network_image, 4, 38); }

TEST(DiscNetwork, FindsAMovingDiscOfEachLevel) {
  for (const double r_px : {6.0, 11.0, 24.0}) {
    DiscNetwork disc = new_network();
    disc.begin(300'000);
    ASSERT_TRUE(disc.work(disc_surface(moving_disc(64, 60, r_px, 100, 0.3)), all));
    ASSERT_FALSE(disc.found().empty()) << "radius " << r_px;
    const Circle found = disc.found().front().circle;
    EXPECT_NEAR(found.x_px, 64, 0.3 * r_px + 1) << "radius " << r_px;
    EXPECT_NEAR(found.y_px, 60, 0.3 * r_px + 1) << "radius " << r_px;
    EXPECT_NEAR(found.r_px, r_px, 0.3 * r_px + 1) << "radius " << r_px;
  }
}

TEST(DiscNetwork, SeesNoDiscWithoutEvents) {
  DiscNetwork disc = new_network();
  disc.begin(1'000'000);
  ASSERT_TRUE(disc.work(disc_surface({}), all));
  for (const DiscNetwork::Found& found : disc.found()) EXPECT_LT(found.log_odds, 0.0F);
}

TEST(DiscNetwork, ItsResultDoesNotDependOnTheSizeOfTheSteps) {
  const TimeSurface surface = disc_surface(moving_disc(50, 70, 10, 200, 0.1));
  DiscNetwork at_once = new_network();
  DiscNetwork in_steps = new_network();
  at_once.begin(100'000);
  in_steps.begin(100'000);
  ASSERT_TRUE(at_once.work(surface, all));
  int steps = 1;
  while (!in_steps.work(surface, 1)) ++steps;
  EXPECT_GT(steps, 100);
  ASSERT_EQ(at_once.found().size(), in_steps.found().size());
  for (std::size_t i = 0; i < at_once.found().size(); ++i) {
    EXPECT_EQ(at_once.found()[i].log_odds, in_steps.found()[i].log_odds);
    EXPECT_EQ(at_once.found()[i].circle.x_px, in_steps.found()[i].circle.x_px);
  }
}

TEST(DiscNetwork, KeepsTheLastResultUntilTheNextIsComplete) {
  const TimeSurface surface = disc_surface(moving_disc(64, 60, 11, 100, 0.3));
  DiscNetwork disc = new_network();
  disc.begin(300'000);
  ASSERT_TRUE(disc.work(surface, all));
  const Circle found = disc.found().front().circle;
  EXPECT_GT(disc.about(found).log_odds, DiscNetwork::nothing);
  disc.begin(2'000'000);
  EXPECT_TRUE(disc.busy());
  EXPECT_FALSE(disc.work(surface, 1));
  EXPECT_EQ(disc.found_at_us(), 300'000);
  EXPECT_EQ(disc.found().front().circle.x_px, found.x_px);
}

TEST(DiscNetwork, KnowsNothingAboutACircleElsewhere) {
  const TimeSurface surface = disc_surface(moving_disc(64, 60, 11, 100, 0.3));
  DiscNetwork disc = new_network();
  disc.begin(300'000);
  ASSERT_TRUE(disc.work(surface, all));
  EXPECT_LT(disc.about({20, 110, 11}).log_odds, disc.about({64, 60, 11}).log_odds);
}

}  // namespace
}  // namespace saccade
