#pragma once

#include <cstdint>
#include <string_view>

namespace saccade {

/// Counter-based random numbers: a value is a pure function of (seed, stream, counter), so it does not
/// depend on the order of calls, the number of threads or the compiler. The mixer is the finaliser of
/// SplitMix64 (Steele, Lea, Flood, OOPSLA 2014), applied to each of the three words in turn.
class RandomStream {
 public:
  /// The generator of one module. Generators with the same seed and different names are independent.
  RandomStream(std::uint64_t seed, std::string_view name);

  /// 64 uniform bits for element `stream` (say, a pixel) at step `counter`.
  [[nodiscard]] std::uint64_t bits(std::uint64_t stream, std::uint64_t counter = 0) const {
    return mix(mix(key_ ^ mix(stream + 0x632be59bd9b4e019ULL)) + counter * 0x9e3779b97f4a7c15ULL);
  }
  /// Uniform in [0, 1), 53 bits.
  [[nodiscard]] double uniform(std::uint64_t stream, std::uint64_t counter = 0) const {
    return static_cast<double>(bits(stream, counter) >> 11) * 0x1.0p-53;
  }
  /// Uniform in [low, high).
  [[nodiscard]] double uniform(double low, double high, std::uint64_t stream, std::uint64_t counter) const {
    return low + (high - low) * uniform(stream, counter);
  }
  /// Standard normal: the inverse normal distribution of one uniform number, by Acklam's rational
  /// approximation (relative error below 1.2e-9).
  [[nodiscard]] double normal(std::uint64_t stream, std::uint64_t counter = 0) const;

 private:
  static std::uint64_t mix(std::uint64_t z) {
    z += 0x9e3779b97f4a7c15ULL;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31);
  }

  std::uint64_t key_;
};

}  // namespace saccade
