#include "control/hunting_detector.h"

#include <cmath>

#include "core/units.h"

namespace saccade {
namespace {

constexpr double high_pass_s = 0.1;
constexpr double least_swing_rad = 0.3 * rad_per_deg;
constexpr double longest_s = 1.5;        // of eight swings
constexpr double longest_again_s = 2.2;  // soon after a find
constexpr double again_s = 3.0;

}  // namespace

bool HuntingDetector::update(const HeadJointVector& reference_rad, double dt_s) {
  if (!started_) {
    for (Axis& axis : axes_) axis.mean_rad = reference_rad[axis.joint];
    started_ = true;
  }
  now_s_ += dt_s;
  const double share = 1.0 - std::exp(-dt_s / high_pass_s);
  const double most_s = now_s_ - found_s_ < again_s ? longest_again_s : longest_s;
  bool found = false;
  for (Axis& axis : axes_) {
    axis.mean_rad += share * (reference_rad[axis.joint] - axis.mean_rad);
    const double off_rad = reference_rad[axis.joint] - axis.mean_rad;
    if (std::abs(off_rad) < least_swing_rad || (off_rad > 0.0) == axis.above) continue;
    axis.above = off_rad > 0.0;
    double& oldest_s = axis.times_s[static_cast<std::size_t>(axis.swings % swings_of_hunting)];
    const double took_s = now_s_ - oldest_s;
    oldest_s = now_s_;
    if (++axis.swings <= swings_of_hunting || took_s > most_s) continue;
    frequency_hz_ = 0.5 * swings_of_hunting / took_s;
    axis.swings = 0;
    found = true;
  }
  if (found) found_s_ = now_s_;
  return found;
}

}  // namespace saccade
