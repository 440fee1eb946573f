#include "sim/sim_robot.h"

#include <gtest/gtest.h>

#include <array>
#include <numeric>

#include "core/error.h"
#include "sim/sim_eye.h"
#include "tests/robot/port_conformance.h"

namespace saccade {
namespace {

/// An eye of low resolution, so that many runs are fast, and a fast ball.
SimConfig small_world() {
  SimConfig config;
  config.camera = Camera{{64, 64}, 50.0, 50.0, 31.5, 31.5}.without_lens();
  config.render.supersampling = 1;
  config.world.ball.trajectory.kind = TrajectoryKind::circle;
  config.world.ball.trajectory.frequency_hz = 2.0;
  return config;
}

SimConfig still_world() {
  SimConfig config = small_world();
  config.world.ball.trajectory = TrajectoryConfig{};
  config.world.ball.trajectory.sway_m = 0.0;
  config.emulator = emulator_preset("ideal");
  return config;
}

RobotUnderTest simulated() {
  auto robot = std::make_shared<SimRobot>(small_world(), 1);
  return {robot, robot.get(), robot.get(), robot.get()};
}

SimConfig with_both_eyes(SimConfig config) {
  config.eyes = Eyes::both;
  config.right.camera = Camera{{64, 64}, 52.0, 52.0, 30.0, 33.0}.without_lens();
  return config;
}

RobotUnderTest simulated_with_both_eyes() {
  auto robot = std::make_shared<SimRobot>(with_both_eyes(small_world()), 1);
  return {robot, robot.get(), robot.get(), robot.get()};
}

INSTANTIATE_TEST_SUITE_P(Sim, PortConformance,
                         testing::Values(PortBackend{"Sim", simulated, true, false, 5000},
                                         PortBackend{"SimBothEyes", simulated_with_both_eyes, true, false,
                                                     5000}),
                         name_of_backend);

TEST(SimRobot, AStillHeadInAStillSceneGetsNoEvents) {
  SimRobot robot(still_world(), 3);
  HeadState state;
  robot.read(state);
  std::vector<Event> events;
  // The head sags by hundredths of a degree while its servos take the load; then nothing moves.
  robot.wait_until(500'000);
  robot.read_until(500'000, events);
  events.clear();
  robot.wait_until(1'500'000);
  robot.read_until(1'500'000, events);
  EXPECT_EQ(events.size(), 0U);
}

/// All events up to t_us, of one eye.
std::vector<Event> events_of(const SimConfig& config, std::uint64_t seed, std::uint8_t camera,
                             std::int64_t t_us, std::size_t threads = 1) {
  SimRobot robot(config, seed, threads);
  std::vector<Event> events;
  robot.wait_until(t_us);
  robot.read_until(t_us, events);
  std::erase_if(events, [&](const Event& e) { return e.camera != camera; });
  return events;
}

TEST(SimRobot, TheLeftEyesEventsDoNotDependOnTheRightEye) {
  SimConfig config = small_world();
  config.sampling = {10.0, 1.0};  // an image at every tick, for any motion
  const std::vector<Event> alone = events_of(config, 1, 0, 200'000);
  EXPECT_GT(alone.size(), 1000U);
  EXPECT_EQ(alone, events_of(with_both_eyes(config), 1, 0, 200'000));
}

TEST(SimRobot, EventsDoNotDependOnTheNumberOfThreads) {
  SimConfig config = with_both_eyes(small_world());
  for (const RenderMethod method : {RenderMethod::direct, RenderMethod::keyframes}) {
    config.render.method = method;
    const std::vector<Event> events = events_of(config, 1, 0, 100'000);
    EXPECT_GT(events.size(), 300U);
    EXPECT_EQ(events, events_of(config, 1, 0, 100'000, 3));
  }
}

TEST(SimRobot, TheEyesHaveDifferentNoiseThatDependsOnTheSeed) {
  SimConfig config = with_both_eyes(still_world());
  config.right.camera = config.camera;
  config.emulator.shot_noise_rate_hz = 10.0;
  const std::vector<Event> left = events_of(config, 5, 0, 200'000);
  std::vector<Event> right = events_of(config, 5, 1, 200'000);
  EXPECT_EQ(right, events_of(config, 5, 1, 200'000));
  EXPECT_NE(right, events_of(config, 6, 1, 200'000));
  ASSERT_GT(left.size(), 1000U);
  ASSERT_GT(right.size(), 1000U);
  const auto same = [](const Event& a, const Event& b) {
    return a.t_us == b.t_us && a.x == b.x && a.y == b.y;
  };
  int shared = 0;
  for (std::size_t i = 0, j = 0; i < left.size(); ++i) {
    while (j < right.size() && right[j].t_us < left[i].t_us) ++j;
    for (std::size_t k = j; k < right.size() && right[k].t_us == left[i].t_us; ++k) {
      shared += same(left[i], right[k]) ? 1 : 0;
    }
  }
  std::printf("%zu events left, %zu right, %d the same\n", left.size(), right.size(), shared);
  EXPECT_LT(shared, 5);  // with one random stream nearly all would be shared
}

TEST(SimRobot, EyesWithImagesOfDifferentSizesAreBadInput) {
  SimConfig config = with_both_eyes(small_world());
  config.right.camera.size = {64, 48};
  EXPECT_THROW(SimRobot(config, 1), InputError);
}

TEST(SimRobot, GroundTruthIsTheProjectionOfTheBallThroughThePlantsEye) {
  SimRobot robot(small_world(), 1);
  const Camera camera = small_world().camera;
  for (std::int64_t t_us = 1000; t_us <= 400'000; t_us += 1000) {
    robot.wait_until(t_us);
    const SimTruth& truth = robot.truth();
    ASSERT_EQ(truth.t_us, t_us);
    const Eigen::Vector3d in_cam_m = truth.left.root_from_cam.inverse() * truth.ball_m;
    const auto circle = camera.project_sphere(in_cam_m, 0.0475);
    ASSERT_TRUE(circle && truth.left.circle);
    EXPECT_NEAR(circle->x_px, truth.left.circle->x_px, 1e-12);
    EXPECT_NEAR(circle->r_px, truth.left.circle->r_px, 1e-12);
    EXPECT_GT(truth.left.visible, 0.8);
  }
}

/// A colour image at `t_us`, shifted by `shift_px`.
std::vector<float> colours_of(SimRobot& robot, std::int64_t t_us, const Eigen::Vector2d& shift_px) {
  const Camera camera = small_world().camera;
  std::vector<float> rgb(3 * static_cast<std::size_t>(camera.size.pixels()));
  robot.draw_left_eye(t_us, camera, shift_px, rgb);
  return rgb;
}

TEST(SimRobot, TheColourImageOfTheLeftEyeHasTheLuminanceOfItsDrawnImage) {
  SimConfig config = small_world();
  config.render.method = RenderMethod::direct;
  SimRobot robot(config, 1);
  robot.wait_until(150'000);
  while (robot.now_us() - robot.image_us() > World::tick_us)
    robot.wait_until(robot.now_us() + World::tick_us);
  const std::vector<float> rgb = colours_of(robot, robot.image_us(), {0, 0});
  const std::span<const float> luminance = robot.left_eye().image();
  for (std::size_t i = 0; i < luminance.size(); ++i) {
    const float sum =
        0.2126F * rgb[i] + 0.7152F * rgb[i + luminance.size()] + 0.0722F * rgb[i + 2 * luminance.size()];
    ASSERT_NEAR(sum, luminance[i], 1e-3) << "pixel " << i;
  }
}

TEST(SimRobot, AColourImageShiftedByAPixelIsTheSameImageOnePixelFurther) {
  SimRobot robot(small_world(), 1);
  const std::vector<float> here = colours_of(robot, 0, {0, 0});
  const std::vector<float> right = colours_of(robot, 0, {1, 0});
  const std::vector<float> below = colours_of(robot, 0, {0, 1});
  int differ = 0;
  for (std::size_t y = 0; y + 1 < 64; ++y) {
    for (std::size_t x = 0; x + 1 < 64; ++x) {
      differ += std::abs(right[y * 64 + x] - here[y * 64 + x + 1]) > 2.0F;
      differ += std::abs(below[y * 64 + x] - here[(y + 1) * 64 + x]) > 2.0F;
    }
  }
  std::printf("%d of %d values differ\n", differ, 2 * 63 * 63);
  EXPECT_LT(differ, 2 * 63 * 63 / 100);  // edges that rounding moves to another sample
}

TEST(SimRobot, BetweenTicksTheColourImageShowsTheInterpolatedBall) {
  SimRobot robot(small_world(), 1);
  robot.wait_until(150'000);
  const std::vector<float> end = colours_of(robot, 150'000, {0, 0});
  const auto change = [&](std::int64_t t_us) {
    const std::vector<float> then = colours_of(robot, t_us, {0, 0});
    double sum = 0.0;
    for (std::size_t i = 0; i < end.size(); ++i) sum += std::abs(then[i] - end[i]);
    return sum;
  };
  EXPECT_EQ(change(150'000), 0.0);
  EXPECT_GT(change(149'100), change(149'700));
}

TEST(SimRobot, EventsOfAMovingBallLieAtItsOutlineOrItsHand) {
  SimConfig config = small_world();
  config.lab.contrast = 0.0;
  SimRobot robot(config, 1);
  robot.wait_until(300'000);
  std::vector<Event> before;
  robot.read_until(300'000, before);
  std::vector<Event> events;
  robot.wait_until(310'000);
  robot.read_until(310'000, events);
  ASSERT_GT(events.size(), 20U);
  const Circle ball = *robot.truth().left.circle;
  int near = 0;
  for (const Event& e : events) {
    // Within the ball's disc and a margin for 10 ms of motion; the hand hangs below and to the sides.
    near += std::hypot(e.x - ball.x_px, e.y - ball.y_px) < ball.r_px + 3.0;
  }
  std::printf("%d of %zu events within 3 px of the ball's disc\n", near, events.size());
  EXPECT_GT(near, static_cast<int>(events.size()) / 3);
}

TEST(SimRobot, EventsComeAtMostFiveMillisecondsLateAndTheirStampsNeverGoBack) {
  SimConfig config = small_world();
  config.world.ball.trajectory.frequency_hz = 0.3;
  SimRobot robot(config, 1);
  std::vector<Event> events;
  std::int64_t latest_us = 0;
  std::int64_t newest_us = 0;
  std::int64_t count = 0;
  for (std::int64_t t_us = 1000; t_us <= 600'000; t_us += 1000) {
    robot.wait_until(t_us);
    events.clear();
    robot.read_until(t_us, events);
    for (const Event& e : events) {
      ASSERT_GE(e.t_us, newest_us);
      newest_us = e.t_us;
      latest_us = std::max(latest_us, t_us - e.t_us);
    }
    count += std::ssize(events);
    ASSERT_LE(robot.now_us() - robot.image_us(), 4000);
  }
  std::printf("%lld events in %lld images, at most %.3f ms late\n", static_cast<long long>(count),
              static_cast<long long>(robot.images()), 1e-3 * static_cast<double>(latest_us));
  EXPECT_GT(count, 1000);
  EXPECT_LT(latest_us, 5000);
  EXPECT_LT(robot.images(), 500);
}

TEST(SimRobot, TheVisibleShareDoesNotDependOnTheImageRate) {
  SimConfig often = small_world();
  SimConfig seldom = small_world();
  often.world.ball.trajectory.radius_a_m = seldom.world.ball.trajectory.radius_a_m = {0.0, 0.35, 0.0};
  often.sampling = {10.0, 1.0};
  SimRobot a(often, 1);
  SimRobot b(seldom, 1);
  double largest = 0.0;
  double least = 1.0;
  for (std::int64_t t_us = 1000; t_us <= 500'000; t_us += 1000) {
    a.wait_until(t_us);
    b.wait_until(t_us);
    ASSERT_EQ(a.truth().left.circle.has_value(), b.truth().left.circle.has_value());
    if (a.truth().left.circle) {
      ASSERT_EQ(a.truth().left.circle->x_px, b.truth().left.circle->x_px);
    }
    largest = std::max(largest, std::abs(a.truth().left.visible - b.truth().left.visible));
    least = std::min(least, a.truth().left.visible);
  }
  std::printf("visible from %.2f on; differs by at most %.3f\n", least, largest);
  EXPECT_LT(least, 0.6);     // it leaves the image
  EXPECT_LT(largest, 0.12);  // half a pixel of a disc of 5 px radius, and one sample per pixel
}

/// An eye of full resolution in a still head, and a ball on a circle without sway.
SimConfig labelled_world() {
  SimConfig config;
  config.labels = true;
  config.emulator = emulator_preset("ideal");
  config.world.ball.trajectory.kind = TrajectoryKind::circle;
  config.world.ball.trajectory.frequency_hz = 1.0;
  return config;
}

/// The pixels that an eye labels ball are those of its true circle.
void expect_the_ball_in_its_circle(const SimEye& eye) {
  const EyeTruth& truth = eye.truth();
  ASSERT_TRUE(truth.circle);
  const ImageSize size = eye.camera().size;
  int inside = 0;
  int of_the_disc = 0;
  int outside = 0;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const bool is_ball = eye.objects()[static_cast<std::size_t>(y * size.width + x)] ==
                           static_cast<std::uint8_t>(SceneObject::ball);
      const double off_px = std::hypot(x - truth.circle->x_px, y - truth.circle->y_px) - truth.circle->r_px;
      if (off_px < -1.0) {
        ++inside;
        of_the_disc += is_ball ? 1 : 0;
      }
      if (off_px > 2.0 && is_ball) ++outside;
    }
  }
  std::printf("circle at %.1f, %.1f: %d of %d pixels of the disc are labelled ball, %.2f visible\n",
              truth.circle->x_px, truth.circle->y_px, of_the_disc, inside, truth.visible);
  EXPECT_EQ(outside, 0);
  EXPECT_NEAR(static_cast<double>(of_the_disc) / inside, truth.visible, 0.1);
}

TEST(SimRobot, PixelsLabelledBallAreThoseOfTheTrueCircleInEitherEye) {
  SimConfig config = labelled_world();
  config.eyes = Eyes::both;
  config.right.mount = {{0.0, 0.0, -10.0}, {0.0, 2.0, 5.0}};
  config.sampling = {10.0, 1.0};  // an image at every tick
  config.world.ball.trajectory.frequency_hz = 4.0;
  SimRobot robot(config, 1);
  for (std::int64_t t_us = 25'000; t_us <= 225'000; t_us += 50'000) {
    robot.wait_until(t_us);
    expect_the_ball_in_its_circle(robot.left_eye());
    expect_the_ball_in_its_circle(*robot.right_eye());
  }
}

/// Number of events per SceneObject of a still eye in front of a moving ball.
std::array<int, 6> events_by_object(const SimConfig& config) {
  SimRobot robot(config, 1);
  std::vector<Event> events;
  robot.wait_until(100'000);  // the head sags a little while its servos take the load
  robot.read_until(100'000, events);
  std::array<int, 6> by_object{};
  for (std::int64_t t_us = 101'000; t_us <= 400'000; t_us += 1000) {
    robot.wait_until(t_us);
    robot.read_until(t_us, events);
    for (const EventLabel& label : robot.delivered_labels()) {
      ++by_object.at(label.object);
      EXPECT_EQ(label.cause, EventCause::signal);
    }
  }
  std::printf("events of ball %d, hand %d, arm %d, distractor %d, background %d\n", by_object[1],
              by_object[2], by_object[3], by_object[4], by_object[5]);
  EXPECT_GT(by_object[1], 1000);
  EXPECT_GT(by_object[2], 100);
  EXPECT_EQ(by_object[0] + by_object[4], 0);
  return by_object;
}

TEST(SimRobot, WithAStillEyeAllEventsOfDrawnImagesBelongToMovingObjects) {
  SimConfig config = labelled_world();
  config.render.method = RenderMethod::direct;
  EXPECT_EQ(events_by_object(config)[5], 0);
}

TEST(SimRobot, WithAStillEyeNearlyAllEventsOfReprojectedImagesBelongToMovingObjects) {
  const std::array<int, 6> by_object = events_by_object(labelled_world());
  EXPECT_LT(by_object[5], 0.02 * std::accumulate(by_object.begin(), by_object.end(), 0));
}

TEST(SimRobot, EachEventOfEitherEyeHasALabelAndLabelsChangeNoEvent) {
  SimConfig config = labelled_world();
  config.eyes = Eyes::both;
  SimRobot labelled(config, 1);
  config.labels = false;
  SimRobot plain(config, 1);
  std::vector<Event> events;
  std::vector<Event> plain_events;
  for (std::int64_t t_us = 1000; t_us <= 150'000; t_us += 1000) {
    labelled.wait_until(t_us);
    plain.wait_until(t_us);
    const auto before = std::ssize(events);
    labelled.read_until(t_us - t_us % 3000, events);  // sometimes before now
    plain.read_until(t_us, plain_events);
    ASSERT_EQ(std::ssize(labelled.delivered_labels()), std::ssize(events) - before);
    ASSERT_TRUE(plain.delivered_labels().empty());
  }
  EXPECT_GT(events.size(), 1000U);
  EXPECT_EQ(events, plain_events);
}

}  // namespace
}  // namespace saccade
