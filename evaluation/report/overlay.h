#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/camera.h"
#include "core/event.h"
#include "evaluation/image_codecs/image_codecs.h"
#include "evaluation/report/palette.h"

namespace saccade {

/// A circle drawn into an image, with its label beside it where it has one.
struct LabelledCircle {
  Circle circle;
  std::string label;
  Colour colour;
};

/// A camera's image with the events and circles that are drawn into it, in the colours of palette.h.
struct AnnotatedImage {
  ImageSize size;
  cv::Mat grey;  ///< 8-bit, of `size`; light grey paper when empty
  /// The Hough space instead of the image: 8-bit, of `size`, 255 where the response is strongest. Drawn from black over
  /// red and yellow to white; the events lie under it in grey.
  cv::Mat response;
  std::span<const Event> events;  ///< of the last few ms
  std::optional<Circle> truth;    ///< with a white rim
  std::vector<LabelledCircle> detections;
  std::optional<Eigen::Vector2d> principal_px;  ///< crosshair: the optical axis
  std::optional<Eigen::Vector2d> target_px;     ///< diamond: the gaze target
};

/// A detector's response over the image as an 8-bit image, 255 at its maximum; black where nothing is above
/// 0. `response` holds one number per pixel, row by row.
[[nodiscard]] cv::Mat response_image(std::span<const float> response, ImageSize size);

/// Draws with `scale` pixels per pixel of the camera (BGR, 8 bit). Events outside the image are left out.
[[nodiscard]] cv::Mat draw_image(const AnnotatedImage& image, int scale);

/// Fits `image` (BGR) into width x height with its aspect ratio kept, on a dark ground.
[[nodiscard]] cv::Mat fit_into(const cv::Mat& image, int width, int height);

/// Writes an mp4 that plays in browsers. It appears under its name on commit() only (until then `NAME.part.mp4`).
/// H.264 where it can be encoded, else MPEG-4 part 2. Every member but the destructor throws RunError.
class VideoFile {
 public:
  VideoFile(std::filesystem::path path, ImageSize size, int images_hz);
  VideoFile(const VideoFile&) = delete;
  VideoFile& operator=(const VideoFile&) = delete;
  ~VideoFile();

  /// BGR, of the file's size.
  void add(const cv::Mat& image);
  void commit();
  [[nodiscard]] std::int64_t images() const { return images_; }
  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] ImageSize size() const { return size_; }

 private:
  std::filesystem::path path_;
  std::filesystem::path part_;
  ImageSize size_;
  std::unique_ptr<VideoOutput> video_;
  std::int64_t images_ = 0;
};

/// A video of a run: the scene on the left, the eye's image on the right, a line of text below. Throws as VideoFile does.
class VideoComposer {
 public:
  static constexpr int frame_hz = 25;

  /// `speed`: time of the run per time of the video, above 0; below 1 is slow motion.
  explicit VideoComposer(std::filesystem::path path, double speed = 1.0);

  /// True when the video needs an image for `t_us`, counted from the run's start.
  [[nodiscard]] bool is_due(std::int64_t t_us) const {
    return static_cast<double>(t_us * frame_hz) >= static_cast<double>(file_.images()) * 1e6 * speed_;
  }
  /// One image of the video. `scene` BGR of any size; the caption is drawn as it stands.
  void add(const cv::Mat& scene, const AnnotatedImage& eye, const std::string& caption);
  void commit() { file_.commit(); }

 private:
  VideoFile file_;
  double speed_;
};

}  // namespace saccade
