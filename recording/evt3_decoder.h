#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "core/event.h"
#include "recording/evt_counts.h"
#include "recording/wrapping_time.h"

namespace saccade {

/// Continues the upper 12 bits of EVT3's time. A sensor sends them every 4 ms or sooner, so that half of the range is enough
/// to recognise a wrap.
inline WrappingTime evt3_high() { return {{{0, 4096}}, 2048, 1024}; }

/// Words of EVT3 (recording/evt_codec.h) as events, piece by piece. Events before the first time, or before the first row
/// after it, and words of undefined types are counted and left out.
class Evt3Decoder {
 public:
  static constexpr std::size_t word_bytes = 2;
  static constexpr std::size_t most_events_of_word = 12;

  /// `offset_us` is added to all times.
  explicit Evt3Decoder(std::int64_t offset_us = 0) : offset_us_(offset_us) {}

  /// Decodes words until they end, or fewer than most_events_of_word places are left in `out`, which must have that many.
  [[nodiscard]] EvtStep run(std::string_view bytes, std::span<Event> out);

  [[nodiscard]] const EvtCounts& counts() const { return counts_; }
  [[nodiscard]] EvtTriggers& triggers() { return triggers_; }

 private:
  static constexpr std::uint32_t on_bit = 1u << 16;

  std::size_t begin(std::string_view bytes);
  void skip(std::uint16_t word);
  void set_high(std::int64_t value);

  std::int64_t offset_us_;
  EvtCounts counts_;
  EvtTriggers triggers_;
  bool timed_ = false;
  bool begun_ = false;  ///< from the first row after the first time on
  std::int64_t t_us_ = 0;
  std::int64_t high_us_ = 0;
  std::int64_t low_ = 0;
  std::uint32_t row_ = 0;
  std::uint32_t base_ = 0;  ///< column, and on_bit where it is ON
  WrappingTime high_ = evt3_high();
};

/// Types of EVT3's words.
enum Evt3 : std::uint16_t {
  addr_y = 0x0,
  addr_x = 0x2,
  vect_base_x = 0x3,
  vect_12 = 0x4,
  vect_8 = 0x5,
  time_low = 0x6,
  continued_4 = 0x7,
  time_high = 0x8,
  trigger = 0xa,
  others = 0xe,
  continued_12 = 0xf
};

}  // namespace saccade
