#include "evaluation/report/film.h"

#include <gtest/gtest.h>

#include <opencv2/videoio.hpp>

#include "core/error.h"
#include "evaluation/image_codecs/image_codecs.h"

namespace saccade {
namespace {

/// A second of a recording of 64 x 48 pixels: a vertical line of ON events that moves by a pixel every 20 ms.
std::filesystem::path moving_line(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "line.aedat4";
  const auto writer = create_event_file(path, {64, 48});
  std::vector<Event> events;
  for (std::int64_t t_us = 0; t_us <= 1'000'000; t_us += 1'000) {
    for (std::uint16_t y = 0; y < 48; ++y)
      events.push_back({.t_us = t_us, .x = static_cast<std::uint16_t>(t_us / 20'000), .y = y, .on = true});
  }
  writer->write(events);
  writer->commit();
  return path;
}

std::vector<cv::Mat> images_of(const std::filesystem::path& path) {
  const auto video = read_video(path);
  std::vector<cv::Mat> images;
  for (cv::Mat image; video->read(image);) images.push_back(image.clone());
  return images;
}

/// The column of the brightest red over blue in the middle row, in pixels of the recording (drawn with a scale of 10).
int red_column(const cv::Mat& image) {
  int best = -1, most = 60;
  for (int x = 5; x < 640; x += 10) {
    const cv::Vec3b pixel = image.at<cv::Vec3b>(240, x);
    const int red = std::abs(pixel[2] - pixel[0]);
    if (red > most) {
      most = red;
      best = x / 10;
    }
  }
  return best;
}

class Film : public testing::Test {
 protected:
  Film() { std::filesystem::create_directories(folder_); }
  ~Film() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path folder_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string("saccade_film_") + testing::UnitTest::GetInstance()->current_test_info()->name());
};

TEST_F(Film, ShowsTheEventsOfItsInstants) {
  const std::filesystem::path recording = moving_line(folder_);
  FilmConfig config;
  config.window_ms = 15.0;
  config.name = "line";
  const FilmResult result = write_film(built_in_formats(), recording, {}, {}, folder_ / "film.mp4", config);
  EXPECT_EQ(result.images, 26);
  const std::vector<cv::Mat> images = images_of(folder_ / "film.mp4");
  ASSERT_EQ(images.size(), 26U);
  EXPECT_EQ(images[0].size(), cv::Size(640, 480 + 48));
  for (const std::size_t i : {5U, 12U, 24U}) EXPECT_NEAR(red_column(images[i]), 2 * static_cast<int>(i), 1);
}

TEST_F(Film, IsSlowerAndOfAPartOfTheRecording) {
  const std::filesystem::path recording = moving_line(folder_);
  FilmConfig config;
  config.speed = 0.1;
  config.from_s = 0.5;
  config.until_s = 0.6;
  EXPECT_EQ(write_film(built_in_formats(), recording, {}, {}, folder_ / "film.mp4", config).images, 26);
  const std::vector<cv::Mat> images = images_of(folder_ / "film.mp4");
  EXPECT_NEAR(red_column(images[1]), 25, 1);
  EXPECT_NEAR(red_column(images[24]), 29, 1);
}

TEST_F(Film, NamesWhatItCannotDraw) {
  const std::filesystem::path recording = moving_line(folder_);
  FilmConfig config;
  config.from_s = 2.0;
  try {
    write_film(built_in_formats(), recording, {}, {}, folder_ / "film.mp4", config);
    FAIL() << "expected InputError";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("--from: found 2, expected less than 1"), std::string::npos)
        << error.what();
  }
  EXPECT_FALSE(std::filesystem::exists(folder_ / "film.mp4"));
}

}  // namespace
}  // namespace saccade
