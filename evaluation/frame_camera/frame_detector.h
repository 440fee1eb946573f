#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "core/camera.h"
#include "core/config.h"
#include "core/detector.h"

namespace saccade {

/// The baseline `frame_30hz`: a conventional camera of 320x240 pixels and 30 images per second in place of the event
/// camera, and a detector of a ball of known colour. It gets images instead of events, controls nothing, and its
/// detections are scored like those of any detector.

inline constexpr std::string_view frame_detector_name = "frame_30hz";

struct FrameDetectorConfig {
  double exposure_ms = 20.0;                   ///< exposure time of an image
  std::array<double, 2> radius_px = {10, 35};  ///< smallest and largest radius in the event camera's image
  double colour_tolerance = 0.2;  ///< largest distance from the ball's shares of linear red, green and blue
  /// Least roundness: the area of a region over that of its enclosing circle; of an ellipse, the ratio of its axes.
  double threshold = 0.75;
};

/// Keys: exposure_ms, radius_px, colour_tolerance, threshold.
void describe(FieldVisitor& v, FrameDetectorConfig& config);

/// The camera of 320x240 pixels with the pinhole and the optical axis of an event camera, but without distortion: square
/// pixels, the same vertical field of view at its centre, the event camera's image in the middle of its own.
[[nodiscard]] Camera frame_camera_of(const Camera& event_camera);

/// Integrates light into images: 30 exposures per second, the first from time 0 on. An image is the mean of
/// instants over the exposure, one per millisecond, in linear light, then converted to 8 bit sRGB.
class Shutter {
 public:
  /// Draws the camera's image at an instant: linear red, green and blue, 0 to 255, as three images one after
  /// the other. Pixels are sampled `shift_px` (within half a pixel) to the right and down, differently at every
  /// instant, which smooths edges (anti-aliasing).
  using Draw = std::function<void(std::int64_t t_us, const Eigen::Vector2d& shift_px, std::span<float> rgb)>;

  Shutter(ImageSize size, double exposure_ms);

  /// Integrates the light since the last call, up to now_us. Returns the image (CV_8UC3, red first) whose exposure
  /// ended in that time, if any; calls are less than an image apart.
  [[nodiscard]] std::optional<cv::Mat> expose(std::int64_t now_us, const Draw& draw);

 private:
  [[nodiscard]] std::int64_t next_us() const;
  [[nodiscard]] cv::Mat develop();

  ImageSize size_;
  double exposure_us_;
  int instants_;  ///< per image
  std::int64_t image_ = 0;
  int instant_ = 0;
  std::vector<float> light_;  ///< sum over the instants so far
  std::vector<float> view_;
};

/// Finds the roundest region of the ball's colour: connected pixels with the ball's proportions of red, green and blue;
/// the circle is the smallest one around the region's convex hull.
class FrameDetector {
 public:
  /// `ball_rgb`: the ball's linear reflectance. Throws InputError for a config out of range or a black ball.
  FrameDetector(const FrameDetectorConfig& config, const std::array<double, 3>& ball_rgb,
                const Camera& event_camera);

  /// The roundest region in an image (CV_8UC3 sRGB, red first) as a circle in the event camera's image; its
  /// score is its roundness. Not valid where none has a radius in the range and a centre inside the event camera's
  /// image.
  [[nodiscard]] Estimate find(const cv::Mat& image) const;

  /// Of the images.
  [[nodiscard]] const Camera& camera() const { return camera_; }
  [[nodiscard]] double threshold() const { return config_.threshold; }

 private:
  [[nodiscard]] cv::Mat ball_coloured(const cv::Mat& image) const;

  FrameDetectorConfig config_;
  cv::Vec3f ball_shares_;
  Camera event_camera_;
  Camera camera_;
};

}  // namespace saccade
