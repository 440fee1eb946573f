#include "control/delay_compensation.h"

#include <algorithm>
#include <cmath>

#include "control/joint_limiter.h"
#include "core/units.h"

namespace saccade {
namespace {

constexpr double candidate_spacing_s = 0.004;
constexpr double change_span_s = 0.02;
constexpr double sums_fade_s = 3.0;
constexpr double fastest_change = 0.05;                  // s of delay per s
constexpr double least_change_rad = 0.04 * rad_per_deg;  // in change_span_s: 2 deg/s
constexpr double least_moved_rad2 = 2e-3;                // 0.5 s at 20 deg/s
constexpr long ticks_per_update = 4;

}  // namespace

void describe(FieldVisitor& v, DelayConfig& config) {
  v.choice("sight", config.sight,
           "compensated delay from the light to the arrival of its events: none, sight_ms, or measured from "
           "the time "
           "stamps of events");
  v.when(config.sight == SightDelay::known, "sight: known", [&] {
    v.real("sight_ms", config.sight_ms, {0.0, 200.0}, "delay from the light to the arrival of its events");
  });
  v.when(config.sight != SightDelay::none, "sight: known or measured", [&] {
    v.real("detector_ms", config.detector_ms, {0.0, 200.0},
           "lag of the driving detector's circle behind its newest events in the image (`lag_ms` of "
           "metrics.json)");
  });
  v.choice("motion", config.motion,
           "compensated delay from a reference to the motion of the joint: none, the two keys below, or "
           "estimated from "
           "references and encoders");
  v.when(config.motion == MotionDelay::known, "motion: known", [&] {
    v.real("neck_ms", config.neck_ms, {0.0, 300.0},
           "delay from a reference to the motion of a neck joint, the servo's lag included");
    v.real("eyes_ms", config.eyes_ms, {0.0, 300.0},
           "delay from a reference to the motion of an eye joint, the servo's lag included");
  });
}

MotionDelayEstimator::MotionDelayEstimator() {
  groups_[0].joints = {head_index(neck_pitch), head_index(neck_yaw)};
  groups_[1].joints = {head_index(eyes_tilt), head_index(eyes_version)};
}

void MotionDelayEstimator::update(const HeadJointVector& measured_rad, const HeadJointVector& reference_rad,
                                  double dt_s) {
  if (!is_reading(measured_rad)) return;
  measured_.push(measured_rad);
  if (++ticks_ % ticks_per_update == 0) {
    for (Group& group : groups_) update(group, dt_s);
  }
  // After the update: the newest reference in the history is that of the last tick, which moves the joints now.
  references_.push(reference_rad);
}

void MotionDelayEstimator::update(Group& group, double dt_s) const {
  const double change = change_span_s / dt_s;
  const double step_s = dt_s * ticks_per_update;
  const double kept = std::exp(-step_s / sums_fade_s);
  const HeadJointVector& newest = measured_.at(0.0);
  const HeadJointVector& before = measured_.at(change);
  double moved = 0.0;
  std::array<double, 2> measured{};
  for (std::size_t i = 0; i < measured.size(); ++i) {
    measured[i] = newest[group.joints[i]] - before[group.joints[i]];
    moved += measured[i] * measured[i];
  }
  if (moved < least_change_rad * least_change_rad) return;
  group.moved = kept * group.moved + moved;
  for (int k = 0; k < candidates; ++k) {
    const double back = k * candidate_spacing_s / dt_s;
    double& sum = group.sums[static_cast<std::size_t>(k)];
    sum *= kept;
    const HeadJointVector& later = references_.at(back);
    const HeadJointVector& earlier = references_.at(back + change);
    for (std::size_t i = 0; i < measured.size(); ++i) {
      const double off = measured[i] - (later[group.joints[i]] - earlier[group.joints[i]]);
      sum += off * off;
    }
  }
  if (group.moved < least_moved_rad2) return;
  const auto least = std::ranges::min_element(group.sums);
  const auto k = static_cast<int>(least - group.sums.begin());
  double found_s = k * candidate_spacing_s;
  if (k > 0 && k + 1 < candidates) {
    const double below = *(least - 1), above = *(least + 1);
    const double bend = below - 2.0 * *least + above;
    if (bend > 0.0) found_s += 0.5 * candidate_spacing_s * (below - above) / bend;
  }
  const double most_s = fastest_change * step_s;
  group.delay_s += std::clamp(found_s - group.delay_s, -most_s, most_s);
}

}  // namespace saccade
