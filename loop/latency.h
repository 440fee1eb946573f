#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/config.h"

namespace saccade {

enum class LatencyKind {
  none,      ///< events, computing and commands take no time
  model,     ///< the constants of the configuration; deterministic
  measured,  ///< computing takes what the clock measures; two runs differ
};
constexpr auto words_of(LatencyKind) {
  return std::to_array<Word<LatencyKind>>(
      {{LatencyKind::none, "none"}, {LatencyKind::model, "model"}, {LatencyKind::measured, "measured"}});
}

/// Processing time of a detector.
struct WorkTime {
  double per_event_us = 0.0;
  double per_call_us = 0.0;  ///< of a call with the events of 1 ms, or of an image

  /// us
  [[nodiscard]] double of(std::int64_t calls, std::int64_t events) const {
    return per_call_us * static_cast<double>(calls) + per_event_us * static_cast<double>(events);
  }
};

/// Keys: per_event_us, per_call_us.
void describe(FieldVisitor& v, WorkTime& work);

/// How long everything between light and motion takes in a simulated run.
struct LatencyConfig {
  LatencyKind kind = LatencyKind::none;
  double transport_ms = 0.0;   ///< from an event's time stamp to its arrival, rounded up to whole ms
  double actuation_ms = 0.0;   ///< from a command to its effect on the head
  double controller_us = 0.0;  ///< `model`: a step of the controller
  std::int64_t max_waiting_events = 20'000;                 ///< of one detector while it is busy
  std::vector<std::pair<std::string, WorkTime>> detectors;  ///< `model`: by name; others take no time

  /// Of the detector with that name.
  [[nodiscard]] WorkTime work_of(std::string_view name) const;
  /// transport_ms in whole milliseconds, us.
  [[nodiscard]] std::int64_t transport_us() const;
};

/// Keys: transport_ms, actuation_ms, controller_us, max_waiting_events, those of `model` only with that kind. The keys
/// `kind` and `detectors` are the caller's.
void describe_times(FieldVisitor& v, LatencyConfig& config);

}  // namespace saccade
