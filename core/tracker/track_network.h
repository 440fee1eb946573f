#pragma once

#include <array>

#include "core/tracker/best_model.h"
#include "core/tracker/disc_probability.h"

namespace saccade {

/// What TrackNetwork remembers of a followed circle; zeros at its birth.
using TrackMemory = std::array<float, TrackNetworkWeights::memory>;

/// Log odds, calibrated, that the circle of a track is the ball's, within 6 px of its centre and 2 px of its radius, from what it
/// has shown so far. A layer of softsign units, a gated recurrent unit whose gates and candidates are softsigns too, and a linear
/// output from inputs, layer and memory. docs/training.md has the training, docs/results.md how well score and share of
/// inliers agree. `inputs`, `at_instant` (disc_log_odds()): of this step. `since_s`: since the step before, 0 at the first one.
/// Moves `memory` on.
[[nodiscard]] double track_log_odds(const TrackNetworkWeights& weights, const DiscInputs& inputs,
                                    float at_instant, double since_s, TrackMemory& memory);

}  // namespace saccade
