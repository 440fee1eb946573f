#include "sim/layer_warp.h"

#include <algorithm>

#if defined(__SSE4_1__)
#include <smmintrin.h>
#endif

#include "core/vector_clones.h"
#include "sim/keyframe.h"

namespace saccade::detail {
namespace {

inline float between(float value, float low, float high) {
  const float raised = value > low ? value : low;
  return raised < high ? raised : high;
}

}  // namespace

/// Samples of the pixels at the inverse depths `w`.
SACCADE_VECTOR_CLONES
void samples_at(const WarpRow& k, const float* x, const float* y, const float* w, float* u, float* v,
                std::size_t count) {
  const auto [a0, a1, a2, a3, a4, a5, a6, a7, a8] = k.a;
  const auto [t0, t1, t2] = k.t;
  for (std::size_t i = 0; i < count; ++i) {
    const float z = a6 * x[i] + a7 * y[i] + a8 + t2 * w[i];
    const float scale = 1.0F / z;
    u[i] = (a0 * x[i] + a1 * y[i] + a2 + t0 * w[i]) * scale;
    v[i] = (a3 * x[i] + a4 * y[i] + a5 + t1 * w[i]) * scale;
  }
}

/// The block of inverse depths of each sample.
SACCADE_VECTOR_CLONES
void blocks_at(const WarpRow& k, const float* u, const float* v, int* block, std::size_t count) {
  const float per_sample = k.blocks_per_sample;
  const auto right = static_cast<float>(k.block_columns - 1);
  const auto bottom = static_cast<float>(k.block_rows - 1);
  const int stride = k.block_columns;
  for (std::size_t i = 0; i < count; ++i) {
    const int column = static_cast<int>(between((u[i] + 0.5F) * per_sample, 0.0F, right));
    const int row = static_cast<int>(between((v[i] + 0.5F) * per_sample, 0.0F, bottom));
    block[i] = row * stride + column;
  }
}

/// From inverse depths in the keyframe to those of the pixels.
SACCADE_VECTOR_CLONES
void depths_of(const WarpRow& k, const float* x, const float* y, float* w, std::size_t count) {
  const float a6 = k.a[6];
  const float a7 = k.a[7];
  const float a8 = k.a[8];
  const float t2 = k.t[2];
  for (std::size_t i = 0; i < count; ++i) w[i] = w[i] * (a6 * x[i] + a7 * y[i] + a8) / (1.0F - w[i] * t2);
}

/// The first of the four samples around each point, and the point's place between them, which replaces u and v.
SACCADE_VECTOR_CLONES
void squares_at(const WarpRow& k, float* u, float* v, int* first, std::size_t count) {
  const float right = static_cast<float>(k.columns) - 1.001F;
  const float bottom = static_cast<float>(k.rows) - 1.001F;
  const int stride = k.columns;
  for (std::size_t i = 0; i < count; ++i) {
    const float inside_u = between(u[i], 0.0F, right);
    const float inside_v = between(v[i], 0.0F, bottom);
    const int column = static_cast<int>(inside_u);
    const int row = static_cast<int>(inside_v);
    u[i] = inside_u - static_cast<float>(column);
    v[i] = inside_v - static_cast<float>(row);
    first[i] = 2 * (row * stride + column);
  }
}

// The loops that look values up are not cloned: gathers of AVX2 are slower than single loads.

void look_up(const float* values, const int* at, float* out, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) out[i] = values[at[i]];
}

/// `step`: the unit of the values.
void interpolate(const std::uint16_t* pairs, const int* first, const float* part_u, const float* part_v,
                 float step, float* out, std::size_t count) {
  std::size_t i = 0;
#if defined(__SSE4_1__)
  // The four values around a point are 8 bytes. Four points at once, transposed; each operation as below.
  const auto values_at = [&](std::size_t point) {
    return _mm_loadl_epi64(reinterpret_cast<const __m128i*>(pairs + first[point]));
  };
  const auto low_half = [](__m128i values) { return _mm_cvtepi32_ps(_mm_cvtepu16_epi32(values)); };
  const auto high_half = [&](__m128i values) { return low_half(_mm_srli_si128(values, 8)); };
  const auto mix = [](__m128 a, __m128 b, __m128 part) {
    return _mm_add_ps(a, _mm_mul_ps(part, _mm_sub_ps(b, a)));
  };
  const __m128 steps = _mm_set1_ps(step);
  constexpr std::size_t ahead = 64;  // points, whose samples come from memory meanwhile
  for (; i + 4 <= count; i += 4) {
    for (const std::size_t next : {i + ahead, i + ahead + 2})
      _mm_prefetch(reinterpret_cast<const char*>(pairs + first[std::min(next, count - 1)]), _MM_HINT_T0);
    const __m128i first_two = _mm_unpacklo_epi16(values_at(i), values_at(i + 1));
    const __m128i last_two = _mm_unpacklo_epi16(values_at(i + 2), values_at(i + 3));
    const __m128i left = _mm_unpacklo_epi32(first_two, last_two);
    const __m128i right = _mm_unpackhi_epi32(first_two, last_two);
    const __m128 down = _mm_loadu_ps(part_v + i);
    const __m128 at_left = mix(low_half(left), high_half(left), down);
    const __m128 at_right = mix(low_half(right), high_half(right), down);
    _mm_storeu_ps(out + i, _mm_mul_ps(mix(at_left, at_right, _mm_loadu_ps(part_u + i)), steps));
  }
#endif
  for (; i < count; ++i) {
    const std::uint16_t* const at = pairs + first[i];
    const std::array<float, 4> values{static_cast<float>(at[0]), static_cast<float>(at[1]),
                                      static_cast<float>(at[2]), static_cast<float>(at[3])};
    const float left = values[0] + part_v[i] * (values[1] - values[0]);
    const float right = values[2] + part_v[i] * (values[3] - values[2]);
    out[i] = (left + part_u[i] * (right - left)) * step;
  }
}

void warp_row(const WarpRow& k, const float* x, const float* y, std::size_t count, const WarpResult& result) {
  float* const w = result.inverse_depth_1_m;
  std::fill_n(w, count, k.start_1_m);
  depths_of(k, x, y, w, count);
  samples_at(k, x, y, w, result.u, result.v, count);
  for (int i = 0; i < k.iterations; ++i) {
    blocks_at(k, result.u, result.v, result.at, count);
    look_up(k.inverse_depth_1_m, result.at, w, count);
    depths_of(k, x, y, w, count);
    samples_at(k, x, y, w, result.u, result.v, count);
  }
  squares_at(k, result.u, result.v, result.at, count);
  interpolate(k.luminance, result.at, result.u, result.v, Keyframe::luminance_step, result.luminance, count);
  if (k.cover != nullptr)
    interpolate(k.cover, result.at, result.u, result.v, Keyframe::cover_step, result.cover, count);
}

}  // namespace saccade::detail
