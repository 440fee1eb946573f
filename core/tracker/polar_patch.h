#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/camera.h"
#include "core/time_surface.h"

namespace saccade {

/// Image motion at a circle.
struct PatchMotion {
  Eigen::Vector2d disc_px_s = Eigen::Vector2d::Zero();        ///< of its centre
  Eigen::Vector2d background_px_s = Eigen::Vector2d::Zero();  ///< of the background there
  double growth_px_s = 0.0;                                   ///< of its radius
};

/// The newest events near a circle in polar coordinates around its centre: 24 directions, 14 rings from 7 ring widths inside
/// the outline to 6 outside of it. A ring is r^0.75 / 4 px wide: 0.7 px at a radius of 4 px, 4 px at one of 40.
///
/// Each event is counted twice: at the place to which the disc's motion has carried it since, and at the one to which the
/// background's motion has. What moves with the disc is sharp in the first, what stands behind it in the second. An event
/// counts exp(-m / 2 px) and exp(-m / 8 px), m being that motion since the event (at least 4 px/s), up to 16 px. So a scene in
/// slow motion has the same patch. Values are densities, per px^2.
struct PolarPatch {
  static constexpr std::size_t directions = 24, rings = 14;
  /// {ON, OFF} x {disc, background} x {2 px, 8 px}; then the share of the ring that is inside the image, and the disc's and
  /// the background's motion along the normal as shares of the sum of both speeds.
  static constexpr std::size_t event_channels = 8, channels = 11;
  /// Log radius, log of 1 + speed (disc, background, disc against background, growth), density of all events.
  static constexpr std::size_t figures = 6;

  std::array<float, directions * rings * channels> values{};  ///< direction by direction, ring by ring
  std::array<float, figures> about{};
  double ring_px = 0.0;  ///< width of a ring
};

/// Width of a ring around a circle of this radius, px.
[[nodiscard]] inline double polar_ring_px(double r_px) { return 0.25 * std::pow(r_px, 0.75); }

/// Reads no more than 2 x 61 x 61 pixels: of a larger circle only every second or third in each direction.
[[nodiscard]] PolarPatch polar_patch(const TimeSurface& surface, const Circle& circle,
                                     const PatchMotion& motion, std::int64_t now_us);

}  // namespace saccade
