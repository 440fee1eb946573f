#pragma once

#include <array>
#include <cstddef>

#include "core/tracker/best_model.h"
#include "core/tracker/disc_probability.h"
#include "core/tracker/patch_network.h"

namespace saccade {

/// What a followed circle shows when a patch at it has been evaluated.
struct TrackStep {
  DiscInputs inputs{};       ///< of disc_probability()
  double probability = 0.0;  ///< by disc_probability()
  double rival =
      0.0;  ///< largest such probability of the other followed circles, with the decay without events
  std::size_t followed = 1;  ///< circles
  /// Since the last step, its birth, its last edge; more than 1 s counts as 1 s.
  double since_step_s = 0.0, age_s = 0.0, silent_s = 0.0;
  double border_radii = 0.0;  ///< from its centre to the nearest border of the image
};

/// Inputs of run_track_network(): those of disc_probability(), the patch's figures and output, the rest of the step, and the
/// patch network's features.
inline constexpr std::size_t track_input_count = TrackNetworkWeights::inputs;
using TrackInputs = std::array<float, track_input_count>;
[[nodiscard]] TrackInputs track_inputs(const TrackStep& step, const PatchOutput& patch);

/// What the network keeps of a track from step to step.
using TrackMemory = std::array<float, TrackNetworkWeights::memory>;

struct TrackExistence {
  double probability =
      0.0;  ///< that the circle is the ball's, calibrated: within 6 px of its centre and 2 px of its radius
  double leaves_per_s =
      1.0;  ///< rate at which that ceases to be so without events on the outline, 0.1 to 30 /s
};

/// A network with memory over the steps of a track, blended with the probability at an instant (models/best/manifest.json): one
/// hidden layer and a gated recurrent unit, both with softsign units, and a direct linear part. Fitted with the tracks of
/// BallTracker (docs/training.md). 22,000 multiplications.
[[nodiscard]] TrackExistence run_track_network(const TrackNetworkWeights& weights, const TrackInputs& inputs,
                                               TrackMemory& memory);

}  // namespace saccade
