#pragma once

#include "core/camera.h"
#include "core/tracker/best_model.h"
#include "core/tracker/polar_patch.h"

namespace saccade {

/// Of a patch, for run_track_network(): mean and largest value of each channel over the directions, and the hidden units.
inline constexpr std::size_t patch_feature_count =
    2 * PatchNetworkWeights::last_channels + PatchNetworkWeights::hidden_units;

/// PatchNetwork's estimates from a polar patch.
struct PatchOutput {
  double log_odds = 0.0;  ///< that the circle is the ball's: within 6 px of its centre and 2 px of its radius
  Circle correction{};    ///< to add to the circle (x, y, r) where it is near the ball's
  double centre_sd_px = 0.0,
         radius_sd_px = 0.0;  ///< standard deviations of the corrected circle, each coordinate
  double ring_px = 1.0;       ///< of the patch
  std::array<float, PolarPatch::figures> about{};     ///< of the patch
  std::array<float, patch_feature_count> features{};  ///< not negative
};

/// A small convolutional network over a polar patch: three layers over neighbouring directions and rings, one across the
/// rings, one around the directions. The mean and the largest value over all directions give the log odds; each direction
/// gives how far the outline is off there, of which the mean and the first harmonic are the correction. 0.7 million
/// multiplications.
[[nodiscard]] PatchOutput run_patch_network(const PatchNetworkWeights& weights, const PolarPatch& patch);

}  // namespace saccade
