#pragma once

#include <array>

#include "head/head_state.h"

namespace saccade {

/// Finds oscillations of the head that are faster than targets move: a loop with too much delay or gain hunts.
///
/// The references of tilt and version are high-pass filtered (0.1 s). A swing is a change from above 0.3 deg to below
/// -0.3 deg or back. Eight swings of a joint in 1.5 s, which is 2.7 Hz or faster, are hunting. In the 3 s after a find 1.8
/// Hz suffice, because slower time constants make an oscillation that continues slower.
class HuntingDetector {
 public:
  /// Call once per tick. Returns true in the tick in which hunting is found; the next find needs eight more swings.
  bool update(const HeadJointVector& reference_rad, double dt_s);
  /// Mean frequency of the swings of the last find, Hz.
  [[nodiscard]] double frequency_hz() const { return frequency_hz_; }

 private:
  static constexpr int swings_of_hunting = 8;

  struct Axis {
    int joint = 0;
    double mean_rad = 0.0;
    bool above = false;
    int swings = 0;
    std::array<double, swings_of_hunting> times_s{};  ///< of the last swings, a ring
  };
  std::array<Axis, 2> axes_{Axis{head_index(eyes_tilt)}, Axis{head_index(eyes_version)}};
  double now_s_ = 0.0;
  double found_s_ = -1e9;
  bool started_ = false;
  double frequency_hz_ = 0.0;
};

}  // namespace saccade
