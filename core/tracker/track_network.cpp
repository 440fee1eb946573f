#include "core/tracker/track_network.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/vector_clones.h"

namespace saccade {
namespace {

using Weights = TrackNetworkWeights;
static_assert(Weights::inputs == disc_input_count + 2,
              "the network of models/best was fitted to other inputs");

constexpr float most_deviations = 4.0F;  // of an input, as the network was fitted
constexpr double step_s = 0.002;         // between two updates of a track
constexpr float most_at_instant = 8.0F;  // log odds, as the network was fitted

template <std::size_t n>
[[gnu::always_inline]] inline void add_product(float factor, const std::array<float, n>& weight,
                                               std::array<float, n>& sum) {
  for (std::size_t k = 0; k < n; ++k) sum[k] += factor * weight[k];
}

[[gnu::always_inline]] inline float softsign(float x) { return x / (1.0F + std::abs(x)); }
[[gnu::always_inline]] inline float gate(float x) { return 0.5F + 0.5F * softsign(x); }

/// Log odds. Sums have one order, whatever the width of the machine's vectors, so that results agree bit for bit.
SACCADE_VECTOR_CLONES
float log_odds(const Weights& w, const std::array<float, Weights::inputs>& inputs, TrackMemory& memory) {
  constexpr std::size_t n = Weights::memory;
  std::array<float, Weights::features> features = w.feature_bias;
  float sum = w.output_bias[0];
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const float z =
        std::clamp((inputs[i] - w.input_mean[i]) * w.input_scale[i], -most_deviations, most_deviations);
    sum += w.direct[i] * z;
    add_product(z, w.feature[i], features);
  }
  std::array<float, 3 *n> gates = w.gate_bias, recurrent{};
  for (float& f : features) f = softsign(f);
  for (std::size_t k = 0; k < features.size(); ++k) add_product(features[k], w.gate[k], gates);
  for (std::size_t k = 0; k < n; ++k) add_product(memory[k], w.recurrent[k], recurrent);
  for (std::size_t k = 0; k < n; ++k) {
    const float reset = gate(gates[k] + recurrent[k]);
    const float keep = gate(gates[n + k] + recurrent[n + k]);
    const float candidate = softsign(gates[2 * n + k] + reset * recurrent[2 * n + k]);
    memory[k] = candidate + keep * (memory[k] - candidate);
  }
  for (std::size_t k = 0; k < features.size(); ++k) sum += w.output_feature[k] * features[k];
  for (std::size_t k = 0; k < n; ++k) sum += w.output_memory[k] * memory[k];
  return sum;
}

}  // namespace

double track_log_odds(const TrackNetworkWeights& w, const DiscInputs& inputs, float at_instant,
                      double since_s, TrackMemory& memory) {
  std::array<float, Weights::inputs> all;
  std::ranges::copy(inputs, all.begin());
  all[disc_input_count] = static_cast<float>(std::log1p(since_s / step_s));
  all[disc_input_count + 1] = std::clamp(at_instant, -most_at_instant, most_at_instant);
  return static_cast<double>(log_odds(w, all, memory));
}

}  // namespace saccade
