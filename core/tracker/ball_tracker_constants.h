#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>

/// Constants of BallTracker (docs/constants.md).
namespace saccade::ball_tracker {

inline constexpr std::int64_t never_us = std::numeric_limits<std::int64_t>::min();
inline constexpr std::int64_t tick_us = 1'000;
inline constexpr double tick_s = 1e-3;
inline constexpr std::size_t prefetched_events = 24;  // ahead: pixels of large images are not in the cache
inline constexpr int ticks_per_update = 2, ticks_per_silhouette = 4;

// Radii: beyond the largest one of the worlds that it was fitted in, every n-th pixel is used.
inline constexpr double largest_fitted_px = 80.0, smallest_of_two_px = 60.0;
inline constexpr double largest_decimated_px = 40.0, smallest_decimated_px = 5.0;  // in these pixels

// Edges.
inline constexpr double fastest_us_px = 10.0;      // steeper flows are noise
inline constexpr double shortest_life_us = 100.0;  // of an edge
inline constexpr double camera_moves_px_s =
    30.0;  // from here on its flow has a smaller variance than one measured at a pixel
inline constexpr double near_px = 6.0;  // of a circle: what comes further outside does not concern it

// Evidence.
inline constexpr double fewest_fresh = 5.0,
                        fresh_px = 0.15;  // edges, and edges per px of outline, for an update of the evidence
inline constexpr double fresh_left = 0.99;  // of them after a ms: noise does not add up to an update
inline constexpr double stays_s = 1.0;    // a circle without events competes as if it ceased after that time
inline constexpr double memory_px = 2.0;  // of motion, that evidence is averaged over
inline constexpr double clutter_hides_px2 = 0.2;  // radial edges per px^2 around a circle that hide it
inline constexpr double least_weight = 0.05, least_clarity = 0.15;

// Silhouettes.
inline constexpr double silhouette_slow_px_s =
    40.0;  // faster through the image a ball makes events of its own
inline constexpr double silhouette_fastest_px_s = 120.0;
inline constexpr double silhouette_least_sd_px =
    0.35;  // of one fit; successive fits share most of their events
inline constexpr double gaze_follows_silhouette = 0.4;

// Motion against the background; the camera's rotation from edges, where joints are missing.
inline constexpr std::size_t max_flows = 1024;
inline constexpr std::int64_t rotation_period_us = 3'000;
inline constexpr double anchor_s = 0.6, moved_begin_px = 2.0, moved_end_px = 6.0;
inline constexpr double at_rest_share = 0.6;  // prior of a circle that never moved against it, as a share

// Search.
inline constexpr std::size_t candidates_per_tick = 8;
inline constexpr double farthest_px = 1e9;  // of a found circle, which has moved on since; integers hold it
inline constexpr double confident = 0.9;    // probability of the best circle with which the search is slower
inline constexpr double new_share = 0.6;    // of its probability that a new circle replaces another with
inline constexpr double better_by = 0.1;    // probability, for a found circle to correct a followed one
inline constexpr double fit_sd_px = 0.7;    // of a found circle
inline constexpr double rival_share = 0.4;  // of the radius: circles nearer than that claim the same disc
inline constexpr std::size_t max_rivals = 2;  // followed at once

// Inferences of DiscNetwork.
inline constexpr std::int64_t network_period_us = 3'000, confident_network_period_us = 25'000;
inline constexpr std::int64_t multiplications_per_tick = 6'000'000;
inline constexpr std::uint64_t fewest_events_of_inference = 20;

// Polar patches.
inline constexpr std::uint64_t confident_ticks_per_patch = 4;
inline constexpr double least_correction_rings = 0.3,
                        large_correction_rings = 0.8;  // ring widths of a polar patch
inline constexpr double correction_gain = 0.5;         // of the log odds
// Gate: log odds from which on a followed circle's correction is a measurement; and least standard deviation of that.
inline constexpr double least_measured_log_odds = -2.0, least_patch_sd_px = 0.3;
// Least standard deviation of a circle when another one fits its outline better.
inline constexpr double inflated_sd_px = 0.5;

// Uncertainty of the estimate beside that of the track, fitted to the errors of inliers on training seeds.
inline constexpr double covariance_scale = 4.0;
inline constexpr double model_sd_px[3] = {1.2, 1.2, 0.7};

}  // namespace saccade::ball_tracker
