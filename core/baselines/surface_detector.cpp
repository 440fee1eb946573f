#include "core/baselines/surface_detector.h"

#include "core/time_stamp.h"

namespace saccade {
namespace {

constexpr std::int64_t step_us = 1'000;  // as the ticks of the loop
constexpr std::int64_t latest_us = std::numeric_limits<std::int64_t>::max();

/// The first whole millisecond after t_us.
std::int64_t next_millisecond_us(std::int64_t t_us) {
  return saturated_sum(t_us, step_us - (t_us % step_us + step_us) % step_us);
}

}  // namespace

void SurfaceDetectorBase::process(std::span<const Event> events, const CameraMotion*) {
  for (const Event& event : events) {
    if (!sieve_.accept(event)) continue;
    run_until(event.t_us, false);
    if (!next_step_us_) {
      const bool whole = event.t_us % step_us == 0;
      next_step_us_ = whole ? event.t_us : next_millisecond_us(event.t_us);
    }
    newest_us_ = event.t_us;
    steps_without_events_ = 0;
    add(event);
  }
}

/// Makes the steps up to t_us. Those after a long time without events are left out.
void SurfaceDetectorBase::run_until(std::int64_t t_us, bool inclusive) {
  if (!next_step_us_) return;
  while (*next_step_us_ != latest_us && (*next_step_us_ < t_us || (inclusive && *next_step_us_ == t_us))) {
    if (steps_without_events_ >= search_.steps_to_settle()) {
      next_step_us_ = inclusive || t_us % step_us != 0 ? next_millisecond_us(t_us) : t_us;
      return;
    }
    search_.step(surface());
    if (newest_us_ <= saturated_difference(*next_step_us_, step_us)) ++steps_without_events_;
    next_step_us_ = saturated_sum(*next_step_us_, step_us);
  }
}

Estimate SurfaceDetectorBase::estimate() {
  Estimate disc = search_.disc();
  disc.held = disc.valid && steps_without_events_ > 0;
  return disc;
}

}  // namespace saccade
