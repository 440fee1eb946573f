#include "evaluation/image_codecs/png_jpeg.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "tests/evaluation/image_codecs/drawn_image.h"

namespace saccade {
namespace {

cv::Mat noise(int width, int height, int type) {
  cv::Mat image(height, width, type);
  cv::RNG random(7);
  random.fill(image, cv::RNG::UNIFORM, 0, CV_MAT_DEPTH(type) == CV_16U ? 65536 : 256);
  return image;
}

bool are_equal(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && (a.empty() || cv::norm(a, b, cv::NORM_INF) == 0.0);
}

void expect_opencvs_images(std::string_view bytes, const std::string& what) {
  const std::vector<unsigned char> data(bytes.begin(), bytes.end());
  for (const auto& [form, flags] : {std::pair(DecodedAs::stored, cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR),
                                    std::pair<DecodedAs, int>(DecodedAs::grey, cv::IMREAD_GRAYSCALE),
                                    std::pair<DecodedAs, int>(DecodedAs::colour, cv::IMREAD_COLOR)})
    EXPECT_TRUE(are_equal(cv::imdecode(data, flags), decoded_png_or_jpeg(bytes, form).value()))
        << what << ", flags " << flags;
}

TEST(PngJpeg, WritesOpenCVsBytesAndReadsThem) {
  const cv::Mat colour = noise(53, 37, CV_8UC3), grey = noise(34, 21, CV_8UC1);
  for (const cv::Mat& image :
       {drawn(40, 30), colour, grey, noise(34, 21, CV_16UC1), noise(30, 20, CV_8UC4)}) {
    for (const PngSize size : {PngSize::quick, PngSize::small}) {
      std::vector<int> parameters;
      if (size == PngSize::small) parameters = {cv::IMWRITE_PNG_COMPRESSION, 6};
      std::vector<unsigned char> expected;
      ASSERT_TRUE(cv::imencode(".png", image, expected, parameters));
      EXPECT_EQ(encoded_png_or_jpeg("png", image, size), expected) << "type " << image.type();
      expect_opencvs_images(text_of(expected), "PNG");
    }
  }
  for (const cv::Mat& image : {drawn(40, 30), colour, grey}) {
    std::vector<unsigned char> expected;
    ASSERT_TRUE(cv::imencode(".jpeg", image, expected, {cv::IMWRITE_JPEG_QUALITY, 85}));
    EXPECT_EQ(encoded_png_or_jpeg("jpeg", image, {}), expected) << "type " << image.type();
    expect_opencvs_images(text_of(expected), "JPEG");
  }
}

TEST(PngJpeg, TurnsAJpegAsItsCameraWasHeld) {
  const std::vector<unsigned char> jpeg = encoded_png_or_jpeg("jpeg", drawn(48, 32), {});
  for (int orientation = 1; orientation <= 8; ++orientation) {
    // Exif's first directory with this one entry, little-endian, after the file's first two bytes.
    std::string exif(
        "\xff\xe1\x00\x22"
        "Exif\0\0"
        "II*\0\x08\0\0\0"
        "\x01\0\x12\x01\x03\0\x01\0\0\0 \0\0\0\0\0\0\0",
        36);
    exif[28] = static_cast<char>(orientation);
    std::string bytes(text_of(jpeg));
    expect_opencvs_images(bytes.insert(2, exif), "orientation " + std::to_string(orientation));
  }
}

TEST(PngJpeg, ReadsNothingFromATornFile) {
  const std::vector<unsigned char> png = encoded_png_or_jpeg("png", drawn(40, 30), {});
  const std::vector<unsigned char> jpeg = encoded_png_or_jpeg("jpeg", drawn(40, 30), {});
  for (const std::string_view whole : {text_of(png), text_of(jpeg)}) {
    for (const std::size_t size : {whole.size() - 20, whole.size() / 2, std::size_t{9}}) {
      const auto image = decoded_png_or_jpeg(whole.substr(0, size), DecodedAs::stored);
      ASSERT_TRUE(image.has_value());
      EXPECT_TRUE(image->empty()) << size;
    }
  }
}

TEST(PngJpeg, ReadsNothingFromAnImageOfMorePixelsThanOpenCVReads) {
  std::vector<unsigned char> png = encoded_png_or_jpeg("png", drawn(40, 30), {});
  // Width and height of the first chunk, big-endian, and its checksum.
  png[17] = png[21] = 15;
  const unsigned long sum = ::crc32(0, png.data() + 12, 17);  // NOLINT(google-runtime-int): zlib's type
  for (std::size_t i = 0; i < 4; ++i) png[29 + i] = static_cast<unsigned char>(sum >> (24 - 8 * i));
  const auto image = decoded_png_or_jpeg(text_of(png), DecodedAs::stored);
  ASSERT_TRUE(image.has_value());
  EXPECT_TRUE(image->empty());
}

TEST(PngJpeg, LeavesOtherFormatsAlone) {
  EXPECT_FALSE(decoded_png_or_jpeg("BM a bitmap", DecodedAs::colour).has_value());
  EXPECT_FALSE(decoded_png_or_jpeg("", DecodedAs::colour).has_value());
}

TEST(PngJpeg, CannotEncodeWhatJpegHasNot) {
  EXPECT_TRUE(encoded_png_or_jpeg("jpeg", cv::Mat(4, 4, CV_16UC1, cv::Scalar(1)), {}).empty());
}

}  // namespace
}  // namespace saccade
