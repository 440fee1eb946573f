#include "evaluation/image_codecs/image_codecs.h"

#include <opencv2/core/utils/logger.hpp>
#include <opencv2/videoio.hpp>

#include "core/error.h"
#include "evaluation/image_codecs/codec_library.h"
#include "evaluation/image_codecs/ffmpeg_video.h"
#include "recording/helper_reader.h"

namespace saccade {
namespace {

const CodecLibrary& library() {
  return *static_cast<const CodecLibrary*>(helper_symbol(codec_library_file, codec_library_symbol));
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
  std::vector<unsigned char> bytes;
  if (!library().encode(format, image, png, bytes))
    throw RunError("an image cannot be encoded as " + std::string(format));
  return bytes;
}

cv::Mat decoded_image(std::string_view bytes, DecodedAs form) { return library().decode(bytes, form); }

cv::Mat read_image(const std::filesystem::path& path, DecodedAs form) {
  return library().read(path.string(), form);
}

std::unique_ptr<cv::VideoCapture> read_video(const std::filesystem::path& path) {
  std::unique_ptr<cv::VideoCapture> video(library().read_video(path.string()));
  if (!video)
    throw RunError(
        "videos are not read: this installation of saccade has no video library; Debian's package has");
  return video;
}

std::vector<std::int64_t> video_times(const std::filesystem::path& path) {
  return library().video_times(path.string());
}

std::unique_ptr<VideoOutput> write_video(const std::filesystem::path& path, double images_hz,
                                         const cv::Size& size) {
  const auto level = cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  std::unique_ptr<cv::VideoWriter> writer;
  for (const char* codec : {"avc1", "mp4v"}) {
    writer.reset(library().write_video(path.string(), codec, images_hz, size));
    if (!writer || writer->isOpened()) break;
  }
  cv::utils::logging::setLogLevel(level);
  if (!writer) return write_video_by_ffmpeg(path, images_hz, size);
  if (!writer->isOpened()) throw RunError("video: cannot write " + path.string());
  return std::make_unique<LibraryVideo>(std::move(writer));
}

}  // namespace saccade
