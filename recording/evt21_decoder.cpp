#include "recording/evt21_decoder.h"

#include <bit>

#include "recording/byte_order.h"

namespace saccade {

std::uint64_t load_evt21(const char* bytes, Evt21Order order) {
  const auto word = load_little<std::uint64_t>(bytes);
  return order == Evt21Order::little ? word : std::rotl(word, 32);
}

EvtStep Evt21Decoder::run(std::string_view bytes, std::span<Event> out) {
  const std::size_t words = bytes.size() / word_bytes;
  const std::size_t enough = out.size() - most_events_of_word;
  EvtStep step;
  for (; step.words < words && step.events <= enough; ++step.words) {
    const std::uint64_t word = load_evt21(bytes.data() + step.words * word_bytes, order_);
    const auto type = static_cast<unsigned>(word >> 60);
    auto pixels = static_cast<std::uint32_t>(word);
    if (type <= 1 && timed_) {
      const std::int64_t t_us = t_us_ + static_cast<std::int64_t>(word >> 54 & 0x3f);
      const auto x = static_cast<unsigned>(word >> 43 & 0x7ff);
      const auto y = static_cast<std::uint16_t>(word >> 32 & 0x7ff);
      for (; pixels != 0; pixels &= pixels - 1) {
        const unsigned pixel = x + static_cast<unsigned>(std::countr_zero(pixels));
        out[step.events++] = {t_us, static_cast<std::uint16_t>(pixel), y, type == 1, 0};
      }
    } else if (type <= 1) {
      counts_.events_without_time += std::popcount(pixels);
    } else if (type == 0x8) {
      timed_ = true;
      t_us_ = (high_.extend(static_cast<std::int64_t>(word >> 32 & 0xfffffff)) << 6) + offset_us_;
    } else if (type == 0xa && timed_) {
      triggers_.found(t_us_ + static_cast<std::int64_t>(word >> 54 & 0x3f), word >> 40 & 0x1f,
                      (word >> 32 & 1) != 0, counts_);
    } else if (type == 0xa) {
      ++counts_.triggers;
    } else if (type >= 0xe) {
      ++counts_.other_words;
    } else {
      ++counts_.undefined[type];
    }
  }
  return step;
}

}  // namespace saccade
