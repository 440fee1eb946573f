#include "apps/serve/image_pace.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "apps/serve/moving_speed.h"

namespace saccade {
namespace {

/// A served world in virtual time: a tick costs tick_us, an image image_us more. It draws an image as soon as `pace` permits,
/// as under fast motion.
struct BusyWorld {
  std::int64_t tick_us = 200;
  std::int64_t image_us = 0;
  std::int64_t images = 0;
  std::int64_t latest_us = 0;
  std::int64_t longest_us = 0;  // between images

  ImagePace run(std::int64_t ticks) {
    ImagePace pace(1000);
    std::int64_t wall_us = 0, image_at_us = 0;
    for (std::int64_t t_us = 1000; t_us <= 1000 * ticks; t_us += 1000) {
      wall_us = std::max(wall_us, t_us);
      latest_us = std::max(latest_us, wall_us - t_us);
      const std::int64_t held_us = pace.next(wall_us - t_us, image_at_us);
      wall_us += tick_us;
      if (t_us - image_at_us < held_us) continue;
      longest_us = std::max(longest_us, t_us - image_at_us);
      image_at_us = t_us;
      ++images;
      wall_us += image_us;
    }
    return pace;
  }
};

TEST(ImagePace, AServeThatKeepsPaceDrawsAsConfigured) {
  BusyWorld world{.image_us = 700};
  const ImagePace pace = world.run(1000);
  EXPECT_EQ(world.images, 1000);
  EXPECT_EQ(pace.held_share(), 0.0);
  EXPECT_EQ(pace.summary(), "images at least 1 ms apart");
}

TEST(ImagePace, ImagesThatTakeTooLongComeLessOftenAndTimeKeepsPace) {
  for (const std::int64_t image_us : {1500, 3000, 6000}) {
    BusyWorld world{.image_us = image_us};
    const ImagePace pace = world.run(5000);
    EXPECT_LE(world.latest_us, image_us + ImagePace::usual_late_us) << image_us;
    EXPECT_LE(world.longest_us, ImagePace::longest_us) << image_us;
    // What the ticks leave is used for images.
    EXPECT_GT(static_cast<double>(world.images * image_us), 0.9 * 0.8 * 5e6) << image_us;
    EXPECT_GT(pace.held_share(), 0.1) << image_us;
    EXPECT_GT(pace.held_interval_ms(), 1.2e-3 * static_cast<double>(image_us)) << image_us;
  }
}

TEST(ImagePace, TheIntervalIsBoundedHoweverLongAnImageTakes) {
  BusyWorld world{.image_us = 50'000};
  const ImagePace pace = world.run(1000);
  EXPECT_EQ(world.longest_us, ImagePace::longest_us);
  EXPECT_EQ(pace.longest_interval_ms(), 10.0);
  EXPECT_THAT(pace.summary(),
              testing::MatchesRegex(
                  "images at least 1 ms apart; held back in 99.* % of the time, then 10.0 ms apart"));
}

TEST(ImagePace, IsBackAtTheUsualIntervalWithTheFirstTickInTime) {
  ImagePace pace(1000);
  EXPECT_EQ(pace.next(0, 0), 1000);
  EXPECT_EQ(pace.next(2'000, 1'000), 1000) << "any thread wakes up late";
  EXPECT_EQ(pace.next(2'001, 2'000), 10'000);
  EXPECT_EQ(pace.next(500'000, 2'000), 10'000);
  EXPECT_EQ(pace.next(0, 9'000), 1000);
  EXPECT_EQ(pace.next(0, 10'000), 1000);
  EXPECT_NEAR(pace.held_share(), 1.0 / 3.0, 1e-9);
  EXPECT_EQ(pace.held_interval_ms(), 7.0);
}

TEST(ImagePace, ALongerConfiguredIntervalStays) {
  ImagePace pace(20'000);
  EXPECT_EQ(pace.next(500'000, 0), 20'000);
  EXPECT_EQ(pace.held_share(), 0.0);
}

/// What measure_speed() finds where a tick takes tick_ms, and each tenth one keyframe_ms.
MovingSpeed measured(double tick_ms, double keyframe_ms) {
  double now_s = 100.0;
  int ticks = 0;
  const auto tick = [&] {
    const bool draws = ++ticks % 10 == 0;
    now_s += 1e-3 * (draws ? keyframe_ms : tick_ms);
    return draws;
  };
  return measure_speed(
      tick, [&] { return now_s; }, 0.5, 2);
}

TEST(MovingSpeed, IsTheSimulatedTimeInASecondAndTheTimeOfAKeyframe) {
  const MovingSpeed speed = measured(0.2, 2.2);
  EXPECT_NEAR(speed.simulated_per_s(), 2.5, 0.02);
  EXPECT_NEAR(speed.keyframe_ms, 2.2, 1e-6);
  EXPECT_NEAR(speed.wall_s, 0.5, 0.0025);
}

TEST(MovingSpeed, WaitsForTheKeyframesOfASlowMachineButNotForEver) {
  EXPECT_NEAR(measured(30.0, 100.0).keyframe_ms, 100.0, 1e-6);
  EXPECT_GE(measured(30.0, 100.0).wall_s, 0.5);
  double now_s = 0.0;
  const MovingSpeed none = measure_speed(
      [&] {
        now_s += 0.01;
        return false;
      },
      [&] { return now_s; }, 0.5, 2);
  EXPECT_EQ(none.keyframe_ms, 0.0);
  EXPECT_NEAR(none.wall_s, 2.0, 0.011);
}

TEST(MovingSpeed, KeyframesGetTheSamplesWithWhichTheyTakeSixMilliseconds) {
  EXPECT_EQ(bearable_samples(5, 0.0), 5);
  EXPECT_EQ(bearable_samples(5, 6.0), 5);
  EXPECT_EQ(bearable_samples(5, 9.0), 3);
  EXPECT_EQ(bearable_samples(5, 13.0), 2);
  EXPECT_EQ(bearable_samples(5, 40.0), 2);
  EXPECT_EQ(bearable_samples(5, 4000.0), 2);
  EXPECT_EQ(bearable_samples(2, 4000.0), 2);
}

TEST(ServedWork, AFastMachineIsToldItsSpeedAndNothingIsLowered) {
  const MovingSpeed fast{1.5, 0.5, 5.0};
  ASSERT_TRUE(fits_usual(fast));
  const ServedWork work = served_work(fast, {}, 5);
  EXPECT_EQ(work.keyframe_samples, 5);
  EXPECT_THAT(work.lines, testing::ElementsAre(
                              "with moving eyes this machine simulates 3.00 s per s, a keyframe takes 5 ms"));
}

TEST(ServedWork, ASlowMachineIsWarnedOfWithFigureAndKeys) {
  const MovingSpeed usual{0.2, 0.5, 40.0};
  ASSERT_FALSE(fits_usual(usual));
  const ServedWork lowered = served_work(usual, {1.0, 0.5, 8.0}, 5);
  EXPECT_EQ(lowered.keyframe_samples, 2);
  EXPECT_THAT(lowered.lines, testing::ElementsAre(testing::HasSubstr("0.40 s per s"),
                                                  testing::HasSubstr("render.keyframe_samples"),
                                                  testing::HasSubstr("up to 10 ms apart")))
      << "fast enough with less work";
  const ServedWork slow = served_work(usual, {0.25, 0.5, 20.0}, 5);
  EXPECT_THAT(slow.lines.back(),
              testing::AllOf(testing::StartsWith("warning: this machine is too slow for real time"),
                             testing::HasSubstr("takes 2.0 s"), testing::HasSubstr("camera.width_px")));
  EXPECT_THAT(served_work(usual, {0.6, 0.5, 20.0}, 5).lines.back(),
              testing::StartsWith("warning: this machine is hardly fast enough"));
}

}  // namespace
}  // namespace saccade
