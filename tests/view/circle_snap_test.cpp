#include "apps/view/circle_snap.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/core/streams.h"

namespace saccade {
namespace {

constexpr ImageSize image{128, 128};
constexpr std::int64_t at_us = 150'000, reach_us = 5'000;
constexpr streams::MovingDisc disc{30, 50, 200, 60, 15};

/// The disc's events among noise: 1 event per pixel and second, which has no flow.
std::vector<Event> noisy_events() {
  std::vector<Event> events = disc.events(image, 0.3);
  const RandomStream random(1, "noise");
  for (std::uint64_t i = 0; i < 5'000; ++i) {
    events.push_back(streams::event_at(std::llround(3e5 * random.uniform(0, i)),
                                       static_cast<int>(128.0 * random.uniform(1, i)),
                                       static_cast<int>(128.0 * random.uniform(2, i)), i % 2 == 0));
  }
  streams::sort_by_time(events);
  return events;
}

void expect_disc_at(std::int64_t t_us, const std::optional<Circle>& circle) {
  ASSERT_TRUE(circle);
  // An event is at the centre of a pixel at the time at which the outline passes there: the fit is as exact as the flow.
  EXPECT_NEAR(circle->x_px, disc.x_at(t_us), 0.3);
  EXPECT_NEAR(circle->y_px, disc.y_at(t_us), 0.3);
  EXPECT_NEAR(circle->r_px, disc.r_px, 0.3);
}

TEST(SnappedCircle, FindsTheOutlineFromBesideItAndFromAnotherRadius) {
  const std::vector<Event> events = noisy_events();
  for (int i = 0; i < 8; ++i) {
    const double angle = 0.25 * std::numbers::pi * i;
    const double r_px = disc.r_px + (i % 2 == 0 ? 2.0 : -2.0);
    SCOPED_TRACE(i);
    expect_disc_at(at_us, snapped_circle(events, image,
                                         {disc.x_at(at_us) + 3.0 * std::cos(angle),
                                          disc.y_at(at_us) + 3.0 * std::sin(angle), r_px},
                                         at_us, reach_us));
  }
}

TEST(SnappedCircle, IsThatOfTheInstantWhateverTheReach) {
  const std::vector<Event> events = noisy_events();
  for (const std::int64_t reach : {2'000, 10'000, 30'000}) {
    SCOPED_TRACE(reach);
    expect_disc_at(
        at_us, snapped_circle(events, image, {disc.x_at(at_us) + 1.0, disc.y_at(at_us), 16.0}, at_us, reach));
  }
}

TEST(SnappedCircle, AtTheEndOfTheRecordingHasTheEventsBeforeIt) {
  std::vector<Event> events = noisy_events();
  std::erase_if(events, [](const Event& event) { return event.t_us > at_us; });
  expect_disc_at(at_us, snapped_circle(events, image, {disc.x_at(at_us) + 2.0, disc.y_at(at_us), 14.0}, at_us,
                                       reach_us));
}

TEST(SnappedCircle, IsNoneWhereNoEdgeIsNear) {
  const std::vector<Event> events = noisy_events();
  EXPECT_FALSE(snapped_circle(events, image, {105.0, 100.0, 15.0}, at_us, reach_us)) << "noise alone";
  EXPECT_FALSE(
      snapped_circle(events, image, {disc.x_at(at_us), disc.y_at(at_us), disc.r_px}, 2'000'000, reach_us))
      << "after the last event";
}

TEST(SnappedCircle, LeavesOutEventsOutsideTheImage) {
  std::vector<Event> events = noisy_events();
  for (int i = 0; i < 20; ++i) events.push_back(streams::event_at(at_us + i, 128 + i, 200, true));
  streams::sort_by_time(events);
  expect_disc_at(at_us, snapped_circle(events, image, {disc.x_at(at_us) + 1.0, disc.y_at(at_us), 15.0}, at_us,
                                       reach_us));
}

}  // namespace
}  // namespace saccade
