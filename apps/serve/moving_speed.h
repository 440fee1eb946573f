#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "sim/sim_config.h"

namespace saccade {

/// How fast this machine simulates a robot with moving eyes.
struct MovingSpeed {
  double simulated_s = 0.0;
  double wall_s = 0.0;
  double keyframe_ms =
      0.0;  ///< median of the ticks in which a keyframe of the room was drawn; 0: there was none

  [[nodiscard]] double simulated_per_s() const { return wall_s > 0.0 ? simulated_s / wall_s : 0.0; }
};

/// One tick of a measured simulation; returns whether a keyframe of the room was drawn in it.
using MeasuredTick = std::function<bool()>;

/// Ticks until `budget_s` of `now_s` has passed, and after that until `least_keyframes` of the room were drawn or four times
/// that time has passed.
[[nodiscard]] MovingSpeed measure_speed(const MeasuredTick& tick, const std::function<double()>& now_s,
                                        double budget_s, int least_keyframes);

/// The samples of a keyframe, at least 2, with which it takes 6 ms: beside a client on the same two processors up to three
/// times that was measured, and after 20 ms simulated time slips (PacedRobot).
[[nodiscard]] std::int64_t bearable_samples(std::int64_t samples, double keyframe_ms);

/// The speed of a robot of its own while its eyes turn with up to 100 deg/s, in half a second of the wall clock.
/// `held_us`: SimRobot::hold_back_images.
[[nodiscard]] MovingSpeed moving_speed(const SimConfig& config, std::uint64_t seed, std::size_t threads,
                                       std::int64_t held_us);

/// What serve lowers on this machine, and what it says about it.
struct ServedWork {
  MovingSpeed usual;    ///< as configured
  MovingSpeed lowered;  ///< with fewer samples, if need be, and the longest interval between images
  std::int64_t keyframe_samples = 0;
  std::vector<std::string> lines;  ///< for the log; a warning begins with "warning: "
};

/// From two measurements. `lowered` may be empty (wall_s 0) if fits_usual().
[[nodiscard]] ServedWork served_work(const MovingSpeed& usual, const MovingSpeed& lowered,
                                     std::int64_t configured_samples);
/// Whether a machine can keep pace as configured, with room for the client on it.
[[nodiscard]] bool fits_usual(const MovingSpeed& usual);

}  // namespace saccade
