#pragma once

#include <cstdint>
#include <span>
#include <string_view>

#include "core/event.h"
#include "recording/evt2_decoder.h"
#include "recording/evt_counts.h"
#include "recording/wrapping_time.h"

namespace saccade {

/// Order of the two 32-bit halves of a word of EVT2.1; each half is little-endian.
enum class Evt21Order {
  little,  ///< the lower half first: the whole word is little-endian (GenX320)
  legacy,  ///< the upper half, with the type, first (IMX636)
};

/// The word of EVT2.1 at `bytes`.
[[nodiscard]] std::uint64_t load_evt21(const char* bytes, Evt21Order order);

/// Words of EVT2.1 (recording/evt_codec.h) as events, piece by piece. Events before the first time and words of undefined
/// types are counted and left out.
class Evt21Decoder {
 public:
  static constexpr std::size_t word_bytes = 8;
  static constexpr std::size_t most_events_of_word = 32;

  /// `offset_us` is added to all times.
  explicit Evt21Decoder(std::int64_t offset_us, Evt21Order order) : offset_us_(offset_us), order_(order) {}

  /// Decodes words until they end, or fewer than most_events_of_word places are left in `out`, which must have that many.
  [[nodiscard]] EvtStep run(std::string_view bytes, std::span<Event> out);

  [[nodiscard]] const EvtCounts& counts() const { return counts_; }
  [[nodiscard]] EvtTriggers& triggers() { return triggers_; }

 private:
  std::int64_t offset_us_;
  Evt21Order order_;
  EvtCounts counts_;
  EvtTriggers triggers_;
  bool timed_ = false;     ///< from the first time on
  std::int64_t t_us_ = 0;  ///< without the lower 6 bits
  WrappingTime high_ = evt2_high();
};

}  // namespace saccade
