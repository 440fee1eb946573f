#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "core/camera.h"

namespace saccade {

/// What the moving edges near a circle show of a disc there, as figures without time in them: speeds appear as ratios
/// and consistency, so that the same scene at half the speed shows the same. "Radial" edges move within 30 deg of the
/// circle's normal; the ring is within 1.25 px of the circle, the sides from 2 to 5 px inside and outside of it. Sectors
/// are 2.5 px long, 8 to 32 of them. Densities are edges per px^2.
enum class Evidence : std::size_t {
  closure,            ///< share of the sectors with a radial edge on the ring
  expected_closure,   ///< share of the sectors that the motion must show, that have an edge of that motion
  gap,                ///< longest run of sectors without an edge, share of all
  radial_share,       ///< of the edges on the ring
  consistent_share,   ///< of the radial edges on the ring: move as the circle does
  ring_to_sides,      ///< log of the density of radial edges on the ring over that of the sides
  spread_px2,         ///< mean squared distance of the radial edges within 2.5 px of the circle
  background_inside,  ///< log density inside of edges that move as the background and not as the disc
  inside,             ///< log density inside
  outside,            ///< log density of the outer side
  inside_to_outside,  ///< log of the ratio of the two
  ring_per_length,    ///< log of radial edges on the ring per px of it
  radius,             ///< log radius
  expected,           ///< share of the sectors that the motion must show
  closure_squared,
  closure_by_contrast,  ///< closure times the ring's share of the radial density
  radial_outside,       ///< log density of radial edges, outer side
  radial_inside,        ///< the same, inner side
  count
};
inline constexpr std::size_t evidence_count = static_cast<std::size_t>(Evidence::count);

/// The density, edges per px^2, of a figure that is the logarithm of one: log(1 + 20 density).
[[nodiscard]] double density_of(double log_density);

class DiscEvidence {
 public:
  [[nodiscard]] double operator[](Evidence e) const { return values_[static_cast<std::size_t>(e)]; }
  [[nodiscard]] double& operator[](Evidence e) { return values_[static_cast<std::size_t>(e)]; }
  [[nodiscard]] const std::array<double, evidence_count>& values() const { return values_; }
  /// Moves towards newer evidence by `share` in [0, 1].
  void blend(const DiscEvidence& newer, double share) {
    for (std::size_t i = 0; i < evidence_count; ++i) values_[i] += share * (newer.values_[i] - values_[i]);
  }

 private:
  std::array<double, evidence_count> values_{};
};

/// Collects the edges near one circle and computes its evidence.
class DiscEvidenceCollector {
 public:
  static constexpr double reach_px = 5.0;  ///< how far outside the circle edges count

  /// `motion_px_s`: velocity of the centre (x, y) and growth of the radius. `background_px_s`: image velocity of the
  /// background at the circle.
  DiscEvidenceCollector(const Circle& circle, const Eigen::Vector3d& motion_px_s,
                        const Eigen::Vector2d& background_px_s);
  /// An edge at `offset_px` from the centre, moved to now as a part of the disc; `along` is the unit vector of its motion.
  void add(const Eigen::Vector2d& offset_px, const Eigen::Vector2d& along, double speed_px_s);
  [[nodiscard]] DiscEvidence evidence() const;

 private:
  Circle circle_;
  Eigen::Vector2d velocity_px_s_, background_px_s_;
  double growth_px_s_;
  int sectors_;
  std::uint32_t seen_ = 0, seen_consistent_ = 0, expected_ = 0;  // bits of sectors
  double ring_ = 0.0, ring_radial_ = 0.0, ring_consistent_ = 0.0;
  double side_inner_radial_ = 0.0, side_outer_ = 0.0, side_outer_radial_ = 0.0;
  double inside_ = 0.0, inside_background_ = 0.0;
  double near_count_ = 0.0, near_off2_px2_ = 0.0;
};

}  // namespace saccade
