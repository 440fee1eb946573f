#include "recording/evt2_decoder.h"

#include <algorithm>

#include "recording/byte_order.h"

namespace saccade::inline v0_1 {

EvtStep Evt2Decoder::run(std::string_view bytes, std::span<Event> out) {
  const std::size_t words = std::min(bytes.size() / word_bytes, out.size());
  EvtStep step;
  for (; step.words < words; ++step.words) {
    const auto word = load_little<std::uint32_t>(bytes.data() + step.words * word_bytes);
    const std::uint32_t type = word >> 28;
    if (type <= 1) {
      out[step.events] = {t_us_ + (word >> 22 & 0x3f), static_cast<std::uint16_t>(word >> 11 & 0x7ff),
                          static_cast<std::uint16_t>(word & 0x7ff), type == 1, 0};
      step.events += timed_;
      events_without_time_ += 1 - timed_;
    } else if (type == 0x8) {
      timed_ = 1;
      t_us_ = (high_.extend(word & 0xfffffff) << 6) + offset_us_;
    } else if (type == 0xa) {
      ++triggers_;
    } else if (type >= 0xd) {
      ++other_words_;
    } else {
      step.unknown_type = type;
      break;
    }
  }
  return step;
}

}  // namespace saccade::inline v0_1
