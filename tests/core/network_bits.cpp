#include "tests/core/network_bits.h"

#include <bit>
#include <cmath>

#include "core/tracker/disc_network.h"
#include "core/tracker/disc_probability.h"
#include "core/tracker/patch_network.h"
#include "core/tracker/polar_patch.h"
#include "core/tracker/track_network.h"

namespace saccade {
namespace {

constexpr ImageSize bits_image{101, 75};  // no whole number of vectors in a row
constexpr std::int64_t bits_end_us = 200'000;

/// A disc that moves to the right, and noise.
TimeSurface surface_with_disc() {
  TimeSurface surface(bits_image);
  std::uint32_t state = 1;
  const auto below = [&](int n) {
    state = state * 1664525U + 1013904223U;
    return static_cast<std::uint16_t>((state >> 8U) % static_cast<std::uint32_t>(n));
  };
  for (std::int64_t t_us = 0; t_us < bits_end_us; t_us += 50) {
    const double centre_px = 30.0 + 1e-4 * static_cast<double>(t_us);
    const double angle = 0.001 * below(6284);
    const double x = centre_px + 11.0 * std::cos(angle);
    const double y = 37.0 + 11.0 * std::sin(angle);
    surface.add({t_us, static_cast<std::uint16_t>(std::lround(x)), static_cast<std::uint16_t>(std::lround(y)),
                 x < centre_px, 0});
    if (t_us % 200 == 0)
      surface.add({t_us, below(bits_image.width), below(bits_image.height), t_us % 400 == 0, 0});
  }
  return surface;
}

}  // namespace

std::vector<std::uint64_t> network_bits() {
  std::vector<std::uint64_t> bits;
  const auto add = [&](double value) { bits.push_back(std::bit_cast<std::uint64_t>(value)); };
  const auto add_circle = [&](const Circle& c) {
    for (const double value : {c.x_px, c.y_px, c.r_px}) add(value);
  };
  const auto model = best_model_of({});
  const TimeSurface surface = surface_with_disc();

  DiscNetwork network(model, bits_image, 4, 30);
  network.begin(bits_end_us);
  network.work(surface, 1'000'000'000);
  for (const DiscNetwork::Found& found : network.found()) {
    add_circle(found.circle);
    add(static_cast<double>(found.log_odds));
  }
  TrackMemory memory{};
  for (const double r_px : {4.0, 11.0, 29.0}) {
    for (const double x_px : {3.3, 49.0, 52.7}) {
      const Circle circle{x_px, 37.0, r_px};
      const PolarPatch patch = polar_patch(surface, circle, {{100.0, 0.0}, {-7.0, 3.0}, 5.0}, bits_end_us);
      for (const float value : patch.values) add(static_cast<double>(value));
      const PatchOutput output = run_patch_network(model->patch, patch);
      add(output.log_odds);
      add_circle(output.correction);
      add(output.centre_sd_px);
      add(output.radius_sd_px);
      TrackStep step;
      step.probability = 0.1 * r_px / x_px;
      add(run_track_network(model->track, track_inputs(step, output), memory).probability);
    }
  }
  DiscInputs inputs;
  for (std::size_t i = 0; i < inputs.size(); ++i)
    inputs[i] = 0.5F * static_cast<float>(i % 7) - 0.1F * static_cast<float>(i);
  add(disc_probability(model->probability, inputs));
  return bits;
}

}  // namespace saccade
