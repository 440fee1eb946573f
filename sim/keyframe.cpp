#include "sim/keyframe.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <iterator>
#include <limits>

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

/// An interval of samples around the middle of a sample: it begins in sample `first` and ends in sample `last`, counted
/// from that sample, and leaves out the share first_part of the first and takes the share last_part of the last.
struct Interval {
  int first;
  int last;
  float first_part;
  float last_part;
  float length;
};

Interval interval_between(float begin, float end) {
  const float first = std::floor(begin);
  const float last = std::floor(end);
  return {static_cast<int>(first), static_cast<int>(last), begin - first, end - last, end - begin};
}

Interval interval_of(float width) { return interval_between(0.5F - 0.5F * width, 0.5F + 0.5F * width); }

/// The same around `sample`, cut at the border of `count` samples.
Interval cut_interval(float width, int sample, int count) {
  const auto at = static_cast<float>(sample);
  const float begin = std::max(at + 0.5F - 0.5F * width, 0.0F);
  const float end = std::min(at + 0.5F + 0.5F * width, static_cast<float>(count) - 0.001F);
  Interval interval = interval_between(begin, end);
  interval.first -= sample;
  interval.last -= sample;
  return interval;
}

float as_float(std::uint32_t difference) { return static_cast<float>(static_cast<std::int32_t>(difference)); }

std::uint16_t rounded(float value) {
  constexpr float most = 65535.0F;
  const float inside = value > 0.0F ? value : 0.0F;
  return static_cast<std::uint16_t>(static_cast<std::int32_t>((inside < most ? inside : most) + 0.5F));
}

/// Gives every 0 of the row the nearest value that is not. Returns false if all are 0.
bool fill_row(float* row, std::size_t columns) {
  std::size_t begin = 0;  // of the zeros before i
  for (std::size_t i = 0; i < columns; ++i) {
    if (!(row[i] > 0.0F)) continue;
    const std::size_t middle = begin == 0 ? 0 : begin + (i - begin) / 2;
    if (begin > 0) std::fill(row + begin, row + middle, row[begin - 1]);
    std::fill(row + middle, row + i, row[i]);
    begin = i + 1;
  }
  if (begin > 0) std::fill(row + begin, row + columns, row[begin - 1]);
  return begin > 0;
}

/// Continues the depths of a layer's outline around it: a pixel that the outline cuts moves as the outline does.
void continue_outwards(std::vector<float>& depths, std::size_t columns) {
  const std::size_t rows = depths.size() / columns;
  const auto row_at = [&](std::size_t row) { return depths.data() + row * columns; };
  std::size_t begin = 0;  // of the empty rows before `row`
  for (std::size_t row = 0; row < rows; ++row) {
    if (!fill_row(row_at(row), columns)) continue;
    const std::size_t middle = begin == 0 ? 0 : begin + (row - begin) / 2;
    for (std::size_t i = begin; i < row; ++i)
      std::copy_n(row_at(i < middle ? begin - 1 : row), columns, row_at(i));
    begin = row + 1;
  }
  for (std::size_t i = begin; begin > 0 && i < rows; ++i) std::copy_n(row_at(begin - 1), columns, row_at(i));
}

float smaller(float a, float b) { return a < b ? a : b; }

/// The least value within `reach` columns and rows of each; values beyond the border count as the border's.
void least_around(std::vector<float>& values, std::size_t columns, std::size_t reach,
                  std::vector<float>& room) {
  const std::size_t rows = values.size() / columns;
  room = values;
  for (std::size_t row = 0; row < rows; ++row) {
    const float* const from = values.data() + row * columns;
    float* const to = room.data() + row * columns;
    for (std::size_t by = 1; by <= std::min(reach, columns - 1); ++by) {
      for (std::size_t i = 0; i + by < columns; ++i) to[i] = smaller(to[i], from[i + by]);
      for (std::size_t i = by; i < columns; ++i) to[i] = smaller(to[i], from[i - by]);
    }
  }
  values = room;
  for (std::size_t by = 1; by <= std::min(reach, rows - 1); ++by) {
    const std::size_t count = (rows - by) * columns;
    const std::size_t shift = by * columns;
    for (std::size_t i = 0; i < count; ++i) values[i] = smaller(values[i], room[i + shift]);
    for (std::size_t i = 0; i < count; ++i) values[i + shift] = smaller(values[i + shift], room[i]);
  }
}

/// The order of positive floats is that of their bits; the compiler vectorises maxima of whole numbers.
std::int32_t bits_of(float value) { return std::bit_cast<std::int32_t>(value); }

struct Range {
  std::int32_t least = std::numeric_limits<std::int32_t>::max();
  std::int32_t most = 0;
};

/// Widens the range by the values that are not 0.
void include(const float* values, std::size_t count, Range& range) {
  std::int32_t least = range.least;
  std::int32_t most = range.most;
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t bits = bits_of(values[i]);
    most = std::max(most, bits);
    least = std::min(least, bits == 0 ? std::numeric_limits<std::int32_t>::max() : bits);
  }
  range = {least, most};
}

/// The largest difference between values of two rows that both are not 0, or `most`.
std::int32_t largest_step(const float* a, const float* b, std::size_t count, std::int32_t most) {
  for (std::size_t i = 0; i < count; ++i) {
    const float step = a[i] > 0.0F && b[i] > 0.0F ? std::abs(a[i] - b[i]) : 0.0F;
    most = std::max(most, bits_of(step));
  }
  return most;
}

}  // namespace

void KeyframeFilter::copy_depths(Keyframe& k, std::span<const float> depth, double near_m, double far_m,
                                 bool is_room) {
  const auto columns = static_cast<std::size_t>(k.rect.columns());
  const auto rows = static_cast<std::size_t>(k.rect.rows());
  const auto block = static_cast<std::size_t>(is_room ? camera_->samples() : 1);
  const std::size_t block_columns = (columns + block - 1) / block;
  const std::size_t block_rows = (rows + block - 1) / block;
  const auto at_near = static_cast<float>(1.0 / near_m);
  const auto per_depth = static_cast<float>((far_m - near_m) / (near_m * far_m));
  const float nothing = is_room ? static_cast<float>(1.0 / far_m) : 0.0F;
  k.block = static_cast<int>(block);
  k.block_columns = static_cast<int>(block_columns);
  k.block_rows = static_cast<int>(block_rows);
  k.inverse_depth_1_m.assign(block_columns * block_rows, 0.0F);
  block_counts_.assign(block_columns * block_rows, 0.0F);
  depth_row_.resize(columns);
  depth_row_above_.assign(columns, 0.0F);
  Range range;
  std::int32_t step = 0;
  SampleRect covered{k.rect.columns(), k.rect.rows(), 0, 0};
  for (std::size_t row = 0; row < rows; ++row) {
    const float* const from = depth.data() + (rows - 1 - row) * columns;
    float* const q = depth_row_.data();
    for (std::size_t i = 0; i < columns; ++i) q[i] = from[i] < 1.0F ? at_near - from[i] * per_depth : nothing;
    include(q, columns, range);
    step = largest_step(q + 1, q, columns - 1, step);
    step = largest_step(q, depth_row_above_.data(), columns, step);
    float* sum_of_block = k.inverse_depth_1_m.data() + row / block * block_columns;
    float* count_of_block = block_counts_.data() + row / block * block_columns;
    for (std::size_t begin = 0; begin < columns; begin += block, ++sum_of_block, ++count_of_block) {
      for (std::size_t i = begin; i < std::min(begin + block, columns); ++i) {
        *sum_of_block += q[i];
        *count_of_block += q[i] > 0.0F ? 1.0F : 0.0F;
      }
    }
    const auto is_here = [](float value) { return value > 0.0F; };
    const auto left = std::find_if(q, q + columns, is_here) - q;
    if (left < static_cast<std::ptrdiff_t>(columns)) {
      const auto right =
          std::find_if(std::reverse_iterator(q + columns), std::reverse_iterator(q), is_here).base() - q;
      covered = {std::min(covered.left, static_cast<int>(left)), std::min(covered.top, static_cast<int>(row)),
                 std::max(covered.right, static_cast<int>(right)), static_cast<int>(row) + 1};
    }
    std::swap(depth_row_, depth_row_above_);
  }
  double sum = 0.0;
  double count = 0.0;
  for (std::size_t i = 0; i < block_counts_.size(); ++i) {
    sum += static_cast<double>(k.inverse_depth_1_m[i]);
    count += static_cast<double>(block_counts_[i]);
  }
  k.covered = {};
  k.nearest_1_m = k.farthest_1_m = k.mean_1_m = k.largest_step_1_m = 0.0;
  if (count == 0.0) return;
  k.nearest_1_m = static_cast<double>(std::bit_cast<float>(range.most));
  k.farthest_1_m = static_cast<double>(std::bit_cast<float>(range.least));
  k.mean_1_m = sum / count;
  k.largest_step_1_m = static_cast<double>(std::bit_cast<float>(step));
  const int around = 2 * camera_->samples();
  k.covered = SampleRect{k.rect.left + covered.left - around, k.rect.top + covered.top - around,
                         k.rect.left + covered.right + around, k.rect.top + covered.bottom + around}
                  .cut(k.rect);
  for (std::size_t i = 0; i < block_counts_.size(); ++i) {
    k.inverse_depth_1_m[i] = block_counts_[i] > 0.0F ? k.inverse_depth_1_m[i] / block_counts_[i] : nothing;
  }
  if (!is_room) take_outline_depths(k.inverse_depth_1_m, columns);
}

/// Pixels that the outline cuts are nearly as far away as the outline, and it moves as they do: samples less than a pixel's
/// half diagonal inside the outline get its depth.
void KeyframeFilter::take_outline_depths(std::vector<float>& depths, std::size_t columns) {
  const auto reach = static_cast<std::size_t>(std::lround(0.7 * camera_->samples()));
  inside_ = depths;
  continue_outwards(depths, columns);
  outline_ = depths;
  least_around(outline_, columns, reach, filter_room_);
  least_around(inside_, columns, reach, filter_room_);  // 0 near what is not drawn
  for (std::size_t i = 0; i < depths.size(); ++i) depths[i] = inside_[i] > 0.0F ? depths[i] : outline_[i];
}

/// Means of samples_ over the area of a pixel around each, times `scale`, rounded, as pairs of a sample and the one below it.
/// Sums are whole numbers modulo 2^32, so that differences are exact. Samples that share a PixelSize share the interval.
void KeyframeFilter::mean_over_pixels(const SampleRect& rect, std::vector<std::uint16_t>& pairs,
                                      float scale) {
  const int columns = rect.columns();
  const int rows = rect.rows();
  const auto stride = static_cast<std::ptrdiff_t>(columns);
  row_sums_.resize(static_cast<std::size_t>(columns) + 1);
  const std::size_t sums = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows + 1);
  if (sums_.size() < sums) sums_.resize(sums);
  std::fill_n(sums_.begin(), columns, 0U);
  const auto each_cell = [&](int row, const auto& with) {
    for (int begin = 0; begin < columns;) {
      const int end = std::min(columns, KeyframeCamera::next_cell(rect.left + begin) - rect.left);
      with(begin, end, camera_->pixel_at(rect.left + begin, rect.top + row));
      begin = end;
    }
  };
  for (int row = 0; row < rows; ++row) {
    const std::uint32_t* const from = samples_.data() + row * stride;
    std::uint32_t* const until = row_sums_.data();
    until[0] = 0;
    for (int i = 0; i < columns; ++i) until[i + 1] = until[i] + from[i];
    const std::uint32_t* const before = sums_.data() + row * stride;
    std::uint32_t* const after = sums_.data() + (row + 1) * stride;
    const auto add_mean = [&](int i, const Interval& over, float share) {
      const float sum = as_float(until[i + over.last] - until[i + over.first]) +
                        over.last_part * as_float(from[i + over.last]) -
                        over.first_part * as_float(from[i + over.first]);
      after[i] = before[i] + static_cast<std::uint32_t>(static_cast<std::int32_t>(sum * share + 0.5F));
    };
    each_cell(row, [&](int begin, int end, const KeyframeCamera::PixelSize& pixel) {
      const Interval over = interval_of(pixel.width);
      if (begin + over.first >= 0 && end + over.last <= columns) {
        const float share = 1.0F / over.length;
        for (int i = begin; i < end; ++i) add_mean(i, over, share);
        return;
      }
      for (int i = begin; i < end; ++i) {
        const Interval cut = cut_interval(pixel.width, i, columns);
        add_mean(i, cut, 1.0F / cut.length);
      }
    });
  }
  pairs.resize(2 * rect.area());
  for (int row = 0; row < rows; ++row) {
    std::uint16_t* const to = pairs.data() + 2 * row * stride;
    std::uint16_t* const above = row > 0 ? to - 2 * stride : to;
    each_cell(row, [&](int begin, int end, const KeyframeCamera::PixelSize& pixel) {
      const Interval over = cut_interval(pixel.height, row, rows);
      const std::uint32_t* const first = sums_.data() + (row + over.first) * stride;
      const std::uint32_t* const last = sums_.data() + (row + over.last) * stride;
      const float share = scale / over.length;
      for (int i = begin; i < end; ++i) {
        const float sum = as_float(last[i] - first[i]) +
                          over.last_part * as_float(last[i + stride] - last[i]) -
                          over.first_part * as_float(first[i + stride] - first[i]);
        to[2 * i] = above[2 * i + 1] = rounded(sum * share);
      }
    });
  }
  std::uint16_t* const bottom = pairs.data() + 2 * (rows - 1) * stride;
  for (int i = 0; i < columns; ++i) bottom[2 * i + 1] = bottom[2 * i];
}

void KeyframeFilter::average_colours(Keyframe& k, std::span<const std::uint32_t> rgba,
                                     std::span<const float> depth, bool is_room) {
  const auto columns = static_cast<std::size_t>(k.rect.columns());
  const auto rows = static_cast<std::size_t>(k.rect.rows());
  if (samples_.size() < columns * rows) samples_.resize(columns * rows);
  const auto each_sample = [&](const auto& value_of) {
    for (std::size_t row = 0; row < rows; ++row) {
      const std::size_t from = (rows - 1 - row) * columns;
      for (std::size_t i = 0; i < columns; ++i) samples_[row * columns + i] = value_of(from + i);
    }
  };
  each_sample([&](std::size_t i) { return depth[i] < 1.0F ? luminance_of(rgba[i]) : 0U; });
  mean_over_pixels(k.rect, k.luminance, 1.0F / (static_cast<float>(unit) * Keyframe::luminance_step));
  k.cover.clear();
  if (is_room) return;
  constexpr std::uint32_t full = 1U << 20U;
  each_sample([&](std::size_t i) { return depth[i] < 1.0F ? full : 0U; });
  mean_over_pixels(k.rect, k.cover, 1.0F / (static_cast<float>(full) * Keyframe::cover_step));
}

void KeyframeFilter::fill(Keyframe& k, std::span<const std::uint32_t> rgba, std::span<const float> depth,
                          double near_m, double far_m, bool is_room, WorkerThreads& threads) {
  const auto part = [&](std::size_t i) {
    if (i == 0) average_colours(k, rgba, depth, is_room);
    if (i == std::min<std::size_t>(1, threads.threads() - 1)) copy_depths(k, depth, near_m, far_m, is_room);
  };
  threads.run(part);
}

}  // namespace saccade::detail
