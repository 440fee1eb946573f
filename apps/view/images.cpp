#include "apps/view/images.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace saccade {
namespace {

std::uint8_t mix(std::uint8_t from, std::uint8_t to, double share) {
  return static_cast<std::uint8_t>(std::lround(from + share * (to - from)));
}

std::span<const Event> newest(const Snapshot& snapshot, std::int64_t span_us) {
  const auto begin = std::ranges::upper_bound(snapshot.events, snapshot.now_us - span_us, {}, &Event::t_us);
  return {begin, snapshot.events.end()};
}

/// Projects the box of events, which is centred at the origin with sides from -1 to 1.
class BoxView {
 public:
  BoxView(double azimuth_rad, double elevation_rad, ImageSize size, double aspect)
      : ca_(std::cos(azimuth_rad)),
        sa_(std::sin(azimuth_rad)),
        ce_(std::cos(elevation_rad)),
        se_(std::sin(elevation_rad)),
        aspect_(aspect),
        scale_(0.26 * std::min(size.width, size.height)),
        middle_x_(0.5 * size.width),
        middle_y_(0.5 * size.height) {}

  /// x and y of the image and time, each from -1 to 1, time + at now.
  [[nodiscard]] cv::Point2d place(double x, double y, double time) const {
    x *= std::min(1.0, aspect_);
    y *= std::min(1.0, 1.0 / aspect_);
    time *= 1.15;
    const double right = ca_ * x + sa_ * time;
    const double depth = -sa_ * x + ca_ * time;  // towards the viewer
    const double down = ce_ * y + se_ * depth;
    const double near = 1.0 / (1.0 - 0.16 * (ce_ * depth - se_ * y));
    return {middle_x_ + scale_ * near * right, middle_y_ + scale_ * near * down};
  }

 private:
  double ca_, sa_, ce_, se_, aspect_, scale_, middle_x_, middle_y_;
};

}  // namespace

void paint_eye(const Snapshot& snapshot, std::int64_t fade_us, bool with_image, RgbImage& rgb) {
  const auto pixels = static_cast<std::size_t>(snapshot.camera.size.pixels());
  rgb.resize(3 * pixels);
  const bool image = with_image && snapshot.grey.size() == pixels;
  for (std::size_t i = 0; i < pixels; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      // From linear luminance to screen values, darkened.
      rgb[3 * i + c] = image ? static_cast<std::uint8_t>(8.5 * std::sqrt(snapshot.grey[i])) : ground_rgb[c];
    }
  }
  for (const Event& event : newest(snapshot, fade_us)) {
    if (!snapshot.camera.size.contains(event.x, event.y)) continue;
    const double age = static_cast<double>(snapshot.now_us - event.t_us) / static_cast<double>(fade_us);
    const Rgb& colour = event.on ? on_rgb : off_rgb;
    std::uint8_t* pixel = rgb.data() + 3 * (event.y * snapshot.camera.size.width + event.x);
    for (std::size_t c = 0; c < 3; ++c)
      pixel[c] = mix(image ? 40 : ground_rgb[c], colour[c], 1.0 - 0.88 * std::max(age, 0.0));
  }
}

void paint_hough(const Snapshot& snapshot, RgbImage& rgb) {
  const auto pixels = static_cast<std::size_t>(snapshot.camera.size.pixels());
  rgb.assign(3 * pixels, 0);
  if (snapshot.hough.size() != pixels) return;
  const float strongest = *std::ranges::max_element(snapshot.hough);
  if (!(strongest > 0.0F)) return;
  cv::Mat grey(1, static_cast<int>(pixels), CV_8UC1);
  for (std::size_t i = 0; i < pixels; ++i)
    grey.data[i] =
        static_cast<std::uint8_t>(std::lround(255.0F * std::max(0.0F, snapshot.hough[i]) / strongest));
  cv::Mat heat;
  cv::applyColorMap(grey, heat, cv::COLORMAP_INFERNO);
  for (std::size_t i = 0; i < pixels; ++i) {
    for (std::size_t c = 0; c < 3; ++c) rgb[3 * i + c] = heat.data[3 * i + 2 - c];
  }
}

void paint_event_counts(std::span<const float> counts, ImageSize size, RgbImage& rgb) {
  rgb.resize(3 * static_cast<std::size_t>(size.pixels()));
  cv::Mat canvas(size.height, size.width, CV_8UC3, rgb.data());
  canvas = cv::Scalar(22, 22, 24);
  const float most = std::max(1.0F, *std::ranges::max_element(counts));
  for (int x = 0; x < size.width; ++x) {
    const std::size_t part =
        static_cast<std::size_t>(x) * counts.size() / static_cast<std::size_t>(size.width);
    const int height = static_cast<int>(std::lround(static_cast<float>(size.height) * counts[part] / most));
    if (height > 0) canvas(cv::Rect(x, size.height - height, 1, height)) = cv::Scalar(112, 116, 122);
  }
}

void paint_event_cloud(const Snapshot& snapshot, std::int64_t span_us, double azimuth_rad,
                       double elevation_rad, ImageSize size, RgbImage& rgb) {
  rgb.resize(3 * static_cast<std::size_t>(size.pixels()));
  cv::Mat canvas(size.height, size.width, CV_8UC3, rgb.data());
  canvas = cv::Scalar(ground_rgb[0], ground_rgb[1], ground_rgb[2]);
  const ImageSize image = snapshot.camera.size;
  const BoxView view(azimuth_rad, elevation_rad, size, static_cast<double>(image.width) / image.height);
  const std::span<const Event> events = newest(snapshot, span_us);
  const std::size_t stride = std::max<std::size_t>(1, events.size() / 30'000);
  for (std::size_t i = 0; i < events.size(); i += stride) {
    const Event& event = events[i];
    const double age = static_cast<double>(snapshot.now_us - event.t_us) / static_cast<double>(span_us);
    const cv::Point2d at =
        view.place(2.0 * event.x / image.width - 1.0, 2.0 * event.y / image.height - 1.0, 1.0 - 2.0 * age);
    const int x = static_cast<int>(at.x);
    const int y = static_cast<int>(at.y);
    if (x < 0 || y < 0 || x + 1 >= size.width || y + 1 >= size.height) continue;
    const Rgb& colour = event.on ? on_rgb : off_rgb;
    const cv::Vec3b shade(mix(ground_rgb[0], colour[0], 1.0 - 0.7 * age),
                          mix(ground_rgb[1], colour[1], 1.0 - 0.7 * age),
                          mix(ground_rgb[2], colour[2], 1.0 - 0.7 * age));
    canvas(cv::Rect(x, y, 2, 2)) = shade;
  }
  const auto edge = [&](std::array<double, 3> a, std::array<double, 3> b, double level) {
    cv::line(canvas, view.place(a[0], a[1], a[2]), view.place(b[0], b[1], b[2]), cv::Scalar::all(level), 1,
             cv::LINE_AA);
  };
  for (const double time : {-1.0, 1.0}) {
    const double level = time > 0.0 ? 150 : 60;
    edge({-1, -1, time}, {1, -1, time}, level);
    edge({1, -1, time}, {1, 1, time}, level);
    edge({1, 1, time}, {-1, 1, time}, level);
    edge({-1, 1, time}, {-1, -1, time}, level);
  }
  for (const double x : {-1.0, 1.0}) {
    for (const double y : {-1.0, 1.0}) edge({x, y, -1}, {x, y, 1}, 60);
  }
}

}  // namespace saccade
