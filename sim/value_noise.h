#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "sim/random_generator.h"

namespace saccade {

/// Value noise: random values on a square lattice, interpolated smoothly, and sums of it over octaves.
/// It repeats every 64 lattice points.
class ValueNoise {
 public:
  explicit ValueNoise(RandomGenerator& random);

  /// In [-1, 1]; the lattice points are one unit apart.
  [[nodiscard]] double at(double x, double y) const;
  /// The sum of `octaves` noises, normalised to the strength of one. Each octave is twice as fine as the one before
  /// and `falloff` as strong: 0.5 looks like clouds, 0.7 like gravel.
  [[nodiscard]] double sum(double x, double y, int octaves, double falloff = 0.6) const;

 private:
  static constexpr std::int64_t side = 64;

  [[nodiscard]] double value(std::int64_t x, std::int64_t y) const {
    return static_cast<double>(
        lattice_[static_cast<std::size_t>((y & (side - 1)) * side + (x & (side - 1)))]);
  }

  std::array<float, side * side> lattice_{};
};

}  // namespace saccade
