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

}  // namespace saccade::network_kernels
