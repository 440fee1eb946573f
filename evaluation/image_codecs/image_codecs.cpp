#include "evaluation/image_codecs/image_codecs.h"

#include <fstream>
#include <iterator>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/videoio.hpp>

#include "core/error.h"
#include "evaluation/image_codecs/codec_library.h"
#include "evaluation/image_codecs/ffmpeg_video.h"
#include "evaluation/image_codecs/png_jpeg.h"
#include "recording/helper_reader.h"

namespace saccade {
namespace {

/// Null where an installation has none.
const CodecLibrary* library() {
  if (!has_helper(codec_library_file)) return nullptr;
  return static_cast<const CodecLibrary*>(helper_symbol(codec_library_file, codec_library_symbol));
}

const CodecLibrary& library_for(const char* what) {
  const CodecLibrary* const found = library();
  if (found == nullptr) {
    throw RunError(std::string(what) + " are not read: this installation of saccade has no " +
                   codec_library_file + "; Debian's package has");
  }
  return *found;
}

class LibraryVideo final : public VideoOutput {
 public:
  explicit LibraryVideo(std::unique_ptr<cv::VideoWriter> writer) : writer_(std::move(writer)) {}
  void write(const cv::Mat& image) override { writer_->write(image); }
  void close() override { writer_->release(); }

 private:
  std::unique_ptr<cv::VideoWriter> writer_;
};

}  // namespace

std::vector<unsigned char> encoded_image(std::string_view format, const cv::Mat& image, PngSize png) {
  std::vector<unsigned char> bytes = encoded_png_or_jpeg(format, image, png);
  if (bytes.empty()) throw RunError("an image cannot be encoded as " + std::string(format));
  return bytes;
}

cv::Mat decoded_image(std::string_view bytes, DecodedAs form) {
  if (bytes.empty()) return {};
  if (std::optional<cv::Mat> image = decoded_png_or_jpeg(bytes, form)) return *std::move(image);
  return library_for("images other than PNG and JPEG").decode(bytes, form);
}

cv::Mat read_image(const std::filesystem::path& path, DecodedAs form) {
  std::ifstream file(path, std::ios::binary);
  return decoded_image(std::string(std::istreambuf_iterator<char>(file), {}), form);
}

std::unique_ptr<cv::VideoCapture> read_video(const std::filesystem::path& path) {
  return std::unique_ptr<cv::VideoCapture>(library_for("videos").read_video(path.string()));
}

std::vector<std::int64_t> video_times(const std::filesystem::path& path) {
  return library_for("videos").video_times(path.string());
}

std::unique_ptr<VideoOutput> write_video(const std::filesystem::path& path, double images_hz,
                                         const cv::Size& size) {
  const CodecLibrary* const codecs = library();
  if (codecs == nullptr) return write_video_by_ffmpeg(path, images_hz, size);
  const auto level = cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  std::unique_ptr<cv::VideoWriter> writer;
  for (const char* codec : {"avc1", "mp4v"}) {
    writer.reset(codecs->write_video(path.string(), codec, images_hz, size));
    if (writer->isOpened()) break;
  }
  cv::utils::logging::setLogLevel(level);
  if (!writer->isOpened()) throw RunError("video: cannot write " + path.string());
  return std::make_unique<LibraryVideo>(std::move(writer));
}

}  // namespace saccade
