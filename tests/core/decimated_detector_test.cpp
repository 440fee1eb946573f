#include "core/tracker/decimated_detector.h"

#include <gtest/gtest.h>

#include <array>
#include <string>

#include "core/tracker/ball_tracker.h"
#include "tests/core/allocation_counter.h"
#include "tests/core/streams.h"

namespace saccade {
namespace {

Camera wide_camera() {
  Camera camera;
  camera.size = {641, 480};
  camera.fx_px = camera.fy_px = 500;
  camera.cx_px = 320;
  camera.cy_px = 240;
  return camera;
}

BallTrackerConfig large_radii() {
  BallTrackerConfig config;
  config.radius_px = {70, 160};
  return config;
}

TEST(Decimated, TheCameraSeesAPointAtEveryNthPixel) {
  const Camera camera = wide_camera();
  for (const int step : {2, 3, 4}) {
    const Camera small = decimated(camera, step);
    const Eigen::Vector3d point(0.1, -0.05, 1.0);
    const Eigen::Vector2d in_small = *small.project(point) * step + Eigen::Vector2d::Constant(step / 2);
    EXPECT_LT((in_small - *camera.project(point)).norm(), 1e-9);
    EXPECT_LT((small.size.width - 1) * step + step / 2, camera.size.width);
    EXPECT_GE(small.size.width * step + step / 2, camera.size.width);
  }
}

struct Ball {
  std::array<double, 2> radii_px;
  double r_px;
};

class DecimatedBall : public testing::TestWithParam<Ball> {};

TEST_P(DecimatedBall, IsFoundWithoutAllocating) {
  const Camera camera = wide_camera();
  const streams::MovingDisc disc{180, 200, 800, 300, GetParam().r_px};
  const std::vector<Event> events = disc.events(camera.size, 0.2);
  BallTrackerConfig config;
  config.radius_px = GetParam().radii_px;
  const std::unique_ptr<Detector> tracker = make_ball_tracker(config, camera);
  std::size_t next = 0;
  const std::int64_t before = allocation_count();
  for (std::int64_t t_us = 1000; t_us <= 200'000; t_us += 1000) {
    std::size_t end = next;
    while (end < events.size() && events[end].t_us <= t_us) ++end;
    tracker->process(std::span(events).subspan(next, end - next), nullptr);
    tracker->advance_to(t_us, nullptr);
    next = end;
  }
  const Estimate found = tracker->estimate();
  EXPECT_EQ(allocation_count(), before);
  ASSERT_TRUE(found.valid);
  EXPECT_GE(found.score, tracker->threshold());
  EXPECT_NEAR(found.circle.x_px, disc.x_at(200'000), 4.0);
  EXPECT_NEAR(found.circle.y_px, disc.y_at(200'000), 4.0);
  EXPECT_NEAR(found.circle.r_px, disc.r_px, 3.0);
  // 4 px of the image are one of the tracker's.
  EXPECT_EQ(found.covariance_px2(0, 0) > 16 * 1.2 * 1.2, disc.r_px > 80.0);
}

INSTANTIATE_TEST_SUITE_P(Radii, DecimatedBall,
                         testing::Values(Ball{{70, 160}, 110}, Ball{{4, 144}, 110}, Ball{{4, 144}, 20}),
                         [](const auto& ball) {
                           return "Of" + std::to_string(static_cast<int>(ball.param.r_px)) + "PxFrom" +
                                  std::to_string(static_cast<int>(ball.param.radii_px[0]));
                         });

TEST(Decimated, RadiiWithinTheFittedOnesAreFollowedOnAllPixels) {
  BallTrackerConfig config;
  config.radius_px = {16, 80};
  EXPECT_NE(dynamic_cast<BallTracker*>(make_ball_tracker(config, wide_camera()).get()), nullptr);
  EXPECT_EQ(dynamic_cast<BallTracker*>(make_ball_tracker(large_radii(), wide_camera()).get()), nullptr);
  config.radius_px = {200, 70};
  EXPECT_THROW(static_cast<void>(make_ball_tracker(config, wide_camera())), InputError);
}

TEST(Decimated, CountsRejectedEventsOfAllPixels) {
  const std::unique_ptr<Detector> tracker = make_ball_tracker(large_radii(), wide_camera());
  const std::vector<Event> events = {streams::event_at(10, 641, 3, true),
                                     streams::event_at(20, 640, 479, true), streams::event_at(15, 1, 1, true),
                                     streams::event_at(30, 2, 2, true)};
  tracker->process(events, nullptr);
  EXPECT_EQ(tracker->rejected().outside_image, 1);
  EXPECT_EQ(tracker->rejected().back_in_time, 1);
}

TEST_P(DecimatedBall, ACopyGivesTheSameEstimatesAndHoughSpace) {
  const Camera camera = wide_camera();
  BallTrackerConfig config;
  config.radius_px = GetParam().radii_px;
  const std::vector<Event> events =
      streams::MovingDisc{180, 200, 800, 300, GetParam().r_px}.events(camera.size, 0.15);
  const std::unique_ptr<Detector> tracker = make_ball_tracker(config, camera);
  const std::size_t half = events.size() / 2;
  tracker->process(std::span(events).first(half), nullptr);
  const std::unique_ptr<Detector> copy = copy_of(*tracker);
  ASSERT_NE(copy, nullptr);
  for (Detector* detector : {tracker.get(), copy.get()}) {
    detector->process(std::span(events).subspan(half), nullptr);
    detector->advance_to(150'000, nullptr);
  }
  EXPECT_EQ(tracker->estimate().circle.x_px, copy->estimate().circle.x_px);
  EXPECT_EQ(tracker->estimate().score, copy->estimate().score);
}

}  // namespace
}  // namespace saccade
