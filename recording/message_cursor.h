#pragma once

#include <algorithm>
#include <bit>
#include <concepts>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "recording/byte_order.h"

namespace saccade {

/// How the members of a message become bytes.
enum class Serialisation {
  ros1,  ///< ROS 1: little-endian without gaps
  cdr,   ///< ROS 2: OMG's CDR, little-endian, numbers at multiples of their size
};

inline constexpr std::string_view cdr_little = {"\0\1\0\0", 4};  ///< before a message in CDR

/// What a message contains that is no such message, and what was expected.
struct BrokenMessage {
  std::string found, expected;
};

/// What is wrong where a message is not in this serialisation.
[[nodiscard]] inline std::optional<BrokenMessage> broken_serialisation(std::string_view message,
                                                                       Serialisation serialisation) {
  if (serialisation != Serialisation::cdr || message.starts_with(cdr_little.substr(0, 2)))
    return std::nullopt;
  return BrokenMessage{"a message in another serialisation than little-endian CDR",
                       "one that begins with the bytes 0 and 1"};
}

/// To the nearest us.
[[nodiscard]] inline std::int64_t us_of(std::uint64_t ns) {
  return static_cast<std::int64_t>((ns + 500) / 1000);
}

/// Takes numbers and texts from a message.
class MessageCursor {
 public:
  MessageCursor(std::string_view message, Serialisation serialisation)
      : message_(message),
        at_(serialisation == Serialisation::cdr ? cdr_little.size() : 0),
        cdr_(serialisation == Serialisation::cdr) {}

  template <std::integral T>
  [[nodiscard]] bool take(T& value) {
    // Positions count from the end of the 4 bytes in front.
    if (cdr_) at_ += (sizeof(T) - (at_ - cdr_little.size()) % sizeof(T)) % sizeof(T);
    if (at_ > message_.size() || message_.size() - at_ < sizeof(T)) return false;
    value = load_little<T>(message_.data() + at_);
    at_ += sizeof(T);
    return true;
  }
  [[nodiscard]] bool take(double& value) {
    std::uint64_t bits = 0;
    if (!take(bits)) return false;
    value = std::bit_cast<double>(bits);
    return true;
  }
  [[nodiscard]] bool take_text(std::string_view& text) {
    std::uint32_t length = 0;
    if (!take(length) || message_.size() - at_ < length) return false;
    text = message_.substr(at_, length);
    at_ += length;
    if (cdr_ && text.ends_with('\0')) text.remove_suffix(1);
    return true;
  }
  /// A header's stamp, to the nearest us; its sequence number and frame are passed over.
  [[nodiscard]] bool take_header(std::int64_t& t_us) {
    std::uint32_t number = 0, seconds = 0, ns = 0;
    std::string_view frame;
    if ((!cdr_ && !take(number)) || !take(seconds) || !take(ns) || !take_text(frame)) return false;
    t_us = seconds * std::int64_t{1'000'000} + us_of(ns);
    return true;
  }
  /// Bytes with their number in front.
  [[nodiscard]] bool take_bytes(std::string_view& bytes) {
    std::uint32_t count = 0;
    if (!take(count) || message_.size() - at_ < count) return false;
    bytes = message_.substr(at_, count);
    at_ += count;
    return true;
  }
  [[nodiscard]] std::string_view rest() const { return message_.substr(std::min(at_, message_.size())); }

 private:
  std::string_view message_;
  std::size_t at_;
  bool cdr_;
};

}  // namespace saccade
