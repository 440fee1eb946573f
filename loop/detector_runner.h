#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "core/detector.h"
#include "core/time_stamp.h"
#include "loop/latency.h"

namespace saccade {

/// A detector's estimate about an instant before the tick, from events that came late.
struct LateEstimate {
  std::int64_t t_us = 0;  ///< a whole number of milliseconds before the tick, see Loop
  Estimate estimate;
  std::int64_t ready_us = 0;  ///< when it can be used
};

/// Result of one detector in one tick.
struct DetectorTick {
  Estimate estimate;
  bool observed = false;      ///< the estimate is valid, and events came or it is held or predicted
  bool at_threshold = false;  ///< observed, with a score at or above the detector's threshold
  bool on_time = false;       ///< observed, and it is held or predicted, or not all of the events came late
  bool skipped = false;       ///< the detector did not run, see LoopBudget
  bool busy = false;  ///< the detector did not run: with a latency, an earlier tick's work is not done
  std::int64_t elapsed_ns = 0;       ///< of its calls, Detector::work_ahead() before them included
  std::int64_t ready_us = 0;         ///< when the estimate can be used; without a latency the tick's time
  std::int64_t calls = 0;            ///< of the detector with events, or one without
  std::int64_t events = 0;           ///< that it processed
  std::int64_t events_left_out = 0;  ///< dropped because too many waited, see LatencyConfig
  std::span<const LateEstimate>
      late;  ///< at instants before the tick, sorted; at most 64; until the next tick

  /// Sets `observed` and `at_threshold` from the estimate. `any_events`: whether any were processed.
  void observe(bool any_events, double threshold) {
    observed = estimate.valid && (any_events || estimate.held);
    at_threshold = observed && estimate.score >= threshold;
  }
};

/// Passes the events of each tick to one detector: late events in slices of 1 ms, see Loop. With a latency it has a queue
/// of events and computes when each estimate is ready:
///
///   1. A detector that is not busy takes all its events in the tick. Calls follow each other; each takes the work time of
///      the detector, and its estimate is ready at its end.
///   2. At the ticks until then the detector is busy. Events that arrive wait; of more than max_waiting_events the oldest
///      are dropped.
///   3. The events that waited are processed in one call, together with those of the tick.
class DetectorRunner {
 public:
  static constexpr std::int64_t slice_us = 1'000;

  /// Without a latency.
  DetectorRunner();
  /// `name`: of the detector, see LatencyConfig::work_of.
  DetectorRunner(const LatencyConfig& latency, std::string_view name);

  /// From the next tick on events are about `age_us` old when they arrive, and detectors are advanced to the time of the
  /// newest events instead of that of the tick. Their time never goes back.
  void set_age(std::int64_t age_us) { age_us_ = age_us; }

  /// From the next tick on the detector does no optional work of the time before the last `work_us` of a tick, see LoopBudget.
  void limit_work(std::int64_t work_us) { most_work_us_ = work_us; }

  /// Calls Detector::work_ahead(). May be called in another thread while run() is not called. With a measured latency this
  /// work belongs to the next call instead.
  void work_ahead(Detector& detector);

  /// A tick at t_us. `events` arrived since the last tick; those up to `late_us` are passed in slices of their own, the
  /// others at once. `on_slice` gets the result of each call.
  template <class OnSlice>
  [[nodiscard]] DetectorTick run(Detector& detector, std::int64_t t_us, std::int64_t late_us,
                                 std::span<const Event> events, const CameraMotion* motion,
                                 OnSlice on_slice) {
    late_.clear();
    DetectorTick done;
    done.elapsed_ns = std::exchange(ahead_ns_, 0);
    if (latency_ && t_us < free_us_) {
      done.events_left_out = wait(events);
      done.busy = true;
      done.ready_us = free_us_;
      return done;
    }
    work_us_ = 0.0;
    if (most_work_us_)
      detector.leave_out_work_before(
          saturated_difference(std::max(advanced_us_, t_us - age_us_), *most_work_us_));
    const bool any = !events.empty() || !waiting_.empty();
    const auto call = [&](std::span<const Event> slice, std::int64_t about_us, bool last) {
      if (last) advanced_us_ = std::max(advanced_us_, t_us - age_us_);
      DetectorTick result =
          call_detector(detector, slice, last ? std::optional(advanced_us_) : std::nullopt, motion);
      add_work(result, !slice.empty() || !any, t_us);
      done.elapsed_ns += result.elapsed_ns;
      done.calls += result.calls;
      done.events += result.events;
      if (!last && result.observed && late_.size() < late_capacity)
        late_.push_back({about_us, result.estimate, result.ready_us});
      on_slice(result);
      return result;
    };
    std::span<const Event> left = events;
    if (!waiting_.empty()) {
      done.events_left_out = wait(events);
      left = waiting_;
      const std::int64_t until_us = slice_end_us(t_us, waiting_.back().t_us);
      if (until_us < t_us) {
        call(left, until_us, false);
        left = {};
      }
    }
    while (waiting_.empty() && !left.empty() && left.front().t_us <= late_us) {
      const std::int64_t until_us = slice_end_us(t_us, left.front().t_us);
      const auto slice = slice_until(left, until_us);
      call(slice, until_us, false);
      left = left.subspan(slice.size());
    }
    const DetectorTick last = call(left, t_us, true);
    waiting_.clear();
    done.estimate = last.estimate;
    done.on_time = last.observed && age_us_ < slice_us;
    done.observe(any, detector.threshold());
    done.ready_us = last.ready_us;
    done.late = late_;
    free_us_ = last.ready_us;
    return done;
  }

 private:
  static constexpr std::size_t late_capacity = 64;  // estimates; any more are not reported

  [[nodiscard]] static DetectorTick call_detector(Detector& detector, std::span<const Event> events,
                                                  std::optional<std::int64_t> now_us,
                                                  const CameraMotion* motion);
  /// The end of the slice with an event at event_us; slices end whole milliseconds before the tick.
  [[nodiscard]] static std::int64_t slice_end_us(std::int64_t t_us, std::int64_t event_us) {
    return t_us - saturated_difference(t_us, event_us) / slice_us * slice_us;
  }
  [[nodiscard]] static std::span<const Event> slice_until(std::span<const Event> events,
                                                          std::int64_t until_us);
  /// Puts events into the queue. Returns how many were dropped.
  std::int64_t wait(std::span<const Event> events);
  /// Sets calls and ready_us of a call's result. `counts`: whether the call takes time.
  void add_work(DetectorTick& result, bool counts, std::int64_t t_us);

  bool latency_ = false;
  bool measured_ = false;
  WorkTime work_;
  std::size_t max_waiting_ = 0;
  std::vector<LateEstimate> late_;
  std::vector<Event> waiting_;
  std::int64_t free_us_ = 0;
  std::int64_t age_us_ = 0;
  std::optional<std::int64_t> most_work_us_;
  std::int64_t advanced_us_ = std::numeric_limits<std::int64_t>::min();
  double work_us_ = 0.0;       // of this tick's calls
  std::int64_t ahead_ns_ = 0;  // time of the work ahead of them
};

}  // namespace saccade
