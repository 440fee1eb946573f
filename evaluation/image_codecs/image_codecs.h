#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace cv {
class VideoCapture;
}  // namespace cv

namespace saccade {

/// Image and video files. PNG and JPEG are read and written by libpng and libjpeg. Other images and videos need OpenCV's
/// imgcodecs and videoio and their 240 libraries, which take 0.3 s to load; they are in a library of their own,
/// saccade-image-codecs.so, that is loaded when the first of these is read or written. An archive of the program lacks it:
/// reading them throws RunError there, and write_video needs the program ffmpeg. All functions throw RunError where that
/// library cannot be loaded, and cv::Exception as OpenCV does.

/// A file's bytes; `format` is png or jpeg. PNG in its small form takes longer. JPEG has a quality of 85 %.
enum class PngSize : std::uint8_t { quick, small };
[[nodiscard]] std::vector<unsigned char> encoded_image(std::string_view format, const cv::Mat& image,
                                                       PngSize png = PngSize::quick);

/// What a decoded image becomes: as the file has it (depth and colour), 8-bit grey, or 8-bit BGR.
enum class DecodedAs : std::uint8_t { stored, grey, colour };
/// Empty where `bytes` are no whole image.
[[nodiscard]] cv::Mat decoded_image(std::string_view bytes, DecodedAs form);
/// Empty where the file is missing or no whole image.
[[nodiscard]] cv::Mat read_image(const std::filesystem::path& path, DecodedAs form);

/// A video that ffmpeg's libraries decode; not opened (isOpened()) where they cannot.
[[nodiscard]] std::unique_ptr<cv::VideoCapture> read_video(const std::filesystem::path& path);
/// When the images of a video are shown, by its container, in their order: us from the start of the video. Empty where the
/// container has no times. It is read without decoding.
[[nodiscard]] std::vector<std::int64_t> video_times(const std::filesystem::path& path);
/// A video that is being written. Every member but the destructor throws RunError where that fails.
class VideoOutput {
 public:
  VideoOutput() = default;
  VideoOutput(const VideoOutput&) = delete;
  VideoOutput& operator=(const VideoOutput&) = delete;
  virtual ~VideoOutput() = default;

  /// BGR, 8 bit, of the video's size.
  virtual void write(const cv::Mat& image) = 0;
  /// Completes the file; nothing is called afterwards. A video that is destroyed without it may be unreadable.
  virtual void close() = 0;
};

/// A video in the container that the path's extension names: H.264 where it can be encoded, else MPEG-4 part 2. Throws
/// RunError where it cannot be written.
[[nodiscard]] std::unique_ptr<VideoOutput> write_video(const std::filesystem::path& path, double images_hz,
                                                       const cv::Size& size);

}  // namespace saccade
