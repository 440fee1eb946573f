#pragma once

#include <bit>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <string>
#include <type_traits>

namespace saccade {

/// Whole numbers as files have them. The caller sees to it that there are sizeof(T) bytes.
template <std::integral T>
[[nodiscard]] constexpr T load_little(const char* bytes) {
  if constexpr (std::endian::native == std::endian::little) {
    // One load: GCC 12 does not always make it of the loop below.
    if (!std::is_constant_evaluated()) {
      T value;
      std::memcpy(&value, bytes, sizeof value);
      return value;
    }
  }
  std::make_unsigned_t<T> value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i)
    value = static_cast<std::make_unsigned_t<T>>(
        value | static_cast<std::make_unsigned_t<T>>(static_cast<unsigned char>(bytes[i])) << 8 * i);
  return static_cast<T>(value);
}
template <std::integral T>
[[nodiscard]] constexpr T load_big(const char* bytes) {
  std::make_unsigned_t<T> value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i)
    value = static_cast<std::make_unsigned_t<T>>(
        value | static_cast<std::make_unsigned_t<T>>(static_cast<unsigned char>(bytes[i]))
                    << 8 * (sizeof(T) - 1 - i));
  return static_cast<T>(value);
}

template <std::integral T>
void append_little(std::string& bytes, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) bytes += static_cast<char>(value >> 8 * i & 0xff);
}

}  // namespace saccade
