#pragma once

#include <array>
#include <cstddef>

#include "core/tracker/best_model.h"
#include "core/tracker/disc_evidence.h"

namespace saccade {

/// Log odds of DiscNetwork below this count as this. Chosen on the fitting seeds.
inline constexpr double least_network_log_odds = -1.0;

/// Prior log odds of a circle before PatchNetwork has run on it, and the largest that count.
inline constexpr double prior_patch_log_odds = 2.0, most_patch_log_odds = 8.0;

/// PatchNetwork's output for a circle, as the probability uses it.
struct PatchResult {
  double log_odds = prior_patch_log_odds;
  double off_px = 0.0, off_radius_px = 0.0;  ///< size of what is still to be corrected of centre and radius

  /// Goes on towards a newer one by a share of the difference.
  void blend(const PatchResult& newer, double share) {
    log_odds += share * (newer.log_odds - log_odds);
    off_px += share * (newer.off_px - off_px);
    off_radius_px += share * (newer.off_radius_px - off_radius_px);
  }
};

/// The history of a track beside its evidence; the defaults are those at its birth.
struct DiscHistory {
  DiscEvidence
      newest;  ///< of the last update; the evidence itself is an average over the last pixels of motion
  double followed_px = 0.0;  ///< motion of the outline that it has been followed for
  double silent_px = 0.0;    ///< edges near it, per px of its outline, since the last one on it
  double silhouette = 0.0;   ///< 0 to 1: contrast of its silhouette in the background's events (Silhouette)
  double moved_share = 0.0;  ///< 0 to 1: 0 at rest against the background, 1 where it moves by itself
  double moved_most_share = 0.0;     ///< the largest so far
  double moved_radii = 0.0;          ///< how far it has moved against the background lately, radii
  double on_ring_share = 0.5;        ///< of the edges near it
  double radius_variance_px2 = 1.0;  ///< of the track
  PatchResult patch;                 ///< the newest
  PatchResult patch_mean;            ///< averaged like the evidence
  /// Log odds by DiscNetwork's newest inference, from least_network_log_odds up: a detection is evidence for a ball, none is
  /// no evidence against it, since the network was fitted on worlds of one kind.
  double network_log_odds = least_network_log_odds;
  double network_mean = least_network_log_odds;  ///< averaged like the evidence
};

/// Inputs of the model: the evidence, then the history.
inline constexpr std::size_t disc_input_count = evidence_count + 21;
using DiscInputs = std::array<float, disc_input_count>;

[[nodiscard]] DiscInputs disc_inputs(const DiscEvidence& evidence, const DiscHistory& history);

/// The probability by one instant that a circle is the ball's, within 6 px of its centre and 2 px of its radius. A network of one hidden
/// layer with softsign units and a direct linear part, which is the mean of the log odds of several fits by maximum likelihood
/// with weight decay.
[[nodiscard]] double disc_probability(const DiscProbabilityWeights& weights, const DiscInputs& inputs);

}  // namespace saccade
