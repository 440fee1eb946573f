#pragma once

#include <array>

#include "control/reference_history.h"
#include "core/config.h"

namespace saccade {

/// Source of a delay's value.
enum class SightDelay {
  none,      ///< not compensated
  known,     ///< DelayConfig::sight_ms
  measured,  ///< from the time stamps of the newest events
};
constexpr auto words_of(SightDelay) {
  return std::to_array<Word<SightDelay>>(
      {{SightDelay::none, "none"}, {SightDelay::known, "known"}, {SightDelay::measured, "measured"}});
}
enum class MotionDelay {
  none,       ///< not compensated
  known,      ///< DelayConfig::neck_ms, eyes_ms
  estimated,  ///< by MotionDelayEstimator
};
constexpr auto words_of(MotionDelay) {
  return std::to_array<Word<MotionDelay>>(
      {{MotionDelay::none, "none"}, {MotionDelay::known, "known"}, {MotionDelay::estimated, "estimated"}});
}

/// Which delays between light and motion are compensated.
struct DelayConfig {
  SightDelay sight = SightDelay::none;
  double sight_ms = 0.0;  ///< from the light to the arrival of its events
  double detector_ms =
      0.0;  ///< how old the place is that the driving detector reports, behind its newest events
  MotionDelay motion = MotionDelay::none;
  double neck_ms = 21.0;  ///< from a reference to the motion of a neck joint, the servo's lag included
  double eyes_ms = 8.0;   ///< from a reference to the motion of an eye joint, the servo's lag included
};

/// Keys: sight, sight_ms, detector_ms, motion, neck_ms, eyes_ms.
void describe(FieldVisitor& v, DelayConfig& config);

/// Delays between light and motion, which a controller may compensate.
struct GazeDelays {
  double sight_s = 0.0;  ///< age of the targets
  double neck_s = 0.0;   ///< from a reference to the motion of a neck joint
  double eyes_s = 0.0;   ///< from a reference to the motion of tilt, version, vergence
};

/// Estimates the delays from references to the motion of neck and eyes, servo lags included.
///
/// For each candidate from 0 to 160 ms the squared differences between the change of the encoders in 20 ms and that of the
/// references so much earlier are summed over neck pitch and yaw, and over tilt and version. Sums fade in 3 s; only ticks
/// with moving references count. The delay is the candidate with the least sum, refined by a parabola. The reported
/// delay starts at 0 and moves to it by at most 50 ms per second.
class MotionDelayEstimator {
 public:
  MotionDelayEstimator();
  /// Call once per tick: the measured joints, finite, and the reference that is sent in this tick.
  void update(const HeadJointVector& measured_rad, const HeadJointVector& reference_rad, double dt_s);

  [[nodiscard]] double neck_s() const { return groups_[0].delay_s; }
  [[nodiscard]] double eyes_s() const { return groups_[1].delay_s; }

 private:
  static constexpr int candidates = 41;

  struct Group {
    std::array<int, 2> joints;
    std::array<double, candidates> sums{};
    double moved = 0.0;  ///< sum of the squared changes of references, rad^2
    double delay_s = 0.0;
  };
  void update(Group& group, double dt_s) const;

  ReferenceHistory references_;
  ReferenceHistory measured_;
  std::array<Group, 2> groups_;  // neck, eyes
  long ticks_ = 0;
};

}  // namespace saccade
