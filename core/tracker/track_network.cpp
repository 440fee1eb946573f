#include "core/tracker/track_network.h"

#include <algorithm>
#include <cmath>

#include "core/portable_math.h"

namespace saccade {
namespace {

using Weights = TrackNetworkWeights;
constexpr float most_deviations = 4.0F;  // of an input, as the network was fitted
constexpr double longest_s = 1.0;        // that counts: it was fitted to worlds of 2 s
constexpr double least_probability = 1e-4, most_log_odds = 8.0;
constexpr double least_log_rate = -2.302585092994046, most_log_rate = 3.401197381662155;  // of 0.1 and 30 /s

static_assert(Weights::inputs == disc_input_count + PolarPatch::figures + 12 + patch_feature_count,
              "the network of models/best was fitted to other inputs");

double log_odds_of(double probability) {
  const double p = std::clamp(probability, least_probability, 1.0 - least_probability);
  return portable_log(p / (1.0 - p));
}
double log1p_of(double value) { return portable_log(1.0 + value); }

float softsign(float x) { return x / (1.0F + std::abs(x)); }

/// to[k] += value * weights[k]
template <std::size_t n>
void add(float value, const std::array<float, n>& weights, std::array<float, n>& to) {
  for (std::size_t k = 0; k < n; ++k) to[k] += value * weights[k];
}

}  // namespace

TrackInputs track_inputs(const TrackStep& s, const PatchOutput& patch) {
  TrackInputs inputs{};
  std::size_t i = 0;
  const auto add_input = [&](double value) { inputs[i++] = static_cast<float>(value); };
  for (const float value : s.inputs) inputs[i++] = value;
  for (const float value : patch.about) inputs[i++] = value;
  add_input(std::clamp(patch.log_odds, -most_log_odds, most_log_odds));
  add_input(std::hypot(patch.correction.x_px, patch.correction.y_px) / patch.ring_px);
  add_input(patch.correction.r_px / patch.ring_px);
  add_input(patch.centre_sd_px / patch.ring_px);
  add_input(patch.radius_sd_px / patch.ring_px);
  add_input(log_odds_of(s.probability));
  add_input(log_odds_of(s.rival));
  add_input(log1p_of(static_cast<double>(s.followed)));
  add_input(log1p_of(std::min(s.since_step_s, longest_s) * 1e3));
  add_input(log1p_of(std::min(s.age_s, longest_s) * 1e3));
  add_input(log1p_of(std::min(s.silent_s, longest_s) * 1e2));
  add_input(s.border_radii);
  for (const float value : patch.features) add_input(log1p_of(static_cast<double>(value)));
  return inputs;
}

TrackExistence run_track_network(const Weights& w, const TrackInputs& inputs, TrackMemory& memory) {
  constexpr std::size_t m = Weights::memory;
  std::array<float, Weights::features_of_step> features = w.features_bias;
  std::array<float, 2> out = w.output_bias;
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const float z =
        std::clamp((inputs[i] - w.input_mean[i]) * w.input_scale[i], -most_deviations, most_deviations);
    add(z, w.features[i], features);
    add(z, w.output_direct[i], out);
  }
  std::array<float, 3 * m> gates = w.gates_bias;
  for (std::size_t k = 0; k < features.size(); ++k) {
    const float feature = softsign(features[k]);
    add(feature, w.gates[k], gates);
    add(feature, w.output_features[k], out);
  }
  std::array<float, 3 * m> from_memory{};
  for (std::size_t k = 0; k < m; ++k) add(memory[k], w.recurrent[k], from_memory);
  for (std::size_t k = 0; k < m; ++k) {
    const float reset = 0.5F + 0.5F * softsign(gates[k] + from_memory[k]);
    const float keep = 0.5F + 0.5F * softsign(gates[m + k] + from_memory[m + k]);
    const float newest = softsign(gates[2 * m + k] + reset * from_memory[2 * m + k]);
    memory[k] = newest + keep * (memory[k] - newest);
    add(memory[k], w.output_memory[k], out);
  }
  return {1.0 / (1.0 + portable_exp(-static_cast<double>(out[0]))),
          portable_exp(std::clamp(static_cast<double>(out[1]), least_log_rate, most_log_rate))};
}

}  // namespace saccade
