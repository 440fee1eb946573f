#pragma once

#include <cstdint>
#include <string_view>

#include "core/random.h"

namespace saccade {

/// Random numbers that are drawn one after the other. The sequence depends on seed and name alone.
class RandomGenerator {
 public:
  RandomGenerator(std::uint64_t seed, std::string_view name) : random_(seed, name) {}

  /// Uniform in [low, high).
  double real(double low, double high) { return random_.uniform(low, high, 0, count_++); }
  /// Uniform in 0, 1, ..., n - 1.
  int index(int n) { return static_cast<int>(real(0.0, n)); }
  /// True with probability p.
  bool chance(double p) { return real(0.0, 1.0) < p; }
  /// Standard normal.
  double normal() { return random_.normal(0, count_++); }

 private:
  RandomStream random_;
  std::uint64_t count_ = 0;
};

}  // namespace saccade
