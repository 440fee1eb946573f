#include "evaluation/report/overlay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "core/error.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

cv::Vec3b pixel(const cv::Mat& image, int x, int y) { return image.at<cv::Vec3b>(y, x); }

TEST(Overlay, PaintsEveryEventOverItsWholePixelAndNothingElse) {
  const std::vector<Event> events = {{.t_us = 1, .x = 3, .y = 5, .on = true},
                                     {.t_us = 2, .x = 7, .y = 5, .on = false}};
  AnnotatedImage eye;
  eye.size = {16, 12};
  eye.events = events;
  const cv::Mat image = draw_image(eye, 4);
  ASSERT_EQ(image.size(), cv::Size(64, 48));
  EXPECT_EQ(pixel(image, 12, 20), pixel(image, 15, 23));
  EXPECT_NE(pixel(image, 12, 20), pixel(image, 11, 20));
  EXPECT_NE(pixel(image, 12, 20), pixel(image, 28, 20)) << "polarities look alike";
  EXPECT_EQ(pixel(image, 0, 0), pixel(image, 63, 47));
}

TEST(Overlay, DrawsNoEventsOutsideTheImage) {
  const std::vector<Event> events = {{.t_us = 1, .x = 16, .y = 5, .on = true},
                                     {.t_us = 1, .x = 3, .y = 999, .on = true}};
  AnnotatedImage eye;
  eye.size = {16, 12};
  const cv::Mat empty = draw_image(eye, 2);
  eye.events = events;
  EXPECT_EQ(cv::norm(draw_image(eye, 2), empty), 0.0);
}

TEST(Overlay, DrawsACircleWhereItIs) {
  AnnotatedImage eye;
  eye.size = {128, 128};
  const cv::Mat empty = draw_image(eye, 5);
  eye.truth = Circle{40.25, 70.5, 20.0};
  cv::Mat difference;
  cv::absdiff(draw_image(eye, 5), empty, difference);
  cv::cvtColor(difference, difference, cv::COLOR_BGR2GRAY);
  const cv::Rect box = cv::boundingRect(difference > 40);
  // Pixel centres of the image lie at the centres of 5 x 5 blocks; the line is 4 px wide.
  EXPECT_NEAR(box.x + (box.width - 1) / 2.0, (40.25 + 0.5) * 5 - 0.5, 1.0);
  EXPECT_NEAR(box.y + (box.height - 1) / 2.0, (70.5 + 0.5) * 5 - 0.5, 1.0);
  EXPECT_NEAR(box.width, 2 * 20 * 5 + 4, 3.0);
}

TEST(Overlay, ScalesResponsesToTheLargest) {
  const std::vector<float> response = {0.0F, 0.5F, 2.0F, 1.0F, -1.0F, 0.004F};
  const cv::Mat image = response_image(response, {3, 2});
  EXPECT_EQ(image.at<std::uint8_t>(0, 0), 0);
  EXPECT_EQ(image.at<std::uint8_t>(0, 1), 64);
  EXPECT_EQ(image.at<std::uint8_t>(0, 2), 255);
  EXPECT_EQ(image.at<std::uint8_t>(1, 0), 128);
  EXPECT_EQ(image.at<std::uint8_t>(1, 1), 0);
  EXPECT_EQ(image.at<std::uint8_t>(1, 2), 1);
  EXPECT_EQ(cv::countNonZero(response_image(std::vector<float>(6), {3, 2})), 0);
}

TEST(Overlay, AHoughSpaceIsWhiteAtItsMaximumAndShowsTheEventsElsewhere) {
  const std::vector<Event> events = {{.t_us = 1, .x = 3, .y = 5, .on = true},
                                     {.t_us = 1, .x = 8, .y = 5, .on = false}};
  AnnotatedImage eye;
  eye.size = {16, 12};
  eye.events = events;
  eye.response = cv::Mat(12, 16, CV_8UC1, cv::Scalar(0));
  for (int x = 0; x < 16; ++x) eye.response.at<std::uint8_t>(2, x) = static_cast<std::uint8_t>(17 * x);
  const cv::Mat image = draw_image(eye, 1);
  for (int x = 2; x < 16; ++x) {
    EXPECT_GT(cv::sum(pixel(image, x, 2))[0], cv::sum(pixel(image, x - 2, 2))[0]) << x;
  }
  EXPECT_EQ(pixel(image, 15, 2), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(pixel(image, 3, 5), pixel(image, 8, 5)) << "events have one colour here";
  EXPECT_NE(pixel(image, 3, 5), pixel(image, 4, 5));
}

TEST(Overlay, MarksTheGazeTargetWithADiamond) {
  AnnotatedImage eye;
  eye.size = {32, 32};
  eye.target_px = Eigen::Vector2d(16, 12);
  const cv::Mat image = draw_image(eye, 4);
  eye.target_px.reset();
  const cv::Mat plain = draw_image(eye, 4);
  // A corner 3 px to the right of the target, its middle and a point of its box that lies outside of it.
  EXPECT_NE(pixel(image, 4 * 19 + 1, 4 * 12 + 1), pixel(plain, 4 * 19 + 1, 4 * 12 + 1));
  EXPECT_EQ(pixel(image, 4 * 16 + 1, 4 * 12 + 1), pixel(plain, 4 * 16 + 1, 4 * 12 + 1));
  EXPECT_EQ(pixel(image, 4 * 19 + 1, 4 * 15 + 1), pixel(plain, 4 * 19 + 1, 4 * 15 + 1));
  eye.target_px = Eigen::Vector2d(1e12, -1e12);
  EXPECT_EQ(cv::norm(draw_image(eye, 4), plain), 0.0);
}

TEST(Overlay, DrawsNothingForCirclesFarOutsideTheImage) {
  AnnotatedImage eye;
  eye.size = {32, 32};
  eye.truth = Circle{1e12, -1e12, 1e9};
  eye.detections = {{.circle = {-500, 9000, 3}, .label = "far", .colour = {0xd5, 0x5e, 0x00}}};
  EXPECT_FALSE(draw_image(eye, 4).empty());
}

TEST(Overlay, FitsAnImageIntoAFrameWithItsAspectRatioKept) {
  const cv::Mat wide(100, 400, CV_8UC3, cv::Scalar(0, 0, 255));
  const cv::Mat fitted = fit_into(wide, 200, 200);
  ASSERT_EQ(fitted.size(), cv::Size(200, 200));
  EXPECT_EQ(pixel(fitted, 100, 100), cv::Vec3b(0, 0, 255));
  EXPECT_NE(pixel(fitted, 100, 70), cv::Vec3b(0, 0, 255));
  EXPECT_EQ(pixel(fitted, 0, 80), cv::Vec3b(0, 0, 255));
}

TEST(VideoComposer, WritesAVideoInRealTimeThatAppearsOnCommit) {
  const fs::path path = fs::path(testing::TempDir()) / "saccade_video.mp4";
  fs::remove(path);
  AnnotatedImage eye;
  eye.size = {128, 128};
  int images = 0;
  {
    VideoComposer video(path);
    for (std::int64_t t_us = 0; t_us <= 1'000'000; t_us += 1000) {
      if (!video.is_due(t_us)) continue;
      video.add(cv::Mat(240, 320, CV_8UC3, cv::Scalar(0, 0, 200)), eye, "0.00 s");
      ++images;
    }
    EXPECT_FALSE(fs::exists(path));
    video.commit();
  }
  EXPECT_EQ(images, VideoComposer::frame_hz + 1);
  cv::VideoCapture video(path.string());
  ASSERT_TRUE(video.isOpened());
  EXPECT_EQ(video.get(cv::CAP_PROP_FPS), VideoComposer::frame_hz);
  cv::Mat frame;
  int read = 0;
  while (video.read(frame)) ++read;
  EXPECT_EQ(read, images);
  fs::remove(path);
}

TEST(VideoComposer, AtATenthOfTheSpeedThereAreTenTimesTheImages) {
  const fs::path folder = fs::path(testing::TempDir()) / "saccade_slow_video";
  fs::create_directories(folder);
  AnnotatedImage eye;
  eye.size = {64, 64};
  VideoComposer video(folder / "video.mp4", 0.1);
  int images = 0;
  for (std::int64_t t_us = 0; t_us <= 100'000; t_us += 1000) {
    if (!video.is_due(t_us)) continue;
    video.add({}, eye, "");
    ++images;
  }
  EXPECT_EQ(images, VideoComposer::frame_hz + 1);
  fs::remove_all(folder);
}

TEST(VideoComposer, WithoutCommitLeavesNothing) {
  const fs::path folder = fs::path(testing::TempDir()) / "saccade_no_video";
  fs::create_directories(folder);
  AnnotatedImage eye;
  eye.size = {64, 64};
  {
    VideoComposer video(folder / "video.mp4");
    video.add({}, eye, "");
  }
  EXPECT_TRUE(fs::is_empty(folder));
  fs::remove_all(folder);
}

TEST(VideoComposer, ReportsAMissingFolder) {
  EXPECT_THROW(VideoComposer("/nonexistent/video.mp4"), RunError);
}

}  // namespace
}  // namespace saccade
