#include "loop/latency.h"

#include <algorithm>
#include <cmath>

namespace saccade {

void describe(FieldVisitor& v, WorkTime& work) {
  v.real("per_event_us", work.per_event_us, {0.0, 1e6}, "processing time of one event");
  v.real("per_call_us", work.per_call_us, {0.0, 1e7},
         "processing time of a call with the events of 1 ms, or of an image");
}

WorkTime LatencyConfig::work_of(std::string_view name) const {
  const auto found = std::ranges::find(detectors, name, &std::pair<std::string, WorkTime>::first);
  return found == detectors.end() ? WorkTime{} : found->second;
}

std::int64_t LatencyConfig::transport_us() const { return std::llround(std::ceil(transport_ms)) * 1000; }

void describe_times(FieldVisitor& v, LatencyConfig& config) {
  v.real("transport_ms", config.transport_ms, {0.0, 1000.0},
         "time from an event's time stamp to its arrival at the detectors, rounded up to whole milliseconds");
  v.real("actuation_ms", config.actuation_ms, {0.0, 1000.0}, "time from a command to its effect on the head");
  v.when(config.kind == LatencyKind::model, "kind: model", [&] {
    v.real("controller_us", config.controller_us, {0.0, 1e6}, "processing time of a step of the controller");
  });
  v.integer("max_waiting_events", config.max_waiting_events, {1, 1e6},
            "events that wait for a busy detector; older ones are dropped");
}

}  // namespace saccade
