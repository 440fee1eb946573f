#include "loop/detector_runner.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

namespace saccade {

DetectorRunner::DetectorRunner() : free_us_(std::numeric_limits<std::int64_t>::min()) {
  late_.reserve(late_capacity);
}

DetectorRunner::DetectorRunner(const LatencyConfig& latency, std::string_view name) : DetectorRunner() {
  latency_ = true;
  measured_ = latency.kind == LatencyKind::measured;
  work_ = latency.work_of(name);
  max_waiting_ = static_cast<std::size_t>(latency.max_waiting_events);
  waiting_.reserve(max_waiting_);
}

void DetectorRunner::work_ahead(Detector& detector) {
  if (measured_) return;
  const auto begin = std::chrono::steady_clock::now();
  detector.work_ahead();
  ahead_ns_ +=
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - begin).count();
}

DetectorTick DetectorRunner::call_detector(Detector& detector, std::span<const Event> events,
                                           std::optional<std::int64_t> now_us, const CameraMotion* motion) {
  const auto begin = std::chrono::steady_clock::now();
  detector.process(events, motion);
  if (now_us) detector.advance_to(*now_us, motion);
  DetectorTick result;
  result.estimate = detector.estimate();
  const auto end = std::chrono::steady_clock::now();
  result.observe(!events.empty(), detector.threshold());
  result.on_time = result.observed;
  result.elapsed_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(end - begin).count();
  result.events = static_cast<std::int64_t>(events.size());
  return result;
}

std::span<const Event> DetectorRunner::slice_until(std::span<const Event> events, std::int64_t until_us) {
  const auto end = std::ranges::upper_bound(events, until_us, {}, &Event::t_us);
  return events.first(static_cast<std::size_t>(end - events.begin()));
}

std::int64_t DetectorRunner::wait(std::span<const Event> events) {
  const std::size_t all = waiting_.size() + events.size();
  const std::size_t dropped = all > max_waiting_ ? all - max_waiting_ : 0;
  const std::size_t old = std::min(dropped, waiting_.size());
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(old));
  const auto added = events.subspan(dropped - old);
  waiting_.insert(waiting_.end(), added.begin(), added.end());
  return static_cast<std::int64_t>(dropped);
}

void DetectorRunner::add_work(DetectorTick& result, bool counts, std::int64_t t_us) {
  result.calls = counts ? 1 : 0;
  if (latency_) {
    work_us_ +=
        measured_ ? static_cast<double>(result.elapsed_ns) * 1e-3 : work_.of(result.calls, result.events);
  }
  result.ready_us = t_us + std::llround(std::ceil(work_us_));
}

}  // namespace saccade
