#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "core/event.h"
#include "recording/evt_counts.h"
#include "recording/wrapping_time.h"

namespace saccade {

/// Continues the upper 28 bits of the time in EVT2 and EVT2.1.
inline WrappingTime evt2_high() {
  return {{{0, std::int64_t{1} << 28}}, std::int64_t{1} << 26, std::int64_t{1} << 16};
}

/// Words of EVT2 (recording/evt_codec.h) as events, piece by piece. Events before the first time and words of undefined
/// types are counted and left out.
class Evt2Decoder {
 public:
  static constexpr std::size_t word_bytes = 4;

  /// `offset_us` is added to all times.
  explicit Evt2Decoder(std::int64_t offset_us = 0) : offset_us_(offset_us) {}

  /// Decodes words until they end, or there have been as many as `out` has places.
  [[nodiscard]] EvtStep run(std::string_view bytes, std::span<Event> out);

  [[nodiscard]] const EvtCounts& counts() const { return counts_; }
  [[nodiscard]] EvtTriggers& triggers() { return triggers_; }

 private:
  std::int64_t offset_us_;
  EvtCounts counts_;
  EvtTriggers triggers_;
  bool timed_ = false;     ///< from the first time on
  std::int64_t t_us_ = 0;  ///< without the lower 6 bits
  WrappingTime high_ = evt2_high();
};

}  // namespace saccade
