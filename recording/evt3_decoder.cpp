#include "recording/evt3_decoder.h"

#include <array>
#include <bit>

#include "recording/byte_order.h"

namespace saccade {
namespace {

/// What a type of word changes, as masks: a compiler makes branches of comparisons.
struct Change {
  std::int64_t t_us = 0;
  std::uint32_t row = 0;
  std::uint32_t base = 0;
  std::size_t events = 0;
};
constexpr std::array<Change, 16> changes = [] {
  std::array<Change, 16> table{};
  table[time_low].t_us = -1;
  table[addr_y].row = table[vect_base_x].base = ~0u;
  table[addr_x].events = 1;
  return table;
}();

template <class T>
void replace(T& value, T by, T mask) {
  value ^= (value ^ by) & mask;
}

}  // namespace

EvtStep Evt3Decoder::run(std::string_view bytes, std::span<Event> out) {
  const std::size_t words = bytes.size() / word_bytes;
  const std::size_t enough = out.size() - most_events_of_word;
  const auto word_at = [&](std::size_t i) {
    return load_little<std::uint16_t>(bytes.data() + i * word_bytes);
  };
  EvtStep step;
  std::size_t i = begun_ ? 0 : begin(bytes);
  std::size_t n = 0;
  // Local copies stay in registers.
  std::int64_t t_us = t_us_, high_us = high_us_;
  std::uint32_t row = row_, base = base_;
  const auto put = [&](std::uint32_t x) {
    out[n] = {t_us, static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(row), (x >> 16 & 1) != 0, 0};
  };
  const auto put_vector = [&](unsigned pixels, unsigned length) {
    for (; pixels != 0; pixels &= pixels - 1, ++n)
      put((base & on_bit) | ((base + static_cast<std::uint32_t>(std::countr_zero(pixels))) & 0xffff));
    base = (base & on_bit) | ((base + length) & 0xffff);
  };
  while (i < words && n <= enough) {
    const std::uint16_t word = word_at(i);
    const unsigned type = word >> 12u;
    // Most words change one field or are one event, in an order that no processor predicts: they are taken without a
    // branch on their type.
    constexpr unsigned plain = 1u << addr_y | 1u << addr_x | 1u << vect_base_x | 1u << time_low;
    if ((plain >> type & 1) != 0) {
      const Change& change = changes[type];
      const std::uint32_t x = (word & 0x7ffu) | (word & 0x800u) << 5u;
      put(x);
      n += change.events;
      replace(row, word & 0x7ffu, change.row);
      replace(base, x, change.base);
      replace(t_us, high_us + (word & 0xfff), change.t_us);
      ++i;
      continue;
    }
    if (type == vect_12) {
      // Three words of 32 pixels, as cameras write them, in one.
      if (i + 2 < words && n + 32 <= out.size() && word_at(i + 1) >> 12u == vect_12 &&
          word_at(i + 2) >> 12u == vect_8) {
        put_vector((word & 0xfffu) | (word_at(i + 1) & 0xfffu) << 12u | (word_at(i + 2) & 0xffu) << 24u, 32);
        i += 2;
      } else {
        put_vector(word & 0xfffu, 12);
      }
    } else if (type == vect_8) {
      put_vector(word & 0xffu, 8);
    } else if (type == time_high) {
      low_ = t_us - high_us;
      set_high(word & 0xfff);
      t_us = t_us_;
      high_us = high_us_;
    } else {
      t_us_ = t_us;
      skip(word);
    }
    ++i;
  }
  t_us_ = t_us;
  low_ = t_us - high_us;
  row_ = row;
  base_ = base;
  step.words = i;
  step.events = n;
  return step;
}

/// The words up to the first row after the first time. Returns their number.
std::size_t Evt3Decoder::begin(std::string_view bytes) {
  const std::size_t words = bytes.size() / word_bytes;
  const auto leave_out = [&](unsigned pixels, unsigned length) {
    counts_.events_without_time += std::popcount(pixels);
    base_ = (base_ & on_bit) | ((base_ + length) & 0xffff);
  };
  std::size_t i = 0;
  for (; i < words && !begun_; ++i) {
    const auto word = load_little<std::uint16_t>(bytes.data() + i * word_bytes);
    const unsigned type = word >> 12u;
    switch (type) {
      case addr_y:
        row_ = word & 0x7ffu;
        begun_ = timed_;
        break;
      case addr_x:
        ++counts_.events_without_time;
        break;
      case vect_base_x:
        base_ = (word & 0x7ffu) | (word & 0x800u) << 5u;
        break;
      case vect_12:
        leave_out(word & 0xfffu, 12);
        break;
      case vect_8:
        leave_out(word & 0xffu, 8);
        break;
      case time_low:
        low_ = word & 0xfff;
        t_us_ = high_us_ + low_;
        break;
      case time_high:
        set_high(word & 0xfff);
        break;
      default:
        skip(word);
    }
  }
  return i;
}

/// Takes a word that has no part in events.
void Evt3Decoder::skip(std::uint16_t word) {
  const unsigned type = word >> 12u;
  if (type == trigger && timed_) {
    triggers_.found(t_us_, word >> 8u & 0xfu, (word & 1u) != 0, counts_);
  } else if (type == trigger) {
    ++counts_.triggers;
  } else if (type == continued_4 || type == others || type == continued_12) {
    ++counts_.other_words;
  } else {
    ++counts_.undefined[type];
  }
}

void Evt3Decoder::set_high(std::int64_t value) {
  const std::int64_t high_us = (high_.extend(value) << 12) + offset_us_;
  if (high_us != high_us_) low_ = 0;
  timed_ = true;
  high_us_ = high_us;
  t_us_ = high_us_ + low_;
}

}  // namespace saccade
