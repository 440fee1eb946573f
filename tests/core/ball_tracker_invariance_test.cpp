// `best` finds the same ball in the same scene seen another way: faster or slower, mirrored, turned, at another resolution,
// with inverted polarity, with events missing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "core/random.h"
#include "core/tracker/ball_tracker.h"
#include "head/icub_cameras.h"
#include "tests/core/streams.h"

namespace saccade {
namespace {

/// A disc with a radius of 12 px that crosses the image of 128 x 128 pixels at 335 px/s, two edges of the background that
/// move the other way, and noise: one event in 20. At `scale` all lengths are multiplied, the speeds too.
std::vector<Event> disc_before_edges(int scale) {
  const ImageSize size{128 * scale / 2, 128 * scale / 2};
  const double px = 0.5 * scale;
  std::vector<Event> events =
      streams::MovingDisc{25 * px, 35 * px, 300 * px, 150 * px, 12 * px}.events(size, 0.25);
  for (const double angle_rad : {2.6, 3.9}) {
    for (const Event& e : streams::moving_edge(size, angle_rad, 400 * px, true)) {
      if (e.t_us < 250'000) events.push_back(e);
    }
  }
  const RandomStream random(7, "invariance");
  const std::size_t noise = events.size() / 20;
  for (std::size_t i = 0; i < noise; ++i) {
    events.push_back(streams::event_at(static_cast<std::int64_t>(random.uniform(0, i) * 250'000),
                                       static_cast<int>(random.uniform(1, i) * size.width),
                                       static_cast<int>(random.uniform(2, i) * size.height),
                                       random.uniform(3, i) < 0.5));
  }
  streams::sort_by_time(events);
  return events;
}

/// Where the disc of disc_before_edges(2) is at 200 ms.
constexpr Circle expected{25 + 300 * 0.2, 35 + 150 * 0.2, 12};
constexpr double bound_px = 1.0, radius_bound_px = 0.75;

struct View {
  std::string name;
  std::vector<Event> events;
  ImageSize size{128, 128};
  double time_factor = 1.0;
  double px = 1.0;         ///< length of a pixel of the original scene
  Circle disc = expected;  ///< in this view
};

void PrintTo(const View& view, std::ostream* out) { *out << view.name; }

/// The original events, each changed by `change`.
template <class Change>
View changed(const std::string& name, const Circle& disc, Change change) {
  View view{name, disc_before_edges(2)};
  view.disc = disc;
  for (Event& e : view.events) change(e);
  return view;
}

std::vector<View> views() {
  std::vector<View> all;
  all.push_back(changed("original", expected, [](Event&) {}));
  for (const int percent : {25, 50, 200, 400}) {
    all.push_back(changed("timesOf" + std::to_string(percent) + "Percent", expected,
                          [&](Event& e) { e.t_us = e.t_us * percent / 100; }));
    all.back().time_factor = percent / 100.0;
  }
  all.push_back(changed("mirrored", {127 - expected.x_px, expected.y_px, expected.r_px},
                        [](Event& e) { e.x = static_cast<std::uint16_t>(127 - e.x); }));
  all.push_back(
      changed("turnedBy90Degrees", {127 - expected.y_px, expected.x_px, expected.r_px}, [](Event& e) {
        const std::uint16_t x = e.x;
        e.x = static_cast<std::uint16_t>(127 - e.y);
        e.y = x;
      }));
  all.push_back(changed("invertedPolarity", expected, [](Event& e) { e.on = !e.on; }));
  all.push_back(changed("withoutThirtyPercentOfTheEvents", expected, [](Event&) {}));
  const RandomStream random(8, "dropped");
  std::uint64_t index = 0;
  std::erase_if(all.back().events, [&](const Event&) { return random.uniform(0, index++) < 0.3; });
  for (const int scale : {1, 4}) {
    const double px = 0.5 * scale;
    all.push_back({scale == 1 ? "halfTheResolution" : "twiceTheResolution",
                   disc_before_edges(scale),
                   {64 * scale, 64 * scale},
                   1.0,
                   px,
                   {expected.x_px * px, expected.y_px * px, expected.r_px * px}});
  }
  return all;
}

class BallTrackerInvariance : public testing::TestWithParam<View> {};

TEST_P(BallTrackerInvariance, FindsTheSameBall) {
  const View& view = GetParam();
  BallTrackerConfig config;
  config.radius_px = {std::floor(6 * view.px), std::ceil(20 * view.px)};
  Camera camera = icub_left_2016;
  camera.size = view.size;
  BallTracker tracker(config, camera);
  std::size_t next = 0;
  const auto end_us = static_cast<std::int64_t>(200'000 * view.time_factor);
  for (std::int64_t t = 1000; t <= end_us; t += 1000) {
    std::size_t end = next;
    while (end < view.events.size() && view.events[end].t_us <= t) ++end;
    tracker.process(std::span(view.events).subspan(next, end - next), nullptr);
    tracker.advance_to(t, nullptr);
    next = end;
  }
  const Estimate found = tracker.estimate();
  ASSERT_TRUE(found.valid);
  EXPECT_GE(found.score, tracker.threshold());
  EXPECT_NEAR(found.circle.x_px, view.disc.x_px, bound_px * std::max(1.0, view.px));
  EXPECT_NEAR(found.circle.y_px, view.disc.y_px, bound_px * std::max(1.0, view.px));
  EXPECT_NEAR(found.circle.r_px, view.disc.r_px, radius_bound_px * std::max(1.0, view.px));
}

INSTANTIATE_TEST_SUITE_P(Views, BallTrackerInvariance, testing::ValuesIn(views()),
                         [](const auto& view) { return view.param.name; });

}  // namespace
}  // namespace saccade
