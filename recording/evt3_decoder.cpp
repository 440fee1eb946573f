#include "recording/evt3_decoder.h"

#include <bit>

#include "recording/byte_order.h"

namespace saccade::inline v0_1 {

EvtStep Evt3Decoder::run(std::string_view bytes, std::span<Event> out) {
  const std::size_t words = bytes.size() / word_bytes;
  const std::size_t enough = out.size() - most_events_of_word;
  EvtStep step;
  std::size_t n = 0;
  std::size_t i = 0;
  for (; i < words && n <= enough; ++i) {
    const auto word = load_little<std::uint16_t>(bytes.data() + i * word_bytes);
    switch (word >> 12) {
      case addr_y:
        y_ = word & 0x7ff;
        begun_ = timed_;
        break;
      case addr_x:
        out[n++] = {t_us_, static_cast<std::uint16_t>(word & 0x7ff), y_, (word & 0x800) != 0, 0};
        break;
      case vect_base_x:
        base_x_ = word & 0x7ff;
        base_on_ = (word & 0x800) != 0;
        break;
      case vect_12:
        n = put_vector(out, n, word & 0xfffu, 12);
        break;
      case vect_8:
        n = put_vector(out, n, word & 0xffu, 8);
        break;
      case time_low:
        low_ = word & 0xfff;
        t_us_ = high_us_ + low_;
        break;
      case time_high:
        set_high(word & 0xfff);
        break;
      case trigger:
        ++triggers_;
        break;
      case continued_4:
      case others:
      case continued_12:
        ++other_words_;
        break;
      default:
        step.unknown_type = word >> 12u;
    }
    if (step.unknown_type) break;
    if (!begun_) {
      events_without_time_ += static_cast<std::int64_t>(n);
      n = 0;
    }
  }
  step.words = i;
  step.events = n;
  return step;
}

std::size_t Evt3Decoder::put_vector(std::span<Event> out, std::size_t n, unsigned pixels, unsigned length) {
  for (; pixels != 0; pixels &= pixels - 1) {
    const auto x = static_cast<std::uint16_t>(base_x_ + std::countr_zero(pixels));
    out[n++] = {t_us_, x, y_, base_on_, 0};
  }
  base_x_ = static_cast<std::uint16_t>(base_x_ + length);
  return n;
}

void Evt3Decoder::set_high(std::int64_t value) {
  const std::int64_t high_us = (high_.extend(value) << 12) + offset_us_;
  if (high_us != high_us_) low_ = 0;
  timed_ = true;
  high_us_ = high_us;
  t_us_ = high_us_ + low_;
}

}  // namespace saccade::inline v0_1
