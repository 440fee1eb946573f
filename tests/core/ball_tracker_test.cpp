#include "core/tracker/ball_tracker.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/random.h"
#include "head/icub_cameras.h"
#include "tests/core/allocation_counter.h"
#include "tests/core/streams.h"

namespace saccade {
namespace {

const Camera camera = icub_left_2016;

BallTrackerConfig radii(double smallest, double largest) {
  BallTrackerConfig config;
  config.radius_px = {smallest, largest};
  return config;
}

/// Passes events tick by tick until `end_us`, then tells the estimate.
class Player {
 public:
  Player(BallTracker& tracker, std::vector<Event> events) : tracker_(tracker), events_(std::move(events)) {}
  Estimate until(std::int64_t end_us, const CameraMotion* motion = nullptr) {
    for (; now_us_ < end_us; now_us_ += 1000) {
      std::size_t end = next_;
      while (end < events_.size() && events_[end].t_us <= now_us_ + 1000) ++end;
      tracker_.process(std::span(events_).subspan(next_, end - next_), motion);
      tracker_.advance_to(now_us_ + 1000, motion);
      next_ = end;
    }
    return tracker_.estimate();
  }

 private:
  BallTracker& tracker_;
  std::vector<Event> events_;
  std::size_t next_ = 0;
  std::int64_t now_us_ = 0;
};

TEST(BallTracker, FollowsAFastBallToHalfAPixelWithoutLag) {
  const streams::MovingDisc disc{20, 40, 500, 150, 12};
  BallTracker tracker(radii(6, 20), camera);
  Player player(tracker, disc.events(camera.size, 0.15));
  std::vector<double> along;
  for (std::int64_t t = 50'000; t <= 150'000; t += 1000) {
    const Estimate e = player.until(t);
    ASSERT_TRUE(e.valid);
    EXPECT_GE(e.score, tracker.threshold());
    EXPECT_NEAR(e.circle.r_px, disc.r_px, 0.6);
    along.push_back(((e.circle.x_px - disc.x_at(t)) * 500 + (e.circle.y_px - disc.y_at(t)) * 150) /
                    std::hypot(500, 150));
  }
  std::nth_element(along.begin(), along.begin() + 50, along.end());
  EXPECT_NEAR(along[50], 0.0, 0.5);  // 1 ms of lag would be 0.52 px
}

TEST(BallTracker, CountsABurstOfAPixelAsOneEdge) {
  // Every pixel makes five more events within burst_us, as under high contrast: they lie on no plane.
  const streams::MovingDisc disc{20, 40, 500, 150, 12};
  std::vector<Event> bursts;
  for (const Event& first : disc.events(camera.size, 0.12)) {
    for (int i = 0; i < 6; ++i) {
      bursts.push_back(first);
      bursts.back().t_us += i * 90;
    }
  }
  std::stable_sort(bursts.begin(), bursts.end(),
                   [](const Event& a, const Event& b) { return a.t_us < b.t_us; });
  BallTracker plain(radii(6, 20), camera);
  BallTracker burst(radii(6, 20), camera);
  const Estimate expected = Player(plain, disc.events(camera.size, 0.12)).until(120'000);
  const Estimate e = Player(burst, bursts).until(120'000);
  // The networks look at the newest event of a pixel, up to 0.45 ms younger here. With each event as an edge: 0.11 px.
  EXPECT_NEAR(e.circle.x_px, expected.circle.x_px, 0.02);
  EXPECT_NEAR(e.circle.r_px, expected.circle.r_px, 0.02);
  EXPECT_NEAR(e.score, expected.score, 0.02);
}

TEST(BallTracker, WorkAheadChangesNoEstimate) {
  const streams::MovingDisc disc{20, 40, 500, 150, 12};
  BallTracker late(radii(6, 20), camera);
  BallTracker ahead(radii(6, 20), camera);
  Player late_player(late, disc.events(camera.size, 0.15));
  Player ahead_player(ahead, disc.events(camera.size, 0.15));
  bool found = false;
  for (std::int64_t t = 1'000; t <= 200'000; t += 1000) {
    const Estimate expected = late_player.until(t);
    const Estimate e = ahead_player.until(t);
    ASSERT_EQ(e.valid, expected.valid) << t;
    ASSERT_EQ(e.circle.x_px, expected.circle.x_px) << t;
    ASSERT_EQ(e.circle.r_px, expected.circle.r_px) << t;
    ASSERT_EQ(e.score, expected.score) << t;
    found = found || e.valid;
    ahead.work_ahead();
    ahead.work_ahead();  // nothing is left to do
  }
  EXPECT_TRUE(found);
}

TEST(BallTracker, HoldsABallThatStopsAndDeclaresTheEstimateHeld) {
  const streams::MovingDisc disc{30, 60, 300, 0, 12};
  BallTracker tracker(radii(6, 20), camera);
  Player player(tracker, disc.events(camera.size, 0.1));
  player.until(100'000);
  const Estimate e = player.until(1'100'000);
  ASSERT_TRUE(e.valid);
  EXPECT_TRUE(e.held);
  // At 300 px/s silence speaks after 2 px and 2 ms, and then the speed falls by a fifth each millisecond:
  // 0.6 + 1.9 + 1.2 px, and the last edge may be 1 ms old.
  EXPECT_NEAR(e.circle.x_px, disc.x_at(100'000), 4.0);
  EXPECT_NEAR(e.circle.y_px, disc.y_at(100'000), 1.0);
  EXPECT_FALSE(player.until(4'000'000).valid) << "not for ever";
}

TEST(BallTracker, APauseLongerThan64BitsHoldIsAsGoodAsAnyOtherLongOne) {
  // At every length of the first part, so that searches, looks and circles to try are under way in some.
  const streams::MovingDisc disc{20, 40, 500, 150, 12};
  const std::vector<Event> before = disc.events(camera.size, 0.12);
  const std::vector<Event> after = streams::MovingDisc{100, 90, -400, -200, 12}.events(camera.size, 0.05);
  constexpr std::int64_t begin_us = std::numeric_limits<std::int64_t>::min() / 1'000 * 1'000;
  const auto estimates = [&](std::size_t count, std::uint64_t pause_us) {
    BallTracker tracker(radii(6, 20), camera);
    for (const Event& event : streams::shifted(before, begin_us)) {
      if (count-- == 0) break;
      tracker.process({&event, 1}, nullptr);
    }
    std::vector<std::array<double, 4>> all;
    for (Event event : after) {
      event.t_us = static_cast<std::int64_t>(static_cast<std::uint64_t>(begin_us) + pause_us +
                                             static_cast<std::uint64_t>(event.t_us));
      tracker.process({&event, 1}, nullptr);
      const Estimate e = tracker.estimate();
      all.push_back({e.circle.x_px, e.circle.y_px, e.circle.r_px, e.valid ? e.score : -1.0});
    }
    return all;
  };
  constexpr std::uint64_t fits_us = std::uint64_t{1} << 62U;
  for (std::size_t count = before.size() / 2; count < before.size(); count += 389) {
    const auto expected = estimates(count, fits_us / 1'000 * 1'000);
    // The whole range but a second, and just too much.
    for (const std::uint64_t pause_us : {~std::uint64_t{0} - 1'000'000, (std::uint64_t{1} << 63U) + 5'000})
      ASSERT_EQ(estimates(count, pause_us / 1'000 * 1'000), expected) << count << " events, " << pause_us;
  }
}

TEST(BallTracker, HasNoEstimateAfterTheBallLeftTheImage) {
  const streams::MovingDisc disc{60, 60, 600, 0, 10};
  BallTracker tracker(radii(6, 20), camera);
  Player player(tracker, disc.events(camera.size, 0.2));
  ASSERT_TRUE(player.until(80'000).valid);
  const Estimate e = player.until(200'000);
  EXPECT_TRUE(!e.valid || e.score < tracker.threshold());
}

TEST(BallTracker, DoesNotDetectABallInNoise) {
  BallTracker tracker(radii(6, 20), camera);
  const RandomStream random(3, "noise");
  std::vector<Event> events;
  for (std::uint64_t i = 0; i < 100'000; ++i) {
    events.push_back({static_cast<std::int64_t>(10 * i), static_cast<std::uint16_t>(random.bits(0, i) % 128),
                      static_cast<std::uint16_t>(random.bits(1, i) % 128), random.bits(2, i) % 2 == 0, 0});
  }
  Player player(tracker, std::move(events));
  for (std::int64_t t = 1000; t <= 1'000'000; t += 1000) {
    const Estimate e = player.until(t);
    if (e.valid) {
      ASSERT_LT(e.score, tracker.threshold()) << t;
    }
  }
}

TEST(BallTracker, MovesTheEstimateWithTheCamerasRotationWithoutEvents) {
  // The ball stops in the room; then the camera turns to the right at 1 rad/s with nothing to be seen.
  const streams::MovingDisc disc{50, 60, 300, 0, 12};
  BallTracker tracker(radii(6, 20), camera);
  Player player(tracker, disc.events(camera.size, 0.1));
  CameraMotion still;
  player.until(160'000, &still);
  const Circle before = tracker.estimate().circle;
  CameraMotion turning;
  turning.angular_velocity_rad_s = {0.0, 1.0, 0.0};
  const Circle after = player.until(210'000, &turning).circle;
  const Eigen::Vector2d expected = *camera.project(Eigen::AngleAxisd(-0.05, Eigen::Vector3d::UnitY()) *
                                                   camera.ray(before.x_px, before.y_px));
  EXPECT_NEAR(after.x_px, expected.x(), 0.5);
  EXPECT_NEAR(after.y_px, expected.y(), 0.5);
}

TEST(BallTracker, PrefersAnObjectThatMovesByItselfWhileTheCameraTurns) {
  // Two discs: one is carried along as a thing in the room would be, the other stands still in the image, as
  // a ball does that the gaze follows.
  const double turn_rad_s = 0.6;
  const auto flow = camera.rotational_flow_px_s(camera.ray(90, 90), {0.0, turn_rad_s, 0.0});
  const streams::MovingDisc room{90, 90, flow.x(), flow.y(), 12};
  // A still disc is silent: it sways by a few pixels.
  std::vector<Event> events = room.events(camera.size, 0.6);
  for (int i = 0; i < 6; ++i) {
    const streams::MovingDisc sway{40.0 + (i % 2 == 0 ? 0 : 4), 40, i % 2 == 0 ? 40.0 : -40.0, 0, 12};
    for (Event e : sway.events(camera.size, 0.1)) {
      e.t_us += i * 100'000;
      events.push_back(e);
    }
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return a.t_us < b.t_us; });
  CameraMotion turning;
  turning.angular_velocity_rad_s = {0.0, turn_rad_s, 0.0};
  BallTracker tracker(radii(6, 20), camera);
  Player player(tracker, events);
  const Estimate e = player.until(600'000, &turning);
  ASSERT_TRUE(e.valid);
  EXPECT_NEAR(e.circle.x_px, 42, 4);
  EXPECT_NEAR(e.circle.y_px, 40, 3);
}

TEST(BallTracker, GivesTheSameEstimateWithOneCallOrACallPerMillisecond) {
  const std::vector<Event> events = streams::MovingDisc{30, 40, 400, 200, 15}.events(camera.size, 0.15);
  BallTracker asked(radii(6, 20), camera);
  BallTracker once(radii(6, 20), camera);
  Player player(asked, events);
  const Estimate a = player.until(150'000);
  once.process(events, nullptr);
  once.advance_to(150'000, nullptr);
  const Estimate b = once.estimate();
  EXPECT_EQ(a.circle.x_px, b.circle.x_px);
  EXPECT_EQ(a.circle.r_px, b.circle.r_px);
  EXPECT_EQ(a.score, b.score);
}

TEST(BallTracker, BeginsNoTrackInTheTimeWhoseWorkIsLeftOutAndFollowsTheOthersOn) {
  const streams::MovingDisc disc{20, 40, 500, 150, 12};
  BallTracker tracker(radii(6, 20), camera);
  Player player(tracker, disc.events(camera.size, 0.16));
  tracker.leave_out_work_before(60'000);
  EXPECT_FALSE(player.until(60'000).valid);
  ASSERT_TRUE(player.until(120'000).valid);
  tracker.leave_out_work_before(1'000'000);
  const Estimate e = player.until(150'000);
  ASSERT_TRUE(e.valid);
  EXPECT_NEAR(e.circle.x_px, disc.x_at(150'000), 1.0);
  EXPECT_NEAR(e.circle.r_px, disc.r_px, 1.0);
}

TEST(BallTracker, RejectsAConfigurationOutOfRange) {
  BallTrackerConfig config = radii(20, 6);
  config.threshold = 2.0;
  config.crossing_px = 0.0;
  try {
    BallTracker tracker(config, camera);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("radius_px"));
    EXPECT_THAT(error.what(), testing::HasSubstr("threshold"));
    EXPECT_THAT(error.what(), testing::HasSubstr("crossing_px"));
  }
}

}  // namespace
}  // namespace saccade
