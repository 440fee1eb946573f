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
  const auto left = static_cast<float>(k.left);
  const auto top = static_cast<float>(k.top);
  const auto right = static_cast<float>(k.left + k.block_columns - 1);
  const auto bottom = static_cast<float>(k.top + k.block_rows - 1);
  const int stride = k.block_columns;
  const int first = k.top * stride + k.left;
  for (std::size_t i = 0; i < count; ++i) {
    const int column = static_cast<int>(between((u[i] + 0.5F) * per_sample, left, right));
    const int row = static_cast<int>(between((v[i] + 0.5F) * per_sample, top, bottom));
    block[i] = row * stride + column - first;
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
  const auto left = static_cast<float>(k.left);
  const auto top = static_cast<float>(k.top);
  const float right = static_cast<float>(k.left + k.columns) - 1.001F;
  const float bottom = static_cast<float>(k.top + k.rows) - 1.001F;
  const int stride = k.columns;
  const int per_sample = k.has_cover ? 4 : 2;
  const int kept = k.top * stride + k.left;
  for (std::size_t i = 0; i < count; ++i) {
    const float inside_u = between(u[i], left, right);
    const float inside_v = between(v[i], top, bottom);
    const int column = static_cast<int>(inside_u);
    const int row = static_cast<int>(inside_v);
    u[i] = inside_u - static_cast<float>(column);
    v[i] = inside_v - static_cast<float>(row);
    first[i] = per_sample * (row * stride + column - kept);
  }
}

SACCADE_VECTOR_CLONES
void put_over(const BodyRow& body, float least, const float* room_1_m, float* __restrict luminance,
              std::size_t count) {
  const auto [light, cover, depth_1_m] = body;
  for (std::size_t i = 0; i < count; ++i) {
    const float inside = cover[i] < 1.0F ? cover[i] : 1.0F;
    const float over = light[i] + (1.0F - inside) * luminance[i];
    const bool is_seen = (cover[i] > least) & (room_1_m[i] < depth_1_m[i]);
    luminance[i] = is_seen ? over : luminance[i];
  }
}

// The loops that look values up are not cloned: gathers of AVX2 are slower than single loads.

constexpr std::size_t ahead = 64;  ///< points, whose values come from memory meanwhile

#if defined(__SSE4_1__)
inline void fetch(const void* address) { _mm_prefetch(static_cast<const char*>(address), _MM_HINT_T0); }
inline __m128 low_half(__m128i values) { return _mm_cvtepi32_ps(_mm_cvtepu16_epi32(values)); }
inline __m128 high_half(__m128i values) { return low_half(_mm_srli_si128(values, 8)); }
inline __m128 mix(__m128 a, __m128 b, __m128 part) {
  return _mm_add_ps(a, _mm_mul_ps(part, _mm_sub_ps(b, a)));
}
/// Between the samples of four columns, each beside the one below it, and of the four to their right.
inline __m128 between_four(__m128i left, __m128i right, __m128 part_u, __m128 part_v) {
  return mix(mix(low_half(left), high_half(left), part_v), mix(low_half(right), high_half(right), part_v),
             part_u);
}
#endif

void look_up(const float* values, const int* at, float* out, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) out[i] = values[at[i]];
}

/// Between the four samples around a point, of which the left ones begin at `left` and the right ones at `right`.
inline float interpolated(const std::uint16_t* left, const std::uint16_t* right, float part_u, float part_v) {
  const auto down = [&](const std::uint16_t* at) {
    const auto top = static_cast<float>(at[0]);
    return top + part_v * (static_cast<float>(at[1]) - top);
  };
  const float at_left = down(left);
  return at_left + part_u * (down(right) - at_left);
}

void interpolate(const std::uint16_t* samples, const int* first, const float* part_u, const float* part_v,
                 float* luminance, std::size_t count) {
  std::size_t i = 0;
#if defined(__SSE4_1__)
  // The four values around a point are 8 bytes. Four points at once, transposed; each operation as in interpolated().
  const auto values_at = [&](std::size_t point) {
    return _mm_loadl_epi64(reinterpret_cast<const __m128i*>(samples + first[point]));
  };
  const __m128 step = _mm_set1_ps(Keyframe::luminance_step);
  for (; i + 4 <= count; i += 4) {
    for (const std::size_t next : {i + ahead, i + ahead + 2})
      fetch(samples + first[std::min(next, count - 1)]);
    const __m128i first_two = _mm_unpacklo_epi16(values_at(i), values_at(i + 1));
    const __m128i last_two = _mm_unpacklo_epi16(values_at(i + 2), values_at(i + 3));
    const __m128 value =
        between_four(_mm_unpacklo_epi32(first_two, last_two), _mm_unpackhi_epi32(first_two, last_two),
                     _mm_loadu_ps(part_u + i), _mm_loadu_ps(part_v + i));
    _mm_storeu_ps(luminance + i, _mm_mul_ps(value, step));
  }
#endif
  for (; i < count; ++i) {
    const std::uint16_t* const at = samples + first[i];
    luminance[i] = interpolated(at, at + 2, part_u[i], part_v[i]) * Keyframe::luminance_step;
  }
}

/// The same of samples with a cover.
void interpolate_covered(const std::uint16_t* samples, const int* first, const float* part_u,
                         const float* part_v, float* luminance, float* cover, std::size_t count) {
  std::size_t i = 0;
#if defined(__SSE4_1__)
  const auto values_at = [&](std::size_t point) {
    return _mm_loadu_si128(reinterpret_cast<const __m128i*>(samples + first[point]));
  };
  const __m128 luminance_step = _mm_set1_ps(Keyframe::luminance_step);
  const __m128 cover_step = _mm_set1_ps(Keyframe::cover_step);
  for (; i + 4 <= count; i += 4) {
    for (std::size_t next = i + ahead; next < i + ahead + 4; ++next)
      fetch(samples + first[std::min(next, count - 1)]);
    const __m128i one = values_at(i);
    const __m128i two = values_at(i + 1);
    const __m128i three = values_at(i + 2);
    const __m128i four = values_at(i + 3);
    const __m128i left_first = _mm_unpacklo_epi16(one, two);
    const __m128i left_last = _mm_unpacklo_epi16(three, four);
    const __m128i right_first = _mm_unpackhi_epi16(one, two);
    const __m128i right_last = _mm_unpackhi_epi16(three, four);
    const __m128 across = _mm_loadu_ps(part_u + i);
    const __m128 down = _mm_loadu_ps(part_v + i);
    const __m128 light = between_four(_mm_unpacklo_epi32(left_first, left_last),
                                      _mm_unpacklo_epi32(right_first, right_last), across, down);
    const __m128 share = between_four(_mm_unpackhi_epi32(left_first, left_last),
                                      _mm_unpackhi_epi32(right_first, right_last), across, down);
    _mm_storeu_ps(luminance + i, _mm_mul_ps(light, luminance_step));
    _mm_storeu_ps(cover + i, _mm_mul_ps(share, cover_step));
  }
#endif
  for (; i < count; ++i) {
    const std::uint16_t* const at = samples + first[i];
    luminance[i] = interpolated(at, at + 4, part_u[i], part_v[i]) * Keyframe::luminance_step;
    cover[i] = interpolated(at + 2, at + 6, part_u[i], part_v[i]) * Keyframe::cover_step;
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
  if (k.has_cover)
    interpolate_covered(k.samples, result.at, result.u, result.v, result.luminance, result.cover, count);
  else
    interpolate(k.samples, result.at, result.u, result.v, result.luminance, count);
}

}  // namespace saccade::detail
