#pragma once

#include <cmath>

namespace saccade {

/// The transfer function of sRGB (IEC 61966-2-1), from linear light in [0, 1] to the encoded value in [0, 1].
inline double srgb_from_linear(double linear) {
  return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

/// Its inverse, from an encoded value in [0, 1] to linear light in [0, 1].
inline double linear_from_srgb(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

}  // namespace saccade
