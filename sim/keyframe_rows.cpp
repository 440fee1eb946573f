#include "sim/keyframe_rows.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "core/vector_clones.h"

namespace saccade::detail {
namespace {

constexpr std::uint32_t red_weight = 2126;
constexpr std::uint32_t green_weight = 7152;
constexpr std::uint32_t blue_weight = 722;
static_assert(red_weight + green_weight + blue_weight == luminance_unit);

inline float as_float(std::uint32_t difference) {
  return static_cast<float>(static_cast<std::int32_t>(difference));
}

inline float sum_of(const MeanRun& run, int i) {
  return as_float(run.last[i] - run.first[i]) + run.last_part * as_float(run.last_next[i] - run.last[i]) -
         run.first_part * as_float(run.first_next[i] - run.first[i]);
}

/// Rounds a number that is not negative, in a way that the compiler vectorises.
inline std::int32_t rounded(float value) {
  const float raised = value + 0.5F;
  return static_cast<std::int32_t>(raised);
}

inline float smaller(float a, float b) { return a < b ? a : b; }

inline std::int32_t bits_of(float value) { return std::bit_cast<std::int32_t>(value); }

}  // namespace

SACCADE_VECTOR_CLONES
void luminance_row(const std::uint32_t* rgba, const float* depth, std::uint32_t* out, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t value = red_weight * (rgba[i] & 0xffU) + green_weight * ((rgba[i] >> 8U) & 0xffU) +
                                blue_weight * ((rgba[i] >> 16U) & 0xffU);
    out[i] = depth[i] < 1.0F ? value : 0U;
  }
}

SACCADE_VECTOR_CLONES
void cover_row(const float* depth, std::uint32_t full, std::uint32_t* out, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) out[i] = depth[i] < 1.0F ? full : 0U;
}

SACCADE_VECTOR_CLONES
void inverse_depth_row(const float* depth, float at_near, float per_depth, float nothing, float* out,
                       std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    const float value = at_near - depth[i] * per_depth;
    out[i] = depth[i] < 1.0F ? value : nothing;
  }
}

SACCADE_VECTOR_CLONES
void add_means(std::span<const MeanRun> runs, const std::uint32_t* before, std::uint32_t* __restrict after) {
  for (const MeanRun run : runs) {
    for (int i = run.begin; i < run.end; ++i)
      after[i] = before[i] + static_cast<std::uint32_t>(rounded(sum_of(run, i) * run.share));
  }
}

SACCADE_VECTOR_CLONES
void write_means(std::span<const MeanRun> runs, std::uint16_t* __restrict out) {
  constexpr float most = 65535.0F;
  for (const MeanRun run : runs) {
    for (int i = run.begin; i < run.end; ++i) {
      const float value = sum_of(run, i) * run.share;
      const float inside = value > 0.0F ? value : 0.0F;
      out[i] = static_cast<std::uint16_t>(rounded(inside < most ? inside : most));
    }
  }
}

SACCADE_VECTOR_CLONES
void interleave_rows(const std::uint16_t* top, const std::uint16_t* bottom, std::uint16_t* __restrict out,
                     std::size_t stride, std::size_t count) {
  const auto write = [&](std::size_t i, std::size_t at) {
    out[at] = top[i];
    out[at + 1] = bottom[i];
  };
  if (stride == 2) {  // vectors
    for (std::size_t i = 0; i < count; ++i) write(i, 2 * i);
  } else {
    for (std::size_t i = 0; i < count; ++i) write(i, stride * i);
  }
}

SACCADE_VECTOR_CLONES
void include_row(const float* values, std::size_t count, FloatRange& range) {
  auto below_least = static_cast<std::uint32_t>(range.least) - 1U;
  std::int32_t most = range.most;
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t bits = bits_of(values[i]);
    most = std::max(most, bits);
    below_least = std::min(below_least, static_cast<std::uint32_t>(bits) - 1U);  // the largest number for a 0
  }
  range = {static_cast<std::int32_t>(below_least + 1U), most};
}

SACCADE_VECTOR_CLONES
std::int32_t largest_step(const float* a, const float* b, std::size_t count, std::int32_t most) {
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t step = bits_of(std::abs(a[i] - b[i]));
    const bool both = (a[i] > 0.0F) & (b[i] > 0.0F);
    most = std::max(most, both ? step : 0);
  }
  return most;
}

SACCADE_VECTOR_CLONES
double sum_of_row(const float* values, std::size_t count) {
  std::array<double, columns_summed_at_once> parts{};
  std::size_t i = 0;
  for (; i + parts.size() <= count; i += parts.size()) {
    for (std::size_t j = 0; j < parts.size(); ++j) parts[j] += static_cast<double>(values[i + j]);
  }
  double sum = 0.0;
  for (const double part : parts) sum += part;
  for (; i < count; ++i) sum += static_cast<double>(values[i]);
  return sum;
}

SACCADE_VECTOR_CLONES
void least_along_row(const float* padded, std::size_t width, float* __restrict out, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) out[i] = padded[i];
  for (std::size_t by = 1; by < width; ++by) {
    for (std::size_t i = 0; i < count; ++i) out[i] = smaller(out[i], padded[i + by]);
  }
}

SACCADE_VECTOR_CLONES
void take_smaller(const float* others, float* __restrict values, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) values[i] = smaller(values[i], others[i]);
}

SACCADE_VECTOR_CLONES
void choose_row(const float* least, const float* own, const float* edge, float* __restrict out,
                std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) out[i] = least[i] > 0.0F ? own[i] : edge[i];
}

}  // namespace saccade::detail
