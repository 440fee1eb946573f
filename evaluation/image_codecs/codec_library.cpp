// saccade-image-codecs.so: all that links OpenCV's imgcodecs and videoio.
#include "evaluation/image_codecs/codec_library.h"

#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>

namespace saccade::inline v0_1 {
namespace {

bool encode(std::string_view format, const cv::Mat& image, PngSize png, std::vector<unsigned char>& bytes) {
  std::vector<int> parameters;
  if (format == "jpeg") {
    parameters = {cv::IMWRITE_JPEG_QUALITY, 85};
  } else if (png == PngSize::smallest) {
    parameters = {cv::IMWRITE_PNG_COMPRESSION, 9};
  }
  return cv::imencode("." + std::string(format), image, bytes, parameters);
}

int flags_of(DecodedAs form) {
  switch (form) {
    case DecodedAs::stored:
      return cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR;
    case DecodedAs::grey:
      return cv::IMREAD_GRAYSCALE;
    case DecodedAs::colour:
      break;
  }
  return cv::IMREAD_COLOR;
}

cv::Mat decode(std::string_view bytes, DecodedAs form) {
  if (bytes.empty()) return {};
  // OpenCV takes no constant data; imdecode only reads it.
  const cv::Mat view(1, static_cast<int>(bytes.size()), CV_8U, const_cast<char*>(bytes.data()));
  return cv::imdecode(view, flags_of(form));
}

cv::Mat read(const std::string& path, DecodedAs form) { return cv::imread(path, flags_of(form)); }

cv::VideoCapture* new_capture(const std::string& path) { return new cv::VideoCapture(path, cv::CAP_FFMPEG); }

cv::VideoWriter* new_writer(const std::string& path, std::string_view codec, double images_hz,
                            const cv::Size& size) {
  return new cv::VideoWriter(
      path, cv::CAP_FFMPEG, cv::VideoWriter::fourcc(codec[0], codec[1], codec[2], codec[3]), images_hz, size);
}

}  // namespace
}  // namespace saccade::inline v0_1

extern "C" {
extern const saccade::CodecLibrary saccade_image_codecs_v0_1;
const saccade::CodecLibrary saccade_image_codecs_v0_1{&saccade::encode, &saccade::decode, &saccade::read,
                                                      &saccade::new_capture, &saccade::new_writer};
}
