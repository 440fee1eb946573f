#include "sim/keyframe.h"

#include <algorithm>
#include <cmath>

namespace saccade::detail {
namespace {

// Rec. 709 luminance of linear red, green and blue, in 1/10000.
constexpr std::uint32_t red_weight = 2126;
constexpr std::uint32_t green_weight = 7152;
constexpr std::uint32_t blue_weight = 722;
constexpr std::uint32_t unit = 10000;

std::uint32_t luminance_of(std::uint32_t rgba) {
  return red_weight * (rgba & 0xffU) + green_weight * ((rgba >> 8U) & 0xffU) +
         blue_weight * ((rgba >> 16U) & 0xffU);
}

/// The bounds of an interval of samples, [first + first_part, last + last_part).
struct Interval {
  int first;
  int last;
  float first_part;
  float last_part;
  float length;
};

/// The interval of `width` samples around the middle of a sample, cut at [0, count).
Interval around(int sample, float width, int count) {
  const float begin = std::max(0.0F, static_cast<float>(sample) + 0.5F - 0.5F * width);
  const float end = std::min(static_cast<float>(count), static_cast<float>(sample) + 0.5F + 0.5F * width);
  const int first = std::min(static_cast<int>(begin), count - 1);
  const int last = std::min(static_cast<int>(end), count - 1);
  return {first, last, begin - static_cast<float>(first), end - static_cast<float>(last), end - begin};
}

}  // namespace

void KeyframeFilter::copy_depths(Keyframe& k, std::span<const float> depth, double near_m, double far_m,
                                 bool is_room) {
  const int columns = k.rect.columns();
  const int rows = k.rect.rows();
  const auto at_near = static_cast<float>(1.0 / near_m);
  const auto per_depth = static_cast<float>((far_m - near_m) / (near_m * far_m));
  const auto nothing = static_cast<float>(1.0 / far_m);
  k.block = camera_->samples();
  k.block_columns = (columns + k.block - 1) / k.block;
  k.block_rows = (rows + k.block - 1) / k.block;
  k.inverse_depth_1_m.assign(
      static_cast<std::size_t>(k.block_columns) * static_cast<std::size_t>(k.block_rows), 0.0F);
  std::vector<float> counts(k.inverse_depth_1_m.size(), 0.0F);
  float nearest = 0.0F;
  float farthest = at_near;
  float step = 0.0F;
  double sum = 0.0;
  std::size_t count = 0;
  SampleRect covered{columns, rows, 0, 0};
  std::vector<float> above(static_cast<std::size_t>(columns), 0.0F);
  for (int row = 0; row < rows; ++row) {
    const float* const from = depth.data() + static_cast<std::ptrdiff_t>(rows - 1 - row) * columns;
    float left = 0.0F;
    for (int column = 0; column < columns; ++column) {
      const bool is_here = from[column] < 1.0F;
      const float q = is_here ? at_near - from[column] * per_depth : is_room ? nothing : 0.0F;
      if (q > 0.0F) {
        nearest = std::max(nearest, q);
        farthest = std::min(farthest, q);
        sum += static_cast<double>(q);
        ++count;
        if (left > 0.0F) step = std::max(step, std::abs(q - left));
        float& over = above[static_cast<std::size_t>(column)];
        if (over > 0.0F) step = std::max(step, std::abs(q - over));
        covered = {std::min(covered.left, column), std::min(covered.top, row),
                   std::max(covered.right, column + 1), std::max(covered.bottom, row + 1)};
        const auto block =
            static_cast<std::size_t>(row / k.block) * static_cast<std::size_t>(k.block_columns) +
            static_cast<std::size_t>(column / k.block);
        k.inverse_depth_1_m[block] += q;
        counts[block] += 1.0F;
      }
      left = above[static_cast<std::size_t>(column)] = q;
    }
  }
  k.nearest_1_m = static_cast<double>(nearest);
  k.farthest_1_m = static_cast<double>(farthest);
  k.mean_1_m = count > 0 ? sum / static_cast<double>(count) : 0.0;
  k.largest_step_1_m = static_cast<double>(step);
  k.covered = {};
  if (count > 0) {
    const int around_px = 2 * k.block;
    k.covered = SampleRect{k.rect.left + covered.left - around_px, k.rect.top + covered.top - around_px,
                           k.rect.left + covered.right + around_px, k.rect.top + covered.bottom + around_px}
                    .cut(k.rect);
  }
  for (std::size_t i = 0; i < counts.size(); ++i) {
    k.inverse_depth_1_m[i] =
        counts[i] > 0.0F ? k.inverse_depth_1_m[i] / counts[i] : static_cast<float>(k.mean_1_m);
  }
}

/// Means of samples_ over the area of a pixel around each, times `scale`, as pairs of a sample and the one below it. Sums are whole numbers modulo 2^32, so that
/// differences are exact.
void KeyframeFilter::mean_over_pixels(const SampleRect& rect, std::vector<float>& pairs, float scale) {
  const int columns = rect.columns();
  const int rows = rect.rows();
  const auto stride = static_cast<std::size_t>(columns);
  row_sums_.resize(stride + 1);
  sums_.resize(stride * static_cast<std::size_t>(rows + 1));
  std::fill_n(sums_.begin(), columns, 0U);
  for (int row = 0; row < rows; ++row) {
    std::uint32_t* const from = samples_.data() + static_cast<std::size_t>(row) * stride;
    row_sums_[0] = 0;
    for (std::size_t i = 0; i < stride; ++i) row_sums_[i + 1] = row_sums_[i] + from[i];
    const std::uint32_t* const before = sums_.data() + static_cast<std::size_t>(row) * stride;
    std::uint32_t* const after = sums_.data() + static_cast<std::size_t>(row + 1) * stride;
    Interval span{};
    for (int column = 0; column < columns; ++column) {
      const auto i = static_cast<std::size_t>(column);
      span = around(column, camera_->pixel_at(rect.left + column, rect.top + row).width, columns);
      const std::uint32_t whole =
          row_sums_[static_cast<std::size_t>(span.last)] - row_sums_[static_cast<std::size_t>(span.first)];
      const float sum = static_cast<float>(static_cast<std::int32_t>(whole)) +
                        span.last_part * static_cast<float>(static_cast<std::int32_t>(from[span.last])) -
                        span.first_part * static_cast<float>(static_cast<std::int32_t>(from[span.first]));
      after[i] = before[i] + static_cast<std::uint32_t>(sum / span.length + 0.5F);
    }
  }
  pairs.resize(2 * rect.area());
  for (int row = 0; row < rows; ++row) {
    float* const to = pairs.data() + 2 * static_cast<std::size_t>(row) * stride;
    float* const above = row > 0 ? to - 2 * stride : to;
    for (int column = 0; column < columns; ++column) {
      const auto i = static_cast<std::size_t>(column);
      const Interval span = around(row, camera_->pixel_at(rect.left + column, rect.top + row).height, rows);
      const auto sum_at = [&](int at) { return sums_[static_cast<std::size_t>(at) * stride + i]; };
      const auto value_at = [&](int at) {
        return static_cast<float>(static_cast<std::int32_t>(sum_at(at + 1) - sum_at(at)));
      };
      const float sum =
          static_cast<float>(static_cast<std::int32_t>(sum_at(span.last) - sum_at(span.first))) +
          span.last_part * value_at(span.last) - span.first_part * value_at(span.first);
      to[2 * i] = above[2 * i + 1] = scale * sum / span.length;
    }
  }
  float* const last = pairs.data() + 2 * static_cast<std::size_t>(rows - 1) * stride;
  for (std::size_t i = 0; i < stride; ++i) last[2 * i + 1] = last[2 * i];
}

void KeyframeFilter::fill(Keyframe& k, std::span<const std::uint32_t> rgba, std::span<const float> depth,
                          double near_m, double far_m, bool is_room) {
  const auto columns = static_cast<std::size_t>(k.rect.columns());
  const auto rows = static_cast<std::size_t>(k.rect.rows());
  copy_depths(k, depth, near_m, far_m, is_room);
  samples_.resize(columns * rows);
  const auto each_sample = [&](const auto& value_of) {
    for (std::size_t row = 0; row < rows; ++row) {
      const std::size_t from = (rows - 1 - row) * columns;
      for (std::size_t i = 0; i < columns; ++i) samples_[row * columns + i] = value_of(from + i);
    }
  };
  each_sample([&](std::size_t i) { return depth[i] < 1.0F ? luminance_of(rgba[i]) : 0U; });
  mean_over_pixels(k.rect, k.luminance, 1.0F / static_cast<float>(unit));
  k.cover.clear();
  if (is_room) return;
  constexpr std::uint32_t full = 1U << 20U;
  each_sample([&](std::size_t i) { return depth[i] < 1.0F ? full : 0U; });
  mean_over_pixels(k.rect, k.cover, 1.0F / static_cast<float>(full));
}

}  // namespace saccade::detail
