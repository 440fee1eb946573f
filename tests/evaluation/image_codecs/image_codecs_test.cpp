#include "evaluation/image_codecs/image_codecs.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

bool is_loaded(const std::string& library) {
  std::ifstream maps("/proc/self/maps");
  const std::string text(std::istreambuf_iterator<char>(maps), {});
  return text.find(library) != std::string::npos;
}

/// Grey steps and a coloured square.
cv::Mat drawn(int width, int height) {
  cv::Mat image(height, width, CV_8UC3);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x)
      image.at<cv::Vec3b>(y, x) = cv::Vec3b::all(static_cast<unsigned char>(4 * x));
  }
  image(cv::Rect(width / 4, height / 4, width / 2, height / 2)).setTo(cv::Scalar(10, 120, 240));
  return image;
}

std::string_view text_of(const std::vector<unsigned char>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST(ImageCodecs, AreLoadedWhenTheFirstImageIsWritten) {
  EXPECT_FALSE(is_loaded("libopencv_imgcodecs")) << "every start of the program would load 180 libraries";
  EXPECT_FALSE(is_loaded("libopencv_videoio"));
  EXPECT_FALSE(encoded_image("png", drawn(8, 8)).empty());
  EXPECT_TRUE(is_loaded("libopencv_imgcodecs"));
}

TEST(ImageCodecs, GiveBackWhatAPngWasMadeOf) {
  const cv::Mat image = drawn(40, 30);
  for (const PngSize size : {PngSize::quick, PngSize::smallest}) {
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

TEST(ImageCodecs, WriteAVideoThatIsReadBack) {
  const TempFolder folder;
  const auto path = folder / "a.mp4";
  const cv::Mat image = drawn(64, 48);
  const auto writer = write_video(path, "mp4v", 25.0, image.size());
  ASSERT_TRUE(writer->isOpened());
  for (int i = 0; i < 5; ++i) writer->write(image);
  writer->release();
  const auto reader = read_video(path);
  ASSERT_TRUE(reader->isOpened());
  EXPECT_NEAR(reader->get(cv::CAP_PROP_FPS), 25.0, 1e-6);
  cv::Mat read;
  int images = 0;
  while (reader->read(read)) ++images;
  EXPECT_EQ(images, 5);
  EXPECT_FALSE(read_video(folder / "absent.mp4")->isOpened());
}

}  // namespace
}  // namespace saccade
