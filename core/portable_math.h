#pragma once

#include <bit>
#include <cstdint>

namespace saccade {

/// ln(x) for positive, normal x, to 4e-15. Unlike std::log it gives the same bits with every compiler and machine.
/// Range reduction and the series of the inverse hyperbolic tangent.
[[nodiscard]] inline double portable_log(double x) {
  constexpr double ln2 = 0.693147180559945309417;
  constexpr std::uint64_t sqrt_half = 0x3fe6a09e667f3bcdULL;
  // x = m 2^e with m in [sqrt(1/2), sqrt(2))
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(x) - sqrt_half;
  const double m = std::bit_cast<double>((bits & 0x000fffffffffffffULL) + sqrt_half);
  const auto e = static_cast<double>(static_cast<std::int64_t>(bits) >> 52);
  const double s = (m - 1.0) / (m + 1.0);
  const double z = s * s;
  double series = 1.0 / 17;
  for (int odd = 15; odd >= 1; odd -= 2) series = series * z + 1.0 / odd;
  return e * ln2 + 2.0 * s * series;
}

/// exp(x) for x <= 700, relative error 1e-14; 0 below -700. The same bits with every compiler and machine.
[[nodiscard]] inline double portable_exp(double x) {
  if (x < -700.0) return 0.0;
  constexpr double ln2_high = 0x1.62e42fee00000p-1;
  constexpr double ln2_low = 0x1.a39ef35793c76p-33;
  constexpr double round = 0x1.8p52;
  const double shifted = x * 1.44269504088896340736 + round;
  const double n = shifted - round;
  const double r = (x - n * ln2_high) - n * ln2_low;
  // The series to r^13, even and odd powers apart: two short chains instead of a long one.
  const double z = r * r;
  const double even =
      ((((((1.0 / 479001600) * z + 1.0 / 3628800) * z + 1.0 / 40320) * z + 1.0 / 720) * z + 1.0 / 24) * z +
       0.5) *
          z +
      1.0;
  const double odd =
      ((((((1.0 / 6227020800) * z + 1.0 / 39916800) * z + 1.0 / 362880) * z + 1.0 / 5040) * z + 1.0 / 120) *
           z +
       1.0 / 6) *
          z +
      1.0;
  const auto exponent = static_cast<std::int64_t>(n) + 1023;
  return (even + r * odd) * std::bit_cast<double>(static_cast<std::uint64_t>(exponent) << 52U);
}

}  // namespace saccade
