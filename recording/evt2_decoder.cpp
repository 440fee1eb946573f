#include "recording/evt2_decoder.h"

#include <algorithm>

#include "recording/byte_order.h"

namespace saccade {

EvtStep Evt2Decoder::run(std::string_view bytes, std::span<Event> out) {
  const std::size_t words = std::min(bytes.size() / word_bytes, out.size());
  EvtStep step;
  // Local copies stay in registers.
  std::int64_t t_us = t_us_;
  std::size_t n = 0;
  std::size_t i = 0;
  for (; i < words; ++i) {
    const auto word = load_little<std::uint32_t>(bytes.data() + i * word_bytes);
    const std::uint32_t type = word >> 28;
    if (type <= 1 && timed_) {
      out[n++] = {t_us + (word >> 22 & 0x3f), static_cast<std::uint16_t>(word >> 11 & 0x7ff),
                  static_cast<std::uint16_t>(word & 0x7ff), type == 1, 0};
    } else if (type <= 1) {
      ++counts_.events_without_time;
    } else if (type == 0x8) {
      timed_ = true;
      t_us = (high_.extend(word & 0xfffffff) << 6) + offset_us_;
    } else if (type == 0xa && timed_) {
      triggers_.found(t_us + (word >> 22 & 0x3f), word >> 8 & 0x1f, (word & 1) != 0, counts_);
    } else if (type == 0xa) {
      ++counts_.triggers;
    } else if (type >= 0xd) {
      ++counts_.other_words;
    } else {
      ++counts_.undefined[type];
    }
  }
  t_us_ = t_us;
  step.words = i;
  step.events = n;
  return step;
}

}  // namespace saccade
