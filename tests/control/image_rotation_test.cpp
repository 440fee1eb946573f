#include "control/image_rotation.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "head/icub_cameras.h"
#include "tests/control/malloc_count.h"
#include "tests/core/streams.h"

namespace saccade {
namespace {

/// Events of a room of short edges at `rest` rays while the camera turns at a constant rate (rad/s, camera frame): each edge
/// is a segment of seven points whose pixels fire whenever the point enters another one. `moving`: how many of the edges
/// are on an object with a motion of its own, to the right.
std::vector<Event> events_of(const Camera& camera, const Eigen::Vector3d& rate_rad_s, double duration_s,
                             int moving = 0) {
  constexpr int edges = 60;
  std::vector<Event> events;
  for (int edge = 0; edge < edges; ++edge) {
    const double u = 16.0 * (edge % 10) - 20.0 + 3.0 * (edge / 10);
    const double v = 24.0 * (edge / 10) - 5.0;
    const double tilt = 0.7 * edge;
    for (int point = -6; point <= 6; ++point) {
      Eigen::Vector3d ray = camera.ray(u + 0.5 * point * std::cos(tilt), v + 0.5 * point * std::sin(tilt));
      if (!ray.allFinite()) continue;
      Eigen::Vector2i last(-1, -1);
      for (double t_s = 0.0; t_s < duration_s; t_s += 0.0002) {
        const Eigen::Vector3d rate = edge < moving ? Eigen::Vector3d(0.0, -2.0, 0.0) : rate_rad_s;
        const auto pixel = camera.project(Eigen::AngleAxisd(-rate.norm() * t_s, rate.normalized()) * ray);
        if (!pixel) continue;
        const Eigen::Vector2i at(static_cast<int>(std::lround(pixel->x())),
                                 static_cast<int>(std::lround(pixel->y())));
        if (at == last || !camera.size.contains(at.x(), at.y())) continue;
        last = at;
        events.push_back({std::llround(t_s * 1e6), static_cast<std::uint16_t>(at.x()),
                          static_cast<std::uint16_t>(at.y()), true, 0});
      }
    }
  }
  std::ranges::stable_sort(events, {}, &Event::t_us);
  return events;
}

/// The last rotation that the events show. `start_us`: before all of them.
Eigen::Vector3d seen_in(const std::vector<Event>& events, const Camera& camera, std::int64_t start_us = 0) {
  ImageRotation image(camera);
  Eigen::Vector3d seen = Eigen::Vector3d::Constant(std::nan(""));
  auto next = events.begin();
  for (std::int64_t t_us = start_us + 1000; t_us <= events.back().t_us; t_us += 1000) {
    const auto end = std::ranges::upper_bound(next, events.end(), t_us, {}, &Event::t_us);
    image.process({next, end});
    next = end;
    if (const auto found = image.advance_to(t_us)) seen = *found;
  }
  return seen;
}

TEST(ImageRotation, FindsTheRotationOfTheCameraAboutEveryAxis) {
  const Camera camera = icub_left_2016.without_lens();
  for (const Eigen::Vector3d& rate :
       {Eigen::Vector3d(0.0, 0.5, 0.0), Eigen::Vector3d(-0.4, 0.0, 0.0), Eigen::Vector3d(0.2, -0.3, 0.4)}) {
    const Eigen::Vector3d seen = seen_in(events_of(camera, rate, 0.2), camera);
    // Plane fits on these short edges are up to a quarter too fast.
    EXPECT_LT((seen - rate).norm(), 0.3 * rate.norm()) << seen.transpose();
    EXPECT_GT(seen.normalized().dot(rate.normalized()), 0.98);
  }
}

TEST(ImageRotation, AnObjectWithAMotionOfItsOwnHardlyChangesIt) {
  const Camera camera = icub_left_2016.without_lens();
  const Eigen::Vector3d rate(0.0, 0.5, 0.0);
  const Eigen::Vector3d seen = seen_in(events_of(camera, rate, 0.2, 12), camera);
  EXPECT_LT((seen - rate).norm(), 0.25 * rate.norm()) << seen.transpose();
}

TEST(ImageRotation, IsTheSameAtTheEarliestAndTheLatestTimeStamps) {
  const Camera camera = icub_left_2016.without_lens();
  const std::vector<Event> events = events_of(camera, {0.0, 0.5, 0.0}, 0.05);
  const Eigen::Vector3d expected = seen_in(events, camera);
  ASSERT_TRUE(expected.allFinite());
  for (const std::int64_t shift_us : streams::shifts_to_the_ends_of_time(events.back().t_us))
    EXPECT_EQ(seen_in(streams::shifted(events, shift_us), camera, shift_us), expected) << shift_us;
}

TEST(ImageRotation, AFewEventsShowNoRotation) {
  ImageRotation image{icub_left_2016};
  const Event event{500, 60, 60, true, 0};
  image.process({&event, 1});
  EXPECT_FALSE(image.advance_to(1000));
}

TEST(ImageRotation, IgnoresEventsOutsideTheImageAndAllocatesNothing) {
  const Camera camera = icub_left_2016.without_lens();
  std::vector<Event> events = events_of(camera, {0.0, 0.5, 0.0}, 0.05);
  events.push_back({60'000, 500, 3, true, 0});
  ImageRotation image(camera);
  const long before = malloc_count();
  image.process(events);
  static_cast<void>(image.advance_to(60'000));
  EXPECT_EQ(malloc_count(), before);
}

}  // namespace
}  // namespace saccade
