#include "evaluation/calibration/grid_finder.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace saccade {
namespace {

constexpr float threshold = 0.2F;  // log brightness per event; only the shape of edges depends on it
constexpr std::int64_t support_us = 150'000;
constexpr std::int64_t burst_us = 20'000;
/// Width of the image in which the dots are searched: a larger one is made smaller, so that noise of its pixels averages
/// out.
constexpr double searched_width_px = 512.0;
constexpr double farthest_centroid_px = 6.0;  // of a dot's darkness from its blob, in that image

/// Darker than what white keeps of a dot that has passed: noise, and what the pixel missed of a fast edge.
constexpr double white_darkness = 0.5;

/// The distance to the nearest other dot.
double distance_to_next(const std::vector<cv::Point2f>& dots, std::size_t i) {
  double nearest = 1e9;
  for (std::size_t k = 0; k < dots.size(); ++k) {
    if (k != i) nearest = std::min(nearest, cv::norm(dots[k] - dots[i]));
  }
  return nearest;
}

/// A dot is bright in its middle where white has not passed it within the window.
constexpr double dark_middle = 0.4;

}  // namespace

std::vector<cv::Point3d> DotGrid::points_m() const {
  std::vector<cv::Point3d> points;
  for (int i = 0; i < rows; ++i) {
    for (int k = 0; k < columns; ++k) {
      points.emplace_back(spacing_m * (2 * k + i % 2 - 0.5 * (2 * columns - 1)),
                          spacing_m * (i - 0.5 * (rows - 1)), 0.0);
    }
  }
  return points;
}

ReconstructedImage::ReconstructedImage(ImageSize size, std::int64_t window_us, std::int64_t refractory_us)
    : size_(size),
      window_us_(window_us),
      refractory_us_(refractory_us),
      pixels_(static_cast<std::size_t>(size.pixels())),
      newest_us_(static_cast<std::size_t>((size.width + 2) * (size.height + 2)), -2 * support_us) {}

ReconstructedImage::Pixel ReconstructedImage::at_window(Pixel pixel, std::int64_t window) {
  if (window > pixel.window) {
    pixel.highest_before = window == pixel.window + 1 ? pixel.highest : pixel.level;
    pixel.highest = pixel.level;
    pixel.window = window;
  }
  return pixel;
}

void ReconstructedImage::add(std::span<const Event> events) {
  const std::ptrdiff_t row = size_.width + 2;
  for (const Event& event : events) {
    std::int64_t* const newest = newest_us_.data() + (event.y + 1) * row + event.x + 1;
    std::int64_t neighbour_us = std::max(newest[-1], newest[1]);
    for (const std::ptrdiff_t other : {-row, row}) {
      neighbour_us = std::max({neighbour_us, newest[other - 1], newest[other], newest[other + 1]});
    }
    const std::int64_t since_us = event.t_us - *newest;
    *newest = event.t_us;
    if (event.t_us - neighbour_us > support_us) continue;
    Pixel& pixel = pixels_[static_cast<std::size_t>(event.y * size_.width + event.x)];
    pixel = at_window(pixel, event.t_us / window_us_);
    // In a burst the pixel was blind for a part of the time since the previous event, while the light kept changing.
    const bool burst = since_us < burst_us && (pixel.ahead > 0.0F) == event.on;
    const std::int64_t seen_us = std::max(since_us - refractory_us_, since_us / 3);
    const float missed =
        burst && seen_us > 0 ? static_cast<float>(since_us) / static_cast<float>(seen_us) : 1.0F;
    pixel.level += missed * (event.on ? threshold : -threshold);
    pixel.ahead = event.on ? 0.5F * threshold : -0.5F * threshold;
    pixel.highest = std::max(pixel.highest, pixel.level);
  }
}

cv::Mat ReconstructedImage::image(std::int64_t now_us) const {
  cv::Mat image(size_.height, size_.width, CV_32F);
  for (int y = 0; y < size_.height; ++y) {
    for (int x = 0; x < size_.width; ++x) {
      const Pixel pixel =
          at_window(pixels_[static_cast<std::size_t>(y * size_.width + x)], now_us / window_us_);
      image.at<float>(y, x) = std::exp(pixel.level + pixel.ahead -
                                       std::max(pixel.highest, pixel.highest_before) - 0.5F * threshold);
    }
  }
  return image;
}

std::optional<cv::Point2d> dot_centroid(const cv::Mat& image, cv::Point2d at, double reach_px) {
  for (int round = 0; round < 3; ++round) {
    double mass = 0.0;
    cv::Point2d sum(0.0, 0.0);
    for (int y = static_cast<int>(std::floor(at.y - reach_px)); y <= std::ceil(at.y + reach_px); ++y) {
      for (int x = static_cast<int>(std::floor(at.x - reach_px)); x <= std::ceil(at.x + reach_px); ++x) {
        const double inside = std::clamp(reach_px - std::hypot(x - at.x, y - at.y) + 0.5, 0.0, 1.0);
        if (inside == 0.0) continue;
        if (x < 0 || y < 0 || x >= image.cols || y >= image.rows) return std::nullopt;
        const double dark = 1.0 - static_cast<double>(image.at<float>(y, x));
        const double weight = inside * std::max(dark - white_darkness, 0.0);
        mass += weight;
        sum += weight * cv::Point2d(x, y);
      }
    }
    if (!(mass > 0.0)) return std::nullopt;
    at = sum / mass;
  }
  const cv::Rect around(cvRound(at.x) - 1, cvRound(at.y) - 1, 3, 3);
  if ((around & cv::Rect({}, image.size())) != around) return std::nullopt;
  const double middle = cv::mean(image(around))[0];
  return middle < dark_middle ? std::optional(at) : std::nullopt;
}

std::optional<std::vector<cv::Point2d>> find_grid(const cv::Mat& image, const DotGrid& grid) {
  const double scale = searched_width_px / image.cols;
  cv::Mat grey;
  image.convertTo(grey, CV_8U, 255.0);
  cv::medianBlur(grey, grey, 3);
  cv::resize(grey, grey, {}, scale, scale, scale < 1.0 ? cv::INTER_AREA : cv::INTER_LINEAR);
  cv::SimpleBlobDetector::Params params;
  params.minThreshold = 60;
  params.maxThreshold = 200;
  params.thresholdStep = 20;
  params.minRepeatability = 2;
  params.minDistBetweenBlobs = 12.0F;
  params.blobColor = 0;
  params.minArea = 128.0F;
  params.maxArea = 8000.0F;
  params.filterByCircularity = false;
  params.filterByInertia = true;
  params.minInertiaRatio = 0.15F;
  params.filterByConvexity = true;
  params.minConvexity = 0.8F;
  std::vector<cv::Point2f> found;
  const cv::Ptr<cv::FeatureDetector> blobs = cv::SimpleBlobDetector::create(params);
  const cv::Size pattern(grid.columns, grid.rows);
  if (!cv::findCirclesGrid(grey, pattern, found, cv::CALIB_CB_ASYMMETRIC_GRID, blobs)) return std::nullopt;
  std::vector<cv::Point2d> dots;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const cv::Point2d middle((found[i].x + 0.5) / scale - 0.5, (found[i].y + 0.5) / scale - 0.5);
    const auto centroid = dot_centroid(image, middle, 0.5 * distance_to_next(found, i) / scale);
    if (!centroid || cv::norm(*centroid - middle) * scale > farthest_centroid_px) return std::nullopt;
    dots.push_back(*centroid);
  }
  return dots;
}

}  // namespace saccade
