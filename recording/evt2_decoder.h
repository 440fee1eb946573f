#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "core/event.h"
#include "recording/evt_step.h"
#include "recording/wrapping_time.h"

namespace saccade::inline v0_1 {

/// Words of EVT2 (recording/evt_codec.h) as events, piece by piece. Events before the first time are counted and left
/// out.
class Evt2Decoder {
 public:
  static constexpr std::size_t word_bytes = 4;

  /// `offset_us` is added to all times.
  explicit Evt2Decoder(std::int64_t offset_us = 0) : offset_us_(offset_us) {}

  /// Decodes words until they end, one has an unknown type, or there have been as many as `out` has places.
  [[nodiscard]] EvtStep run(std::string_view bytes, std::span<Event> out);

  [[nodiscard]] std::int64_t events_without_time() const { return events_without_time_; }
  [[nodiscard]] std::int64_t triggers() const { return triggers_; }
  [[nodiscard]] std::int64_t other_words() const { return other_words_; }

 private:
  std::int64_t offset_us_;
  std::int64_t events_without_time_ = 0;
  std::int64_t triggers_ = 0;
  std::int64_t other_words_ = 0;
  bool timed_ = false;     ///< from the first time on
  std::int64_t t_us_ = 0;  ///< without the lower 6 bits
  WrappingTime high_{{{0, std::int64_t{1} << 28}}, std::int64_t{1} << 26, std::int64_t{1} << 16};
};

}  // namespace saccade::inline v0_1
