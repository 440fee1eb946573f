#pragma once

#include <cstdint>
#include <limits>

namespace saccade {

/// Sum and difference of time stamps, us. Where the exact result does not fit into 64 bits, they return the nearest
/// value that does.
[[nodiscard]] constexpr std::int64_t saturated_sum(std::int64_t a, std::int64_t b) {
  std::int64_t sum = 0;
  if (!__builtin_add_overflow(a, b, &sum)) return sum;
  return a < 0 ? std::numeric_limits<std::int64_t>::min() : std::numeric_limits<std::int64_t>::max();
}
[[nodiscard]] constexpr std::int64_t saturated_difference(std::int64_t a, std::int64_t b) {
  std::int64_t difference = 0;
  if (!__builtin_sub_overflow(a, b, &difference)) return difference;
  return a < 0 ? std::numeric_limits<std::int64_t>::min() : std::numeric_limits<std::int64_t>::max();
}
/// That difference in seconds.
[[nodiscard]] constexpr double difference_s(std::int64_t a_us, std::int64_t b_us) {
  return static_cast<double>(saturated_difference(a_us, b_us)) * 1e-6;
}

}  // namespace saccade
