#include "core/tracker/polar_patch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/tracker/patch_network.h"
#include "tests/core/streams.h"

namespace saccade {
namespace {

const std::shared_ptr<const BestModel> model = best_model_of({});

constexpr ImageSize patch_image{128, 128};
constexpr double x_px_s = 120.0, y_px_s = 50.0;
constexpr streams::MovingDisc ball{30, 40, x_px_s, y_px_s, 12};
const PatchMotion ball_motion{{x_px_s, y_px_s}, {0, 0}, 0};
constexpr std::int64_t end_us = 300'000;

TimeSurface patch_surface(const std::vector<Event>& events) {
  TimeSurface surface(patch_image);
  for (const Event& e : events) surface.add(e);
  return surface;
}

Circle ball_at_end() { return {ball.x_at(end_us), ball.y_at(end_us), ball.r_px}; }

PolarPatch patch_of(const std::vector<Event>& events, const Circle& circle,
                    const PatchMotion& motion = ball_motion, std::int64_t now_us = end_us) {
  return polar_patch(patch_surface(events), circle, motion, now_us);
}

/// Sum over all directions of a ring, in one channel.
double in_ring(const PolarPatch& patch, std::size_t ring, std::size_t channel) {
  double sum = 0.0;
  for (std::size_t d = 0; d < PolarPatch::directions; ++d)
    sum += static_cast<double>(patch.values[(d * PolarPatch::rings + ring) * PolarPatch::channels + channel]);
  return sum;
}

TEST(PolarPatch, EventsOfAMovingOutlineLieInTheRingOfTheOutline) {
  const PolarPatch patch = patch_of(ball.events(patch_image, 0.3), ball_at_end());
  for (const std::size_t channel : {1U, 5U}) {  // ON and OFF, moved with the disc, 8 px
    const double outline =
        in_ring(patch, 6, channel) + in_ring(patch, 7, channel) + in_ring(patch, 8, channel);
    double elsewhere = 0.0;
    for (const std::size_t ring : {0U, 1U, 2U, 3U, 4U, 10U, 11U, 12U, 13U})
      elsewhere += in_ring(patch, ring, channel);
    EXPECT_GT(outline, 10.0 * elsewhere) << "channel " << channel;
  }
}

TEST(PolarPatch, IsSharpestForTheMotionOfTheDisc) {
  const std::vector<Event> events = ball.events(patch_image, 0.3);
  const PolarPatch moved = patch_of(events, ball_at_end());
  const PolarPatch still = patch_of(events, ball_at_end(), {{0, 0}, {0, 0}, 0});
  EXPECT_GT(in_ring(moved, 7, 5), 1.5 * in_ring(still, 7, 5));
}

TEST(PolarPatch, IsTheSameInSlowMotion) {
  std::vector<Event> events = ball.events(patch_image, 0.3);
  const PolarPatch fast = patch_of(events, ball_at_end());
  for (Event& e : events) e.t_us *= 4;
  const PolarPatch slow = patch_of(events, ball_at_end(), {ball_motion.disc_px_s / 4, {0, 0}, 0}, 4 * end_us);
  for (std::size_t i = 0; i < fast.values.size(); ++i) {
    const std::size_t channel = i % PolarPatch::channels;
    // The background stands still: its events count by time. The shares of speeds have a speed of 4 px/s added.
    if (channel == 2 || channel == 3 || channel == 6 || channel == 7) continue;
    EXPECT_NEAR(fast.values[i], slow.values[i], channel > 8 ? 0.1F : 0.02F) << "value " << i;
  }
}

TEST(PolarPatch, TellsWhichPartIsOutsideTheImage) {
  const PolarPatch patch = patch_of({}, {2, 64, 12});
  const auto inside = [&](std::size_t direction, std::size_t ring) {
    return patch.values[(direction * PolarPatch::rings + ring) * PolarPatch::channels + 8];
  };
  EXPECT_EQ(inside(0, 7), 1.0F);                           // to the right
  EXPECT_EQ(inside(PolarPatch::directions / 2, 7), 0.0F);  // to the left
  EXPECT_EQ(in_ring(patch_of({}, {64, 64, 12}), 13, 8), PolarPatch::directions);
}

TEST(PolarPatch, WithoutEventsEveryDensityIsZero) {
  const PolarPatch patch = patch_of({}, ball_at_end());
  for (std::size_t ring = 0; ring < PolarPatch::rings; ++ring) {
    for (std::size_t channel = 0; channel < PolarPatch::event_channels; ++channel)
      EXPECT_EQ(in_ring(patch, ring, channel), 0.0);
  }
}

TEST(PatchNetwork, PrefersTheDiscToCirclesBesideItAndOfOtherSize) {
  const std::vector<Event> events = ball.events(patch_image, 0.3);
  const Circle c = ball_at_end();
  const double here = run_patch_network(model->patch, patch_of(events, c)).log_odds;
  EXPECT_GT(here, 0.0);
  for (const Circle& other : {Circle{c.x_px + 10, c.y_px, c.r_px}, Circle{c.x_px, c.y_px - 10, c.r_px},
                              Circle{c.x_px, c.y_px, 1.5 * c.r_px}, Circle{c.x_px, c.y_px, 0.6 * c.r_px}})
    EXPECT_LT(run_patch_network(model->patch, patch_of(events, other)).log_odds, here - 1.0)
        << "at " << other.x_px << ", " << other.y_px << ", radius " << other.r_px;
}

TEST(PatchNetwork, ItsCorrectionLeadsTowardsTheDisc) {
  const std::vector<Event> events = ball.events(patch_image, 0.3);
  const Circle c = ball_at_end();
  const auto error_px = [&](const Circle& at) {
    return std::hypot(at.x_px - c.x_px, at.y_px - c.y_px) + std::abs(at.r_px - c.r_px);
  };
  for (const Circle& start : {Circle{c.x_px + 3, c.y_px, c.r_px}, Circle{c.x_px - 2, c.y_px + 2, c.r_px},
                              Circle{c.x_px, c.y_px, c.r_px + 2}, Circle{c.x_px, c.y_px, c.r_px - 2}}) {
    const Circle off = run_patch_network(model->patch, patch_of(events, start)).correction;
    EXPECT_LT(error_px({start.x_px + off.x_px, start.y_px + off.y_px, start.r_px + off.r_px}),
              0.7 * error_px(start))
        << "from " << start.x_px << ", " << start.y_px << ", radius " << start.r_px;
  }
}

TEST(PatchNetwork, ItsDeviationsCoverTheErrorOfTheCorrectedCircle) {
  const std::vector<Event> events = ball.events(patch_image, 0.3);
  const Circle c = ball_at_end();
  for (const Circle& start : {c, Circle{c.x_px + 2, c.y_px, c.r_px}, Circle{c.x_px, c.y_px - 2, c.r_px},
                              Circle{c.x_px, c.y_px, c.r_px + 1.5}, Circle{c.x_px, c.y_px, c.r_px - 1.5}}) {
    const PatchOutput j = run_patch_network(model->patch, patch_of(events, start));
    EXPECT_LT(j.centre_sd_px, 1.5);
    EXPECT_LT(j.radius_sd_px, 1.5);
    EXPECT_LT(std::abs(start.x_px + j.correction.x_px - c.x_px), 3.0 * j.centre_sd_px);
    EXPECT_LT(std::abs(start.y_px + j.correction.y_px - c.y_px), 3.0 * j.centre_sd_px);
    EXPECT_LT(std::abs(start.r_px + j.correction.r_px - c.r_px), 3.0 * j.radius_sd_px);
  }
}

TEST(PatchNetwork, IsLessSureOfALargeCircleInPixels) {
  const auto radius_sd_px = [](double r_px) {
    const streams::MovingDisc disc{50, 60, 60.0, 20.0, r_px};
    const Circle circle{disc.x_at(end_us), disc.y_at(end_us), r_px};
    return run_patch_network(model->patch,
                             patch_of(disc.events(patch_image, 0.3), circle, {{60.0, 20.0}, {0, 0}, 0}))
        .radius_sd_px;
  };
  EXPECT_GT(radius_sd_px(30.0), radius_sd_px(8.0));
}

TEST(PatchNetwork, FindsNoBallWithoutEvents) {
  EXPECT_LT(run_patch_network(model->patch, patch_of({}, ball_at_end())).log_odds, 0.0);
}

}  // namespace
}  // namespace saccade
