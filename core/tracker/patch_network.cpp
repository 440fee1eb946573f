#include "core/tracker/patch_network.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "core/tracker/network_kernels.h"
#include "core/vector_clones.h"

namespace saccade {
namespace {

using namespace network_kernels;
using Weights = PatchNetworkWeights;

constexpr std::size_t first_channels = Weights::first_channels, channels = Weights::channels,
                      last_channels = Weights::last_channels, hidden_units = Weights::hidden_units;
constexpr std::size_t all_directions = PolarPatch::directions, directions = all_directions / 2,
                      rings = PolarPatch::rings / 2;
constexpr std::size_t outputs = Weights::outputs;
constexpr float least_log_sd = -3.5F, most_log_sd = 1.5F;  // in ring widths, as the network was fitted
constexpr float largest_density = 2.55F;                   // per px^2, as the network was fitted
static_assert(Weights::figures == PolarPatch::figures && Weights::inputs == PolarPatch::channels &&
                  Weights::rings == rings,
              "the network of models/best was fitted to other patches");

template <std::size_t Directions, std::size_t Channels>
struct Layer {
  std::array<float, Directions * rings * Channels> values;
  [[nodiscard]] const float* at(std::size_t direction, std::size_t ring) const {
    return values.data() + (direction * rings + ring) * Channels;
  }
  [[nodiscard]] float* at(std::size_t direction, std::size_t ring) {
    return values.data() + (direction * rings + ring) * Channels;
  }
};

/// Calls f(tap, direction, ring) for the 3 x 3 neighbours of a place; beyond the rings there is none.
template <std::size_t Directions, class Function>
[[gnu::always_inline]] inline void for_neighbours(std::size_t direction, std::size_t ring,
                                                  std::size_t ring_count, Function f) {
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t d = (direction + i + Directions - 1) % Directions;
    for (std::size_t j = 0; j < 3; ++j) {
      if (ring + j < 1 || ring + j > ring_count) continue;
      f(i * 3 + j, d, ring + j - 1);
    }
  }
}

/// 3 x 3 of every second ring.
[[gnu::always_inline]] inline void first_layer(const Weights& w, const PolarPatch& patch,
                                               Layer<all_directions, first_channels>& out) {
  for (std::size_t d = 0; d < all_directions; ++d) {
    for (std::size_t r = 0; r < rings; ++r) {
      Channels<first_channels> sum;
      load(w.first_bias.data(), sum);
      for_neighbours<all_directions>(
          d, 2 * r, PolarPatch::rings, [&](std::size_t tap, std::size_t nd, std::size_t nr) {
            const float* in = patch.values.data() + (nd * PolarPatch::rings + nr) * PolarPatch::channels;
            const float* weight = w.first.data() + tap * PolarPatch::channels * first_channels;
            for (std::size_t c = 0; c < PolarPatch::channels; ++c, weight += first_channels)
              add_product(std::min(in[c], largest_density), weight, sum);
          });
      store_positive(sum, out.at(d, r));
    }
  }
}

/// 3 x 3 of each channel, then of all channels at each place; every Step-th direction.
template <std::size_t Step, std::size_t Directions, std::size_t In, std::size_t Out>
[[gnu::always_inline]] inline void separable_layer(const Layer<Directions, In>& in, const float* depth,
                                                   const float* point, const float* bias,
                                                   Layer<Directions / Step, Out>& out, bool residual) {
  for (std::size_t d = 0; d < Directions / Step; ++d) {
    for (std::size_t r = 0; r < rings; ++r) {
      Channels<In> deep{};
      for_neighbours<Directions>(d * Step, r, rings, [&](std::size_t tap, std::size_t nd, std::size_t nr) {
        Channels<In> value;
        load(in.at(nd, nr), value);
        add_product(value, depth + tap * In, deep);
      });
      float flat[1][In];
      for (std::size_t i = 0; i < In / lanes; ++i) reinterpret_cast<Lanes*>(flat[0])[i] = deep.part[i];
      Channels<Out> sum[1];
      load(bias, sum[0]);
      pointwise(flat, point, sum);
      if constexpr (Step == 1 && In == Out) {
        if (residual) {
          Channels<Out> own;
          load(in.at(d, r), own);
          for (std::size_t i = 0; i < Out / lanes; ++i) sum[0].part[i] += own.part[i];
        }
      }
      store_positive(sum[0], out.at(d, r));
    }
  }
}

using Around = std::array<std::array<float, last_channels>, directions>;

[[gnu::always_inline]] inline void across_rings(const Weights& w, const Layer<directions, channels>& in,
                                                Around& out) {
  for (std::size_t d = 0; d < directions; ++d) {
    Channels<last_channels> sum;
    load(w.across_bias.data(), sum);
    const float* values = in.at(d, 0);
    for (std::size_t i = 0; i < rings * channels; ++i)
      add_product(values[i], w.across.data() + i * last_channels, sum);
    store_positive(sum, out[d].data());
  }
}

[[gnu::always_inline]] inline void around_directions(const Weights& w, const Around& in, Around& out) {
  for (std::size_t d = 0; d < directions; ++d) {
    Channels<last_channels> deep{};
    for (std::size_t i = 0; i < 3; ++i) {
      Channels<last_channels> value;
      load(in[(d + i + directions - 1) % directions].data(), value);
      add_product(value, w.around_depth.data() + i * last_channels, deep);
    }
    float flat[1][last_channels];
    for (std::size_t i = 0; i < last_channels / lanes; ++i)
      reinterpret_cast<Lanes*>(flat[0])[i] = deep.part[i];
    Channels<last_channels> sum[1], own;
    load(w.around_bias.data(), sum[0]);
    pointwise(flat, w.around_point.data(), sum);
    load(in[d].data(), own);
    for (std::size_t i = 0; i < last_channels / lanes; ++i) sum[0].part[i] += own.part[i];
    store_positive(sum[0], out[d].data());
  }
}

SACCADE_VECTOR_CLONES
void convolve(const Weights& w, const PolarPatch& patch, Around& out) {
  Layer<all_directions, first_channels> a;
  Layer<all_directions, channels> b;
  Layer<directions, channels> c, d;
  first_layer(w, patch, a);
  separable_layer<1>(a, w.depth_1.data(), w.point_1.data(), w.point_bias_1.data(), b, false);
  separable_layer<2>(b, w.depth_2.data(), w.point_2.data(), w.point_bias_2.data(), c, false);
  separable_layer<1>(c, w.depth_3.data(), w.point_3.data(), w.point_bias_3.data(), d, true);
  Around before;
  across_rings(w, d, before);
  around_directions(w, before, out);
}

}  // namespace

PatchOutput run_patch_network(const PatchNetworkWeights& w, const PolarPatch& patch) {
  Around around;
  convolve(w, patch, around);

  PatchOutput result;
  std::array<float, 2 * last_channels> pooled{};
  for (std::size_t d = 0; d < directions; ++d) {
    float off = w.offset_bias[0];
    for (std::size_t c = 0; c < last_channels; ++c) {
      const float value = around[d][c];
      off += value * w.offset[c];
      pooled[c] += value / directions;
      pooled[last_channels + c] = std::max(pooled[last_channels + c], value);
    }
    const double angle = 2.0 * std::numbers::pi * static_cast<double>(d) / directions;
    const double off_px = static_cast<double>(off) * patch.ring_px / directions;
    result.correction.x_px += 2.0 * std::cos(angle) * off_px;
    result.correction.y_px += 2.0 * std::sin(angle) * off_px;
    result.correction.r_px += off_px;
  }
  std::array<float, hidden_units> hidden = w.hidden_bias;
  const auto add = [&](std::size_t input, float value) {
    for (std::size_t k = 0; k < hidden_units; ++k) hidden[k] += value * w.hidden[input * hidden_units + k];
  };
  for (std::size_t i = 0; i < pooled.size(); ++i) add(i, pooled[i]);
  for (std::size_t i = 0; i < PolarPatch::figures; ++i)
    add(pooled.size() + i, (patch.about[i] - w.about_mean[i]) * w.about_scale[i]);
  std::array<float, outputs> out = w.output_bias;
  for (std::size_t k = 0; k < hidden_units; ++k) {
    for (std::size_t i = 0; i < outputs; ++i) out[i] += std::max(hidden[k], 0.0F) * w.output[k * outputs + i];
  }
  const auto sd_px = [&](float log_sd) {
    return patch.ring_px * std::exp(static_cast<double>(std::clamp(log_sd, least_log_sd, most_log_sd)));
  };
  result.ring_px = patch.ring_px;
  result.about = patch.about;
  const auto next = std::copy(pooled.begin(), pooled.end(), result.features.begin());
  std::transform(hidden.begin(), hidden.end(), next, [](float value) { return std::max(value, 0.0F); });
  result.log_odds = static_cast<double>(out[0]);
  result.centre_sd_px = sd_px(out[1]);
  result.radius_sd_px = sd_px(out[2]);
  return result;
}

}  // namespace saccade
