#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

// The loops over one row of a keyframe's samples. Each value is computed by itself, so that results depend neither on the
// width of vectors nor on which thread computes which row.

namespace saccade::detail {

/// Rec. 709 luminance of linear red, green and blue, in units of 1/luminance_unit grey level; 0 where nothing is drawn.
constexpr std::uint32_t luminance_unit = 10000;
void luminance_row(const std::uint32_t* rgba, const float* depth, std::uint32_t* out, std::size_t count);

/// `full` where something is drawn, 0 elsewhere.
void cover_row(const float* depth, std::uint32_t full, std::uint32_t* out, std::size_t count);

/// Inverse depths, at_near - depth * per_depth, and `nothing` where nothing is drawn.
void inverse_depth_row(const float* depth, float at_near, float per_depth, float nothing, float* out,
                       std::size_t count);

/// Columns [begin, end) of a row whose means are taken over intervals of the same size: from the samples at first[i], of which
/// it leaves out the share first_part, to those at last[i], of which it takes the share last_part. `first` and `last` are sums
/// of all samples before those; the sums that include them are first_next and last_next. Sums count modulo 2^32.
struct MeanRun {
  int begin;
  int end;
  const std::uint32_t* first;
  const std::uint32_t* first_next;
  const std::uint32_t* last;
  const std::uint32_t* last_next;
  float first_part;
  float last_part;
  float share;  ///< of the interval's sum
};

/// after[i] = before[i] + the mean at i, rounded.
void add_means(std::span<const MeanRun> runs, const std::uint32_t* before, std::uint32_t* after);
/// out[i] = the mean at i, rounded and held within 16 bits.
void write_means(std::span<const MeanRun> runs, std::uint16_t* out);

/// Values of two rows side by side: out[0] = top[0], out[1] = bottom[0], out[stride] = top[1], ...
void interleave_rows(const std::uint16_t* top, const std::uint16_t* bottom, std::uint16_t* out,
                     std::size_t stride, std::size_t count);

/// Least and largest of values above 0, as the bits of positive floats, whose order is that of the floats.
struct FloatRange {
  std::int32_t least = std::numeric_limits<std::int32_t>::max();
  std::int32_t most = 0;
};
/// Widens the range by the values that are not 0.
void include_row(const float* values, std::size_t count, FloatRange& range);
/// The bits of the largest difference between values of two rows that both are not 0, or `most`.
std::int32_t largest_step(const float* a, const float* b, std::size_t count, std::int32_t most);

inline constexpr std::size_t columns_summed_at_once = 8;
/// The sum of the values; of columns_summed_at_once partial sums, which vector units add side by side.
double sum_of_row(const float* values, std::size_t count);

/// out[i] = the least of padded[i] to padded[i + width - 1].
void least_along_row(const float* padded, std::size_t width, float* out, std::size_t count);
/// values[i] = the smaller of values[i] and others[i].
void take_smaller(const float* others, float* values, std::size_t count);
/// out[i] = own[i] where least[i] is above 0, otherwise edge[i].
void choose_row(const float* least, const float* own, const float* edge, float* out, std::size_t count);

}  // namespace saccade::detail
