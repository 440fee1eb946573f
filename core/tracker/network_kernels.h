#pragma once

#include <cstddef>
#include <type_traits>

/// Sums of the small networks (DiscNetwork, PatchNetwork) over channels, eight at a time. They have one order, whatever the
/// width of the machine's vectors, so that results agree bit for bit. Use them inside of functions with
/// SACCADE_VECTOR_CLONES.
namespace saccade::network_kernels {

using Lanes [[gnu::vector_size(32), gnu::may_alias, gnu::aligned(4)]] = float;
constexpr std::size_t lanes = 8;

template <std::size_t C>
struct Channels {
  Lanes part[C / lanes];
};

template <std::size_t C>
[[gnu::always_inline]] inline void load(const float* from, Channels<C>& to) {
  for (std::size_t i = 0; i < C / lanes; ++i) to.part[i] = reinterpret_cast<const Lanes*>(from)[i];
}

/// sum[k] += factor[k] * weight[k]
template <std::size_t C, class Factor>
[[gnu::always_inline]] inline void add_product(const Factor& factor, const float* weight, Channels<C>& sum) {
  for (std::size_t i = 0; i < C / lanes; ++i) {
    if constexpr (std::is_same_v<Factor, float>)
      sum.part[i] += factor * reinterpret_cast<const Lanes*>(weight)[i];
    else
      sum.part[i] += factor.part[i] * reinterpret_cast<const Lanes*>(weight)[i];
  }
}

template <std::size_t C>
[[gnu::always_inline]] inline void store_positive(const Channels<C>& from, float* to) {
  for (std::size_t i = 0; i < C / lanes; ++i)
    reinterpret_cast<Lanes*>(to)[i] = from.part[i] > 0.0F ? from.part[i] : Lanes{};
}

/// sum[k] += sum over c of in[c] * weight[c][k], for each of the places.
template <std::size_t In, std::size_t Out, std::size_t places>
[[gnu::always_inline]] inline void pointwise(const float (&in)[places][In], const float* weight,
                                             Channels<Out> (&sum)[places]) {
  for (std::size_t c = 0; c < In; ++c) {
    for (std::size_t p = 0; p < places; ++p) add_product(in[p][c], weight + c * Out, sum[p]);
  }
}

/// A map of rows x columns x channels.
struct Map {
  const float* values;
  int rows, columns;
};

/// Depthwise 3 x 3 convolution of one place; what is outside counts as 0.
template <std::size_t C>
[[gnu::always_inline]] inline void depthwise(const Map& in, int y, int x, int step, const float* weight,
                                             float* out) {
  Channels<C> sum{};
  for (int ky = 0; ky < 3; ++ky) {
    const int from_y = y + (ky - 1) * step;
    if (from_y < 0 || from_y >= in.rows) continue;
    for (int kx = 0; kx < 3; ++kx) {
      const int from_x = x + (kx - 1) * step;
      if (from_x < 0 || from_x >= in.columns) continue;
      Channels<C> value;
      load(in.values + static_cast<std::size_t>(from_y * in.columns + from_x) * C, value);
      add_product(value, weight + static_cast<std::size_t>(ky * 3 + kx) * C, sum);
    }
  }
  for (std::size_t i = 0; i < C / lanes; ++i) reinterpret_cast<Lanes*>(out)[i] = sum.part[i];
}

/// A row of the 3 x 3 convolution of every second place of every second row, from inputs of which the first half are ON. The
/// channels of OFF add up beside those of ON.
template <class Weights>
[[gnu::always_inline]] inline void input_halved_row(const Map& in, int y, const Weights& weights,
                                                    float* out) {
  constexpr std::size_t to = Weights::first_channels, half = Weights::inputs / 2;
  for (int x = 0; 2 * x < in.columns; ++x, out += to) {
    Channels<to> on_sum, off_sum{};
    load(weights.first_bias.data(), on_sum);
    for (int ky = 0; ky < 3; ++ky) {
      const int from_y = 2 * y + ky - 1;
      if (from_y < 0 || from_y >= in.rows) continue;
      for (int kx = 0; kx < 3; ++kx) {
        const int from_x = 2 * x + kx - 1;
        if (from_x < 0 || from_x >= in.columns) continue;
        const float* on = in.values + static_cast<std::size_t>(from_y * in.columns + from_x) * (2 * half);
        const float* off = on + half;
        if (on[half - 1] == 0.0F && off[half - 1] == 0.0F) continue;  // no event for long
        const float* weight = weights.first.data() + static_cast<std::size_t>(ky * 3 + kx) * 2 * half * to;
        for (std::size_t c = 0; c < half; ++c, weight += to) {
          add_product(on[c], weight, on_sum);
          add_product(off[c], weight + half * to, off_sum);
        }
      }
    }
    for (std::size_t i = 0; i < to / lanes; ++i) on_sum.part[i] += off_sum.part[i];
    store_positive(on_sum, out);
  }
}

}  // namespace saccade::network_kernels
