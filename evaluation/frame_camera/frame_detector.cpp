#include "evaluation/frame_camera/frame_detector.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "core/detector_parts.h"
#include "core/error.h"
#include "emulator/srgb.h"

namespace saccade {
namespace {

constexpr ImageSize frame_size{320, 240};
constexpr double images_per_s = 30.0;
constexpr float darkest = 0.01F;  ///< sum of linear red, green and blue below which there is no colour

std::uint8_t to_srgb_byte(float linear) {
  constexpr std::size_t steps = 4096;
  static const std::array<std::uint8_t, steps> table = [] {
    std::array<std::uint8_t, steps> bytes{};
    for (std::size_t i = 0; i < steps; ++i) {
      const double value = static_cast<double>(i) / static_cast<double>(steps - 1);
      bytes[i] = static_cast<std::uint8_t>(std::lround(255.0 * srgb_from_linear(value)));
    }
    return bytes;
  }();
  return table[static_cast<std::size_t>(std::clamp(linear, 0.0F, 1.0F) * static_cast<float>(steps - 1) +
                                        0.5F)];
}

/// Where the pixels of the n-th picture of an exposure lie: Roberts' R2 sequence, evenly spread for any number.
Eigen::Vector2d shift_of(int instant) {
  const auto along = [&](double step) { return std::fmod(0.5 + step * instant, 1.0) - 0.5; };
  return {along(0.7548776662466927), along(0.5698402909980532)};
}

cv::Vec3f shares_of(const cv::Vec3f& rgb) { return rgb / (rgb[0] + rgb[1] + rgb[2]); }

}  // namespace

void describe(FieldVisitor& v, FrameDetectorConfig& config) {
  v.real("exposure_ms", config.exposure_ms, {1.0, 33.0}, "exposure time of an image");
  describe_radius_px(v, config.radius_px);
  v.real("colour_tolerance", config.colour_tolerance, {0.01, 1.0},
         "largest distance in chromaticity from the ball's colour");
  v.real("threshold", config.threshold, {0.0, 1.0}, "least roundness of a region that is taken for the ball");
}

Camera frame_camera_of(const Camera& event_camera) {
  const ImageSize size = event_camera.size;
  const double middle_x = 0.5 * (size.width - 1);
  const double top = event_camera.ray(middle_x, -0.5).y();
  const double bottom = event_camera.ray(middle_x, size.height - 0.5).y();
  Camera camera = event_camera.without_lens();
  camera.size = frame_size;
  camera.fx_px = camera.fy_px = frame_size.height / (bottom - top);
  camera.cy_px = -0.5 - top * camera.fy_px;
  const double off_axis = event_camera.ray(middle_x, 0.5 * (size.height - 1)).x();
  camera.cx_px = 0.5 * (frame_size.width - 1) - off_axis * camera.fx_px;
  return camera;
}

Shutter::Shutter(ImageSize size, double exposure_ms)
    : size_(size),
      exposure_us_(1000.0 * exposure_ms),
      instants_(static_cast<int>(std::ceil(exposure_ms))),
      light_(3 * static_cast<std::size_t>(size.pixels()), 0.0F),
      view_(light_.size()) {}

/// When the next instant is to be drawn or, after the last one, when the exposure ends.
std::int64_t Shutter::next_us() const {
  const double part = instant_ < instants_ ? (instant_ + 0.5) / instants_ : 1.0;
  return std::llround(static_cast<double>(image_) * 1e6 / images_per_s + part * exposure_us_);
}

std::optional<cv::Mat> Shutter::expose(std::int64_t now_us, const Draw& draw) {
  std::optional<cv::Mat> image;
  for (std::int64_t t_us = next_us(); t_us <= now_us; t_us = next_us()) {
    if (instant_ < instants_) {
      draw(t_us, shift_of(instant_), view_);
      std::transform(view_.begin(), view_.end(), light_.begin(), light_.begin(), std::plus<>());
      ++instant_;
    } else {
      image = develop();
      ++image_;
      instant_ = 0;
    }
  }
  return image;
}

cv::Mat Shutter::develop() {
  cv::Mat image(size_.height, size_.width, CV_8UC3);
  const auto pixels = static_cast<std::size_t>(size_.pixels());
  const float scale = 1.0F / (255.0F * static_cast<float>(instants_));
  for (std::size_t colour = 0; colour < 3; ++colour) {
    for (std::size_t i = 0; i < pixels; ++i) {
      image.data[3 * i + colour] = to_srgb_byte(scale * light_[colour * pixels + i]);
    }
  }
  std::fill(light_.begin(), light_.end(), 0.0F);
  return image;
}

FrameDetector::FrameDetector(const FrameDetectorConfig& config, const std::array<double, 3>& ball_rgb,
                             const Camera& event_camera)
    : config_(config), event_camera_(event_camera), camera_(frame_camera_of(event_camera)) {
  check_config(frame_detector_name, config);
  const cv::Vec3d rgb(ball_rgb[0], ball_rgb[1], ball_rgb[2]);
  if (!(rgb[0] + rgb[1] + rgb[2] > 0.0)) {
    throw InputError("ball.rgb", "black", "a colour that frame_30hz can find");
  }
  ball_shares_ = shares_of(rgb);
}

cv::Mat FrameDetector::ball_coloured(const cv::Mat& image) const {
  static const std::array<float, 256> linear = [] {
    std::array<float, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
      table[i] = static_cast<float>(linear_from_srgb(static_cast<double>(i) / 255.0));
    }
    return table;
  }();
  cv::Mat mask(image.size(), CV_8U);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const auto& srgb = image.at<cv::Vec3b>(y, x);
      const cv::Vec3f rgb(linear[srgb[0]], linear[srgb[1]], linear[srgb[2]]);
      const bool is_ball = rgb[0] + rgb[1] + rgb[2] > darkest &&
                           cv::norm(shares_of(rgb) - ball_shares_) < config_.colour_tolerance;
      mask.at<std::uint8_t>(y, x) = is_ball ? 255 : 0;
    }
  }
  cv::morphologyEx(mask, mask, cv::MORPH_OPEN, cv::getStructuringElement(cv::MORPH_ELLIPSE, {3, 3}));
  return mask;
}

Estimate FrameDetector::find(const cv::Mat& image) const {
  SACCADE_CHECK(image.type() == CV_8UC3 && image.cols == camera_.size.width &&
                image.rows == camera_.size.height);
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(ball_coloured(image), outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  Estimate best;
  for (const std::vector<cv::Point>& outline : outlines) {
    std::vector<cv::Point> hull;
    cv::convexHull(outline, hull);
    cv::Point2f centre;
    float radius_px = 0.0F;
    cv::minEnclosingCircle(hull, centre, radius_px);
    // Through the centres of the outermost pixels: the spot reaches half a pixel further.
    const double radius = (static_cast<double>(radius_px) + 0.5) / camera_.fx_px;  // at unit depth
    const auto seen = event_camera_.project_ellipse(camera_.ray(centre.x, centre.y).head<2>(), {radius, 0.0},
                                                    {0.0, radius});
    if (!seen || seen->r_px < config_.radius_px[0] - 0.5 || seen->r_px > config_.radius_px[1] + 0.5) continue;
    if (!event_camera_.size.contains(static_cast<int>(std::lround(seen->x_px)),
                                     static_cast<int>(std::lround(seen->y_px)))) {
      continue;
    }
    const double roundness = cv::contourArea(hull) / (std::numbers::pi * radius_px * radius_px);
    if (roundness > best.score) best = {true, false, *seen, roundness};
  }
  return best;
}

}  // namespace saccade
