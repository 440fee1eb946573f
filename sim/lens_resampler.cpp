#include "sim/lens_resampler.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "core/error.h"

namespace saccade {
namespace {

// Rec. 709 luminance of linear red, green and blue, in 1/10000.
constexpr std::uint32_t red_weight = 2126;
constexpr std::uint32_t green_weight = 7152;
constexpr std::uint32_t blue_weight = 722;

/// A convex polygon of few corners.
struct Polygon {
  std::array<Eigen::Vector2d, 8> corners;
  std::size_t count = 0;

  void add(const Eigen::Vector2d& corner) { corners.at(count++) = corner; }
  /// The part where sign * (coordinate - bound) >= 0.
  [[nodiscard]] Polygon clipped(Eigen::Index axis, double bound, double sign) const {
    Polygon part;
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Vector2d& from = corners.at(i);
      const Eigen::Vector2d& to = corners.at((i + 1) % count);
      const double begin = sign * (from[axis] - bound);
      const double end = sign * (to[axis] - bound);
      if (begin >= 0.0) part.add(from);
      if ((begin < 0.0) != (end < 0.0)) part.add(from + (to - from) * (begin / (begin - end)));
    }
    return part;
  }
  [[nodiscard]] double area() const {
    double twice = 0.0;
    for (std::size_t i = 1; i + 1 < count; ++i) {
      const Eigen::Vector2d a = corners.at(i) - corners[0];
      const Eigen::Vector2d b = corners.at(i + 1) - corners[0];
      twice += a.x() * b.y() - a.y() * b.x();
    }
    return 0.5 * std::abs(twice);
  }
  [[nodiscard]] std::array<int, 2> span(Eigen::Index axis) const {
    double low = corners[0][axis];
    double high = low;
    for (std::size_t i = 1; i < count; ++i) {
      low = std::min(low, corners.at(i)[axis]);
      high = std::max(high, corners.at(i)[axis]);
    }
    return {static_cast<int>(std::floor(low)), static_cast<int>(std::ceil(high))};
  }
};

/// A thread's part of `count`, as equal as can be.
std::array<std::size_t, 2> part_of(std::size_t count, std::size_t part, const WorkerThreads& threads) {
  return {count * part / threads.threads(), count * (part + 1) / threads.threads()};
}

}  // namespace

LensResampler::LensResampler(const Camera& camera, std::int64_t supersampling)
    : focal_(static_cast<double>(supersampling) * camera.fy_px) {
  const auto width = static_cast<std::size_t>(camera.size.width);
  const auto height = static_cast<std::size_t>(camera.size.height);
  // Where the corners of the pixels are in the drawn image.
  std::vector<Eigen::Vector2d> corners;
  corners.reserve((width + 1) * (height + 1));
  Eigen::Vector2d low = Eigen::Vector2d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Vector2d high = -low;
  for (std::size_t y = 0; y <= height; ++y) {
    for (std::size_t x = 0; x <= width; ++x) {
      const Eigen::Vector3d ray = camera.ray(static_cast<double>(x) - 0.5, static_cast<double>(y) - 0.5);
      if (!ray.allFinite()) {
        throw InputError("camera",
                         "a lens without a ray at (" + std::to_string(x) + ", " + std::to_string(y) + ")",
                         "a lens that shows every pixel");
      }
      corners.emplace_back(focal_ * ray.head<2>());
      low = low.cwiseMin(corners.back());
      high = high.cwiseMax(corners.back());
    }
  }
  for (Eigen::Vector2d& corner : corners) corner -= low;
  constexpr double rounding = 1e-9;
  const Eigen::Vector2d drawn_size = (high - low).array() - rounding;
  if (!(drawn_size.maxCoeff() <= max_side)) {
    throw InputError("render.supersampling",
                     std::to_string(supersampling) + " of this camera: an image of " +
                         text_of(std::ceil(drawn_size.x())) + " x " + text_of(std::ceil(drawn_size.y())) +
                         " samples",
                     "at most " + std::to_string(max_side) + " samples in width and height");
  }
  columns_ = static_cast<int>(std::ceil(drawn_size.x()));
  rows_ = static_cast<int>(std::ceil(drawn_size.y()));
  centre_x_ = -low.x();
  centre_y_ = -low.y();

  const auto columns = static_cast<std::size_t>(columns_);
  const std::size_t drawn = columns * static_cast<std::size_t>(rows_);
  std::vector<double> covered(drawn, 0.0);  // of each sample by all pixels
  for (std::size_t pixel = 0; pixel < width * height; ++pixel) {
    const std::size_t corner = pixel + pixel / width;
    Polygon footprint;
    for (const std::size_t i : {corner, corner + 1, corner + width + 2, corner + width + 1}) {
      footprint.add(corners[i]);
    }
    const double share = 1.0 / (footprint.area() * 10000.0);
    const auto [top, bottom] = footprint.span(1);
    for (int row = top; row < std::min(bottom, rows_); ++row) {
      const Polygon strip = footprint.clipped(1, row, 1.0).clipped(1, row + 1, -1.0);
      if (strip.area() < rounding) continue;
      const auto [left, right] = strip.span(0);
      for (int column = left; column < std::min(right, columns_); ++column) {
        const double area = strip.clipped(0, column, 1.0).clipped(0, column + 1, -1.0).area();
        const int in_group = (column - left) % 4;
        const std::size_t sample =
            static_cast<std::size_t>(rows_ - 1 - row) * columns + static_cast<std::size_t>(column);
        if (in_group == 0) samples_.push_back({static_cast<std::uint32_t>(sample), {}});
        samples_.back().weights.at(static_cast<std::size_t>(in_group)) = static_cast<float>(area * share);
        covered[sample] += area;
      }
    }
    samples_end_.push_back(static_cast<std::uint32_t>(samples_.size()));
  }
  is_inside_.resize(drawn);
  std::ranges::transform(covered, is_inside_.begin(), [](double area) { return area >= 0.5 ? 1 : 0; });
  drawn_.assign(channel_size(), 0.0F);
}

template <std::size_t channels>
void LensResampler::resample(std::span<const std::uint32_t> rgba, const ChannelWeights<channels>& weights,
                             std::span<float> image, WorkerThreads& threads) {
  const std::size_t stride = channel_size();
  drawn_.resize(std::max(drawn_.size(), channels * stride));
  threads.run([&](std::size_t part) {
    const auto [begin, end] = part_of(rgba.size(), part, threads);
    for (std::size_t channel = 0; channel < channels; ++channel) {
      const auto [red, green, blue] = weights[channel];
      float* const drawn = drawn_.data() + channel * stride;
      for (std::size_t i = begin; i < end; ++i) {
        const std::uint32_t colours = rgba[i];
        // Signed, because that is what SSE converts.
        drawn[i] = static_cast<float>(static_cast<std::int32_t>(
            red * (colours & 0xffU) + green * ((colours >> 8U) & 0xffU) + blue * ((colours >> 16U) & 0xffU)));
      }
    }
  });
  const std::size_t pixels = image.size() / channels;
  threads.run([&](std::size_t part) {
    const auto [first, last] = part_of(pixels, part, threads);
    const Samples* samples = samples_.data() + (first == 0 ? 0 : samples_end_[first - 1]);
    for (std::size_t pixel = first; pixel < last; ++pixel) {
      std::array<std::array<float, 4>, channels> sums{};
      for (const Samples* end = samples_.data() + samples_end_[pixel]; samples != end; ++samples) {
        for (std::size_t channel = 0; channel < channels; ++channel) {
          const float* const from = drawn_.data() + channel * stride + samples->first;
          for (std::size_t i = 0; i < 4; ++i) sums[channel][i] += samples->weights[i] * from[i];
        }
      }
      for (std::size_t channel = 0; channel < channels; ++channel) {
        const std::array<float, 4>& sum = sums[channel];
        image[channel * pixels + pixel] = (sum[0] + sum[1]) + (sum[2] + sum[3]);
      }
    }
  });
}

void LensResampler::luminance(std::span<const std::uint32_t> rgba, std::span<float> image,
                              WorkerThreads& threads) {
  resample<1>(rgba, {{{red_weight, green_weight, blue_weight}}}, image, threads);
}

void LensResampler::colour(std::span<const std::uint32_t> rgba, std::span<float> image,
                           WorkerThreads& threads) {
  resample<3>(rgba, {{{10000, 0, 0}, {0, 10000, 0}, {0, 0, 10000}}}, image, threads);
}

void LensResampler::smallest(std::span<const std::uint32_t> rgba, std::uint8_t nothing,
                             std::span<std::uint8_t> numbers) const {
  const Samples* samples = samples_.data();
  for (std::size_t pixel = 0; pixel < numbers.size(); ++pixel) {
    std::uint32_t smallest = 255;
    for (const Samples* end = samples_.data() + samples_end_[pixel]; samples != end; ++samples) {
      for (std::size_t i = 0; i < 4; ++i) {
        if (!(samples->weights[i] > 0.0F)) continue;
        const std::uint32_t number = rgba[samples->first + i] & 0xffU;
        if (number > 0) smallest = std::min(smallest, number);
      }
    }
    numbers[pixel] = smallest == 255 ? nothing : static_cast<std::uint8_t>(smallest);
  }
}

}  // namespace saccade
