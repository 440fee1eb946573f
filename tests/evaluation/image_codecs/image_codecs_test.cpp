#include "evaluation/image_codecs/image_codecs.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

#include "core/error.h"
#include "evaluation/image_codecs/ffmpeg_video.h"
#include "tests/evaluation/image_codecs/drawn_image.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

bool is_loaded(const std::string& library) {
  std::ifstream maps("/proc/self/maps");
  const std::string text(std::istreambuf_iterator<char>(maps), {});
  return text.find(library) != std::string::npos;
}

/// The smallest bitmap of Windows: one blue pixel.
constexpr std::string_view bitmap(
    "BM\x3a\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0\1\0\0\0\1\0\0\0\1\0\x18\0"
    "\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\xff\0\0\0",
    58);

TEST(ImageCodecs, LoadOpenCVsCodecsForOtherFormatsAlone) {
  EXPECT_FALSE(encoded_image("png", drawn(8, 8)).empty());
  EXPECT_FALSE(decoded_image(text_of(encoded_image("jpeg", drawn(8, 8))), DecodedAs::stored).empty());
  EXPECT_FALSE(is_loaded("libopencv_imgcodecs")) << "each run would load 240 libraries";
  EXPECT_FALSE(is_loaded("libopencv_videoio"));
  const cv::Mat pixel = decoded_image(bitmap, DecodedAs::colour);
  ASSERT_EQ(pixel.size(), cv::Size(1, 1));
  EXPECT_EQ(pixel.at<cv::Vec3b>(0, 0), cv::Vec3b(255, 0, 0));
  EXPECT_TRUE(is_loaded("libopencv_imgcodecs"));
}

TEST(ImageCodecs, GiveBackWhatAPngWasMadeOf) {
  const cv::Mat image = drawn(40, 30);
  for (const PngSize size : {PngSize::quick, PngSize::small}) {
    const cv::Mat back = decoded_image(text_of(encoded_image("png", image, size)), DecodedAs::stored);
    ASSERT_EQ(back.size(), image.size());
    EXPECT_EQ(cv::norm(back, image, cv::NORM_INF), 0.0);
  }
  const cv::Mat jpeg = decoded_image(text_of(encoded_image("jpeg", image)), DecodedAs::colour);
  EXPECT_LT(cv::norm(jpeg, image, cv::NORM_L1) / (40.0 * 30.0 * 3.0), 10.0) << "a mean error in grey levels";
}

TEST(ImageCodecs, KeepTheDepthOfAnImageOrMakeItGrey) {
  const TempFolder folder;
  cv::Mat deep(5, 7, CV_16UC1, cv::Scalar(40000));
  const auto bytes = encoded_image("png", deep);
  folder.write("deep.png", std::string(text_of(bytes)));
  EXPECT_EQ(decoded_image(text_of(bytes), DecodedAs::stored).type(), CV_16UC1);
  EXPECT_EQ(read_image(folder / "deep.png", DecodedAs::grey).type(), CV_8UC1);
  EXPECT_EQ(read_image(folder / "deep.png", DecodedAs::colour).type(), CV_8UC3);
}

TEST(ImageCodecs, GiveAnEmptyImageForWhatIsNone) {
  EXPECT_TRUE(decoded_image("", DecodedAs::stored).empty());
  EXPECT_TRUE(decoded_image("no image", DecodedAs::stored).empty());
  EXPECT_TRUE(read_image("/nowhere/a.png", DecodedAs::colour).empty());
}

/// Five images of 25 Hz, read back.
void expect_five_images(const std::filesystem::path& path) {
  const auto reader = read_video(path);
  ASSERT_TRUE(reader->isOpened());
  EXPECT_NEAR(reader->get(cv::CAP_PROP_FPS), 25.0, 1e-6);
  cv::Mat read;
  int images = 0;
  while (reader->read(read)) {
    ++images;
    EXPECT_LT(cv::norm(read, drawn(64, 48), cv::NORM_L1) / (64.0 * 48.0 * 3.0), 10.0)
        << "a mean error in grey levels";
  }
  EXPECT_EQ(images, 5);
}

TEST(ImageCodecs, WriteAVideoThatIsReadBack) {
  const TempFolder folder;
  const auto path = folder / "a.mp4";
  const cv::Mat image = drawn(64, 48);
  const auto writer = write_video(path, 25.0, image.size());
  for (int i = 0; i < 5; ++i) writer->write(image);
  writer->close();
  expect_five_images(path);
  EXPECT_FALSE(read_video(folder / "absent.mp4")->isOpened());
}

TEST(ImageCodecs, WriteAVideoByTheProgramFfmpeg) {
  const TempFolder folder;
  const auto path = folder / "with space:and colon.mp4";
  const cv::Mat wide = drawn(80, 48);
  const auto writer = write_video_by_ffmpeg(path, 25.0, {64, 48});
  const cv::Mat part = wide(cv::Rect(0, 0, 64, 48));  // rows that do not follow each other in memory
  drawn(64, 48).copyTo(part);
  for (int i = 0; i < 5; ++i) writer->write(part);
  writer->close();
  expect_five_images(path);
}

std::string error_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const RunError& error) {
    return error.what();
  }
  return "no error";
}

TEST(ImageCodecs, ReportWhatFfmpegSays) {
  const cv::Mat image = drawn(64, 48);
  const auto written = [&] {
    const auto writer = write_video_by_ffmpeg("/nowhere/a.mp4", 25.0, image.size());
    for (int i = 0; i < 1000; ++i) writer->write(image);
    writer->close();
  };
  EXPECT_THAT(error_of(written),
              testing::AllOf(testing::HasSubstr("video: ffmpeg cannot write /nowhere/a.mp4: "),
                             testing::HasSubstr("No such file or directory")));
}

TEST(ImageCodecs, ReportThatThereIsNoFfmpeg) {
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", "/nowhere", 1);
  const std::string error = error_of([] { (void)write_video_by_ffmpeg("a.mp4", 25.0, {64, 48}); });
  ::setenv("PATH", path.c_str(), 1);
  EXPECT_THAT(error, testing::HasSubstr("video: the program ffmpeg is not installed"));
}

TEST(ImageCodecs, AVideoThatIsNotClosedEndsItsFfmpeg) {
  const TempFolder folder;
  const cv::Mat image = drawn(64, 48);
  {
    const auto writer = write_video_by_ffmpeg(folder / "a.mp4", 25.0, image.size());
    writer->write(image);
  }
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "a child is left";
}

}  // namespace
}  // namespace saccade
