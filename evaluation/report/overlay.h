#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/camera.h"
#include "core/event.h"

namespace cv {
class VideoWriter;
}

namespace saccade {

/// Of gaze targets in pictures and figures, "#rrggbb".
inline constexpr std::string_view gaze_target_colour = "#e69f00";

/// A circle drawn into a picture, with its name beside it where it has one.
struct LabelledCircle {
  Circle circle;
  std::string label;
  std::string colour;  ///< "#rrggbb"
};

/// What one eye sees, and what was found in it.
struct EyePicture {
  ImageSize size;
  cv::Mat grey;  ///< 8-bit, of `size`; light grey paper when empty
  /// The Hough space instead of the image: 8-bit, of `size`, 255 where the response is strongest. Dark where
  /// there is none, over red and yellow to white; the events lie under it in purple.
  cv::Mat response;
  std::span<const Event> events;  ///< of the last few ms; ON green, OFF magenta
  std::optional<Circle> truth;    ///< white with a dark rim
  std::vector<LabelledCircle> detections;
  std::optional<Eigen::Vector2d> principal_px;  ///< crosshair: where the eye points
  std::optional<Eigen::Vector2d> target_px;     ///< diamond in gaze_target_colour: where it was told to look
};

/// A detector's response over the image as an 8-bit picture, 255 at its maximum; black where nothing is above
/// 0. `response` holds one number per pixel, row by row.
[[nodiscard]] cv::Mat response_picture(std::span<const float> response, ImageSize size);

/// Draws with `scale` picture pixels per image pixel (BGR, 8 bit). Events outside the image are left out.
[[nodiscard]] cv::Mat draw_eye(const EyePicture& eye, int scale);

/// Fits `picture` (BGR) into width x height with its shape kept, on a dark ground.
[[nodiscard]] cv::Mat fit_into(const cv::Mat& picture, int width, int height);

/// Writes an mp4 that plays in browsers. It appears under its name on commit() only (until then `NAME.part.mp4`).
/// H.264 where the system's ffmpeg can encode it, else MPEG-4 part 2. Every member but the destructor throws RunError.
class VideoFile {
 public:
  VideoFile(std::filesystem::path path, ImageSize size, int pictures_hz);
  VideoFile(const VideoFile&) = delete;
  VideoFile& operator=(const VideoFile&) = delete;
  ~VideoFile();

  /// BGR, of the file's size.
  void add(const cv::Mat& picture);
  void commit();
  [[nodiscard]] std::int64_t pictures() const { return pictures_; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] ImageSize size() const { return size_; }

 private:
  std::filesystem::path path_;
  std::filesystem::path part_;
  ImageSize size_;
  std::unique_ptr<cv::VideoWriter> writer_;
  std::int64_t pictures_ = 0;
};

/// A film of a run: the scene on the left, the eye on the right, a line of text below. Throws as VideoFile does.
class VideoComposer {
 public:
  static constexpr int frame_hz = 25;

  explicit VideoComposer(std::filesystem::path path);

  /// True when the film, played in real time, needs a picture for `t_us`, counted from the run's start.
  [[nodiscard]] bool wants(std::int64_t t_us) const {
    return t_us * frame_hz >= file_.pictures() * 1'000'000;
  }
  /// One film picture. `scene` BGR of any size; the caption is drawn as it stands.
  void add(const cv::Mat& scene, const EyePicture& eye, const std::string& caption);
  void commit() { file_.commit(); }

 private:
  VideoFile file_;
};

}  // namespace saccade
