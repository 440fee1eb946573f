#include "evaluation/frame_camera/frame_detector.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>

#include "core/error.h"
#include "core/random.h"
#include "head/icub_cameras.h"

namespace saccade {
namespace {

constexpr std::array<double, 3> red = {0.65, 0.10, 0.07};
const Camera event_camera = icub_left_2016.without_lens();  // 128x128

FrameDetectorConfig small_balls() {
  FrameDetectorConfig config;
  config.radius_px = {4, 14};
  return config;
}

/// A disc before an even wall, in pixels of the event camera's image, that moves from where it is at time 0.
struct Scene {
  Circle ball{64, 64, 8};
  Eigen::Vector2d speed_px_s{0, 0};
  std::array<double, 3> colour = red;
  std::array<double, 3> wall = {0.5, 0.45, 0.4};
};

/// The frame camera's image of a scene, sampled at the pixels' shifted centres.
Shutter::Draw view_of(const Scene& scene, const Camera& camera) {
  return [scene, camera](std::int64_t t_us, const Eigen::Vector2d& shift_px, std::span<float> rgb) {
    const Eigen::Vector2d centre = Eigen::Vector2d(scene.ball.x_px, scene.ball.y_px) +
                                   1e-6 * static_cast<double>(t_us) * scene.speed_px_s;
    const auto pixels = static_cast<std::size_t>(camera.size.pixels());
    for (std::size_t i = 0; i < pixels; ++i) {
      const auto x = static_cast<double>(i % static_cast<std::size_t>(camera.size.width));
      const auto y = static_cast<double>(i / static_cast<std::size_t>(camera.size.width));
      const auto at = *event_camera.project(camera.ray(x + shift_px.x(), y + shift_px.y()));
      const auto& colour = (at - centre).norm() <= scene.ball.r_px ? scene.colour : scene.wall;
      for (std::size_t c = 0; c < 3; ++c) rgb[c * pixels + i] = static_cast<float>(255.0 * colour[c]);
    }
  };
}

/// The first image of a scene, and what is found in it.
Estimate find_in(const Scene& scene, const FrameDetectorConfig& config = small_balls()) {
  const FrameDetector detector(config, red, event_camera);
  Shutter shutter(detector.camera().size, config.exposure_ms);
  const auto image = shutter.expose(33'000, view_of(scene, detector.camera()));
  return detector.find(image.value());
}

TEST(FrameDetector, FindsADiscOfTheBallsColourWithinAPixelWhereverItIs) {
  const RandomStream dice(1, "frame_detector_test");
  double worst_px = 0.0;
  for (std::uint64_t i = 0; i < 40; ++i) {
    Scene scene;
    scene.ball.r_px = dice.uniform(4.0, 14.0, i, 0);
    scene.ball.x_px = dice.uniform(scene.ball.r_px, 127 - scene.ball.r_px, i, 1);
    scene.ball.y_px = dice.uniform(scene.ball.r_px, 127 - scene.ball.r_px, i, 2);
    const Estimate found = find_in(scene);
    ASSERT_TRUE(found.valid) << "x " << scene.ball.x_px << " y " << scene.ball.y_px;
    EXPECT_FALSE(found.held);
    EXPECT_GE(found.score, small_balls().threshold) << "r " << scene.ball.r_px;
    worst_px = std::max({worst_px, std::abs(found.circle.x_px - scene.ball.x_px),
                         std::abs(found.circle.y_px - scene.ball.y_px),
                         std::abs(found.circle.r_px - scene.ball.r_px)});
  }
  std::printf("worst error %.2f px\n", worst_px);
  EXPECT_LT(worst_px, 1.0);
}

TEST(FrameDetector, ReturnsTheCircleInTheEventCamerasDistortedImage) {
  const Camera behind_lens = icub_left_2016;
  const FrameDetector detector(small_balls(), red, behind_lens);
  const Camera& frame = detector.camera();
  double worst_px = 0.0;
  double most_moved_px = 0.0;
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(160, 120), {60, 20}, {255, 215}, {65, 220}, {250, 25}}) {
    const double r_px = 13.0;
    Shutter shutter(frame.size, 20.0);
    const auto image = shutter.expose(33'000, [&](std::int64_t, const Eigen::Vector2d& shift_px, auto rgb) {
      for (std::size_t i = 0; i < rgb.size(); ++i) {
        const auto pixel = static_cast<int>(i % static_cast<std::size_t>(frame.size.pixels()));
        const Eigen::Vector2d here(pixel % frame.size.width, pixel / frame.size.width);
        const std::size_t colour = i / static_cast<std::size_t>(frame.size.pixels());
        rgb[i] = (here + shift_px - at).norm() <= r_px ? static_cast<float>(255.0 * red[colour]) : 128.0F;
      }
    });
    const Estimate found = detector.find(image.value());
    ASSERT_TRUE(found.valid) << at.transpose();
    const double radius = r_px / frame.fx_px;
    const Eigen::Vector2d ray = frame.ray(at.x(), at.y()).head<2>();
    const Circle seen = *behind_lens.project_ellipse(ray, {radius, 0.0}, {0.0, radius});
    worst_px = std::max({worst_px, std::abs(found.circle.x_px - seen.x_px),
                         std::abs(found.circle.y_px - seen.y_px), std::abs(found.circle.r_px - seen.r_px)});
    const Circle unmoved = *behind_lens.without_lens().project_ellipse(ray, {radius, 0.0}, {0.0, radius});
    most_moved_px = std::max(most_moved_px, std::hypot(seen.x_px - unmoved.x_px, seen.y_px - unmoved.y_px));
  }
  std::printf("worst error %.2f px, where the lens moves by up to %.2f px\n", worst_px, most_moved_px);
  EXPECT_LT(worst_px, 1.0);
  EXPECT_GT(most_moved_px, 3.0);
}

TEST(FrameDetector, FindsTheBallInShadowAndInBrightLight) {
  for (const double light : {0.15, 0.5, 1.4}) {
    Scene scene;
    for (double& value : scene.colour) value *= light;
    EXPECT_GE(find_in(scene).score, small_balls().threshold) << "light " << light;
  }
}

TEST(FrameDetector, FindsNothingWhereNothingHasTheBallsColour) {
  Scene scene;
  for (const std::array<double, 3>& colour :
       {scene.wall, {0.0, 0.0, 0.0}, {0.62, 0.43, 0.33}, {0.1, 0.1, 0.6}}) {
    scene.colour = colour;
    EXPECT_FALSE(find_in(scene).valid) << "red " << colour[0];
  }
}

TEST(FrameDetector, FindsNothingOfASizeOutsideTheRangeOrOutsideTheEventCamerasImage) {
  Scene scene;
  scene.ball.r_px = 25;
  EXPECT_FALSE(find_in(scene).valid);
  FrameDetectorConfig config = small_balls();
  config.radius_px = {20, 30};
  EXPECT_TRUE(find_in(scene, config).valid);
  scene.ball = {-6, 64, 5};  // inside the frame camera's image
  EXPECT_FALSE(find_in(scene).valid);
}

TEST(FrameDetector, LosesAFastBallToBlurAndFindsItAgainWithAShortExposure) {
  Scene scene;
  scene.ball = {40, 64, 7};
  for (const double speed_px_s : {0.0, 100.0, 1000.0}) {
    scene.speed_px_s = {speed_px_s, 0};
    const bool fast = speed_px_s > 500.0;  // 20 ms at 1000 px/s: a smear of 20 px behind a ball of 14 px
    const Estimate found = find_in(scene);
    EXPECT_EQ(found.valid && found.score >= small_balls().threshold, !fast) << speed_px_s << " px/s";
    FrameDetectorConfig sport = small_balls();
    sport.exposure_ms = 1.0;
    EXPECT_GE(find_in(scene, sport).score, sport.threshold) << speed_px_s << " px/s";
  }
}

TEST(FrameDetector, ReturnsThePositionOfASlowBallInTheMiddleOfTheExposure) {
  Scene scene;
  scene.speed_px_s = {150, 0};
  EXPECT_NEAR(find_in(scene).circle.x_px, 64 + 150 * 0.010, 0.5);
}

TEST(FrameDetector, ConfigurationsOutOfRangeAndBlackBallsAreBadInput) {
  FrameDetectorConfig config;
  config.exposure_ms = 34.0;  // longer than from one image to the next
  EXPECT_THROW(FrameDetector(config, red, event_camera), InputError);
  EXPECT_THROW(FrameDetector({}, {0, 0, 0}, event_camera), InputError);
}

TEST(FrameCamera, HasTheVerticalFieldOfViewOfTheEventCamera) {
  for (const Camera& seen_by : {event_camera, icub_left_2016}) {
    const Camera frame = frame_camera_of(seen_by);
    EXPECT_EQ(frame.size, (ImageSize{320, 240}));
    EXPECT_FALSE(frame.has_lens());
    EXPECT_NEAR(frame.ray(0, -0.5).y(), seen_by.ray(63.5, -0.5).y(), 1e-12);
    EXPECT_NEAR(frame.ray(0, 239.5).y(), seen_by.ray(63.5, 127.5).y(), 1e-12);
    EXPECT_NEAR(frame.ray(159.5, 0).x(), seen_by.ray(63.5, 63.5).x(), 1e-12);
    EXPECT_LT(frame.ray(-0.5, 0).x(), seen_by.ray(-0.5, 63.5).x());
  }
}

TEST(Shutter, DeliversThirtyImagesPerSecondEachWhenItsExposureEnds) {
  Shutter shutter({8, 8}, 20.0);
  std::int64_t last_us = 0;
  const auto dark = [&](std::int64_t t_us, const Eigen::Vector2d& shift_px, std::span<float> rgb) {
    EXPECT_GT(t_us, last_us - 1000);
    EXPECT_LT(shift_px.cwiseAbs().maxCoeff(), 0.5 + 1e-12);
    std::fill(rgb.begin(), rgb.end(), 0.0F);
  };
  std::vector<std::int64_t> images_us;
  for (std::int64_t t_us = 1000; t_us <= 1'000'000; t_us += 1000) {
    if (shutter.expose(t_us, dark)) images_us.push_back(t_us);
    last_us = t_us;
  }
  ASSERT_EQ(images_us.size(), 30U);
  for (std::size_t i = 0; i < images_us.size(); ++i) {
    const double end_us = static_cast<double>(i) * 1e6 / 30.0 + 20'000.0;
    EXPECT_GE(static_cast<double>(images_us[i]), end_us - 0.5);
    EXPECT_LT(static_cast<double>(images_us[i]), end_us + 1000.0);
  }
}

TEST(Shutter, AveragesLinearLightNotGreyLevels) {
  Shutter shutter({8, 8}, 10.0);
  const auto half_the_time = [](std::int64_t t_us, const Eigen::Vector2d&, std::span<float> rgb) {
    std::fill(rgb.begin(), rgb.end(), t_us <= 5000 ? 255.0F : 0.0F);
  };
  const cv::Mat image = shutter.expose(10'000, half_the_time).value();
  // Half the light of white is 188 in sRGB, not 128.
  EXPECT_EQ(image.at<cv::Vec3b>(3, 3), cv::Vec3b(188, 188, 188));
}

}  // namespace
}  // namespace saccade
