#include "core/tracker/disc_probability.h"

#include <algorithm>
#include <cmath>

namespace saccade {
namespace {

static_assert(DiscProbabilityWeights::inputs == disc_input_count,
              "the network of models/best was fitted to other inputs");
constexpr float most_deviations = 4.0F;  // of an input, as the network was fitted

}  // namespace

DiscInputs disc_inputs(const DiscEvidence& evidence, const DiscHistory& h) {
  DiscInputs inputs{};
  std::size_t i = 0;
  const auto add = [&](double value) { inputs[i++] = static_cast<float>(value); };
  for (const double value : evidence.values()) add(value);
  for (const Evidence e :
       {Evidence::closure, Evidence::expected_closure, Evidence::radial_share, Evidence::ring_to_sides,
        Evidence::inside_to_outside, Evidence::closure_by_contrast, Evidence::spread_px2})
    add(h.newest[e]);
  add(std::log1p(h.followed_px));
  add(std::log1p(h.silent_px));
  add(h.silhouette);
  add(h.moved_share);
  add(h.moved_most_share);
  add(std::min(2.0, h.moved_radii));
  add(h.on_ring_share);
  add(std::log(h.radius_variance_px2 + 1e-3));
  add(std::log1p(h.patch_mean.off_px));
  add(std::log1p(h.patch_mean.off_radius_px));
  add(h.patch.log_odds);
  add(h.patch_mean.log_odds);
  add(h.network_log_odds);
  add(h.network_mean);
  return inputs;
}

double disc_probability(const DiscProbabilityWeights& w, const DiscInputs& inputs) {
  std::array<float, DiscProbabilityWeights::hidden_units> hidden = w.hidden_bias;
  float sum = w.output_bias[0];
  for (std::size_t i = 0; i < disc_input_count; ++i) {
    const float z =
        std::clamp((inputs[i] - w.input_mean[i]) * w.input_scale[i], -most_deviations, most_deviations);
    sum += w.direct_weight[i] * z;
    for (std::size_t k = 0; k < hidden.size(); ++k) hidden[k] += w.hidden_weight[i][k] * z;
  }
  for (std::size_t k = 0; k < hidden.size(); ++k)
    sum += w.output_weight[k] * hidden[k] / (1.0F + std::abs(hidden[k]));
  return 1.0 / (1.0 + std::exp(-std::clamp(static_cast<double>(sum), -30.0, 30.0)));
}

}  // namespace saccade
