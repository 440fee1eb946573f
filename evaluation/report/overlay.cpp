#include "evaluation/report/overlay.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/error.h"

namespace saccade {
namespace {

constexpr int fraction_bits = 4;  // of OpenCV's fixed-point drawing coordinates
constexpr int scene_width = 688;
constexpr int eye_width = 512;
constexpr int panel_height = 512;
constexpr int caption_height = 48;
const cv::Scalar paper(236, 236, 236);
const cv::Scalar ground(24, 24, 24);

cv::Scalar bgr(Colour colour) {
  return {static_cast<double>(colour.blue), static_cast<double>(colour.green),
          static_cast<double>(colour.red)};
}

cv::Vec3b pixel_bgr(Colour colour) { return {colour.blue, colour.green, colour.red}; }

/// Pixels of the camera to pixels of the drawing in OpenCV's fixed point; pixel centres stay pixel centres.
int fixed(double px, int scale) {
  return static_cast<int>(std::lround(((px + 0.5) * scale - 0.5) * (1 << fraction_bits)));
}

void draw_circle(cv::Mat& picture, const Circle& c, int scale, const cv::Scalar& colour, int thickness) {
  // Beyond this the fixed-point numbers would overflow, and nothing of the circle is in the picture.
  if (!(std::abs(c.x_px) + std::abs(c.y_px) + std::abs(c.r_px) < 1e5)) return;
  cv::circle(picture, {fixed(c.x_px, scale), fixed(c.y_px, scale)},
             static_cast<int>(std::lround(c.r_px * scale * (1 << fraction_bits))), colour, thickness,
             cv::LINE_AA, fraction_bits);
}

/// The response in the colours of heat, the stronger the less of the image shines through.
void lay_over(cv::Mat& image, const cv::Mat& response) {
  SACCADE_CHECK(response.type() == CV_8UC1 && response.size() == image.size());
  cv::Mat heat;
  cv::applyColorMap(response, heat, cv::COLORMAP_HOT);
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      const double share = std::min(1.0, 1.6 * response.at<std::uint8_t>(y, x) / 255.0);
      cv::Vec3b& pixel = image.at<cv::Vec3b>(y, x);
      for (int c = 0; c < 3; ++c) {
        pixel[c] =
            cv::saturate_cast<std::uint8_t>((1.0 - share) * pixel[c] + share * heat.at<cv::Vec3b>(y, x)[c]);
      }
    }
  }
}

void draw_diamond(cv::Mat& picture, const Eigen::Vector2d& centre_px, int scale) {
  const cv::Point centre(fixed(centre_px.x(), scale), fixed(centre_px.y(), scale));
  const int arm = 3 * scale * (1 << fraction_bits);
  const std::vector<cv::Point> corners = {centre + cv::Point(arm, 0), centre + cv::Point(0, arm),
                                          centre - cv::Point(arm, 0), centre - cv::Point(0, arm)};
  cv::polylines(picture, corners, true, {255, 255, 255}, 4, cv::LINE_AA, fraction_bits);
  cv::polylines(picture, corners, true, bgr(gaze_target_colour), 2, cv::LINE_AA, fraction_bits);
}

void draw_text(cv::Mat& picture, const std::string& text, cv::Point at, const cv::Scalar& colour,
               double size) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, cv::Scalar::all(255), 3, cv::LINE_AA);
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, colour, 1, cv::LINE_AA);
}

void draw_label(cv::Mat& picture, const LabelledCircle& found, int scale, int line) {
  if (found.label.empty()) return;
  const double size = std::clamp(picture.cols / 1000.0, 0.35, 0.55);
  const int line_height = static_cast<int>(std::lround(40 * size));
  const int x = static_cast<int>((found.circle.x_px + found.circle.r_px * 0.75) * scale);
  const int y = static_cast<int>((found.circle.y_px - found.circle.r_px * 0.75) * scale) + line * line_height;
  const cv::Size text = cv::getTextSize(found.label, cv::FONT_HERSHEY_SIMPLEX, size, 1, nullptr);
  draw_text(picture, found.label,
            {std::clamp(x, 2, std::max(2, picture.cols - text.width - 2)),
             std::clamp(y, text.height + 2, std::max(text.height + 2, picture.rows - 4))},
            bgr(found.colour), size);
}

}  // namespace

cv::Mat response_image(std::span<const float> response, ImageSize size) {
  SACCADE_CHECK(response.size() == static_cast<std::size_t>(size.pixels()));
  cv::Mat image(size.height, size.width, CV_8UC1, cv::Scalar(0));
  const float strongest = response.empty() ? 0.0F : *std::max_element(response.begin(), response.end());
  if (!(strongest > 0.0F)) return image;
  std::transform(response.begin(), response.end(), image.begin<std::uint8_t>(),
                 [&](float r) { return cv::saturate_cast<std::uint8_t>(255.0F * r / strongest); });
  return image;
}

cv::Mat draw_image(const AnnotatedImage& eye, int scale) {
  SACCADE_CHECK(scale >= 1 && eye.size.pixels() > 0);
  cv::Mat image(eye.size.height, eye.size.width, CV_8UC3, paper);
  if (!eye.grey.empty()) {
    SACCADE_CHECK(eye.grey.type() == CV_8UC1 && eye.grey.cols == eye.size.width &&
                  eye.grey.rows == eye.size.height);
    cv::cvtColor(eye.grey, image, cv::COLOR_GRAY2BGR);
  }
  const bool hough = !eye.response.empty();
  if (hough) image = ground;
  for (const Event& e : eye.events) {
    if (eye.size.contains(e.x, e.y)) {
      image.at<cv::Vec3b>(e.y, e.x) = hough  ? cv::Vec3b(140, 140, 140)
                                      : e.on ? pixel_bgr(on_colour)
                                             : pixel_bgr(off_colour);
    }
  }
  if (hough) lay_over(image, eye.response);
  cv::Mat picture;
  cv::resize(image, picture, {}, scale, scale, cv::INTER_NEAREST);

  if (eye.principal_px) {
    const cv::Point centre(fixed(eye.principal_px->x(), scale), fixed(eye.principal_px->y(), scale));
    const int arm = 4 * scale * (1 << fraction_bits);
    for (const cv::Point& d : {cv::Point(arm, 0), cv::Point(0, arm)}) {
      cv::line(picture, centre - d, centre + d, {0, 0, 0}, 3, cv::LINE_AA, fraction_bits);
      cv::line(picture, centre - d, centre + d, {0, 230, 255}, 1, cv::LINE_AA, fraction_bits);
    }
  }
  if (eye.truth) {
    draw_circle(picture, *eye.truth, scale, {255, 255, 255}, 4);
    draw_circle(picture, *eye.truth, scale, bgr(truth_colour), 2);
  }
  for (const LabelledCircle& found : eye.detections) {
    draw_circle(picture, found.circle, scale, bgr(found.colour), 2);
  }
  if (eye.target_px && eye.target_px->cwiseAbs().maxCoeff() < 1e5)
    draw_diamond(picture, *eye.target_px, scale);
  for (std::size_t i = 0; i < eye.detections.size(); ++i) {
    draw_label(picture, eye.detections[i], scale, static_cast<int>(i));
  }
  return picture;
}

cv::Mat fit_into(const cv::Mat& image, int width, int height) {
  cv::Mat canvas(height, width, CV_8UC3, ground);
  if (image.empty()) return canvas;
  const double scale =
      std::min(static_cast<double>(width) / image.cols, static_cast<double>(height) / image.rows);
  const cv::Size size(std::clamp(static_cast<int>(std::lround(image.cols * scale)), 1, width),
                      std::clamp(static_cast<int>(std::lround(image.rows * scale)), 1, height));
  cv::Mat resized;
  cv::resize(image, resized, size, 0, 0, scale < 1.0 ? cv::INTER_AREA : cv::INTER_LINEAR);
  resized.copyTo(canvas({(width - size.width) / 2, (height - size.height) / 2, size.width, size.height}));
  return canvas;
}

VideoFile::VideoFile(std::filesystem::path path, ImageSize image, int images_hz)
    : path_(std::move(path)), part_(path_), size_(image) {
  part_.replace_extension(".part.mp4");  // ffmpeg chooses the container by the last extension
  video_ = write_video(part_, images_hz, cv::Size(image.width, image.height));
}

VideoFile::~VideoFile() {
  if (video_) {
    video_.reset();
    std::error_code ignored;
    std::filesystem::remove(part_, ignored);
  }
}

void VideoFile::add(const cv::Mat& image) {
  SACCADE_CHECK(video_ != nullptr);
  video_->write(image);
  ++images_;
}

void VideoFile::commit() {
  SACCADE_CHECK(video_ != nullptr);
  if (images_ == 0) throw RunError("video: no image for " + path_.string());
  video_->close();
  std::error_code error;
  if (std::filesystem::file_size(part_, error) == 0 || error)
    throw RunError("video: nothing was written to " + part_.string());
  std::filesystem::rename(part_, path_, error);
  if (error) throw RunError("video: cannot rename " + part_.string() + ": " + error.message());
  video_.reset();
}

VideoComposer::VideoComposer(std::filesystem::path path, double speed)
    : file_(std::move(path), {scene_width + eye_width, panel_height + caption_height}, frame_hz),
      speed_(speed) {}

void VideoComposer::add(const cv::Mat& scene, const AnnotatedImage& eye, const std::string& caption) {
  cv::Mat frame(panel_height + caption_height, scene_width + eye_width, CV_8UC3, ground);
  const int scale = std::max(1, std::min(eye_width / eye.size.width, panel_height / eye.size.height));
  fit_into(scene, scene_width, panel_height).copyTo(frame({0, 0, scene_width, panel_height}));
  fit_into(draw_image(eye, scale), eye_width, panel_height)
      .copyTo(frame({scene_width, 0, eye_width, panel_height}));
  cv::putText(frame, caption, {16, panel_height + 31}, cv::FONT_HERSHEY_SIMPLEX, 0.65, {240, 240, 240}, 1,
              cv::LINE_AA);
  file_.add(frame);
}

}  // namespace saccade
