#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>

#include "core/camera.h"
#include "core/reserved_vector.h"

namespace saccade {

/// The moving edges near a circle, to fit its motion and place to. Holds a bounded number of edges; does not allocate
/// after construction.
class CircleFit {
 public:
  static constexpr double reach_px = 8.0;  ///< how far outside the circle edges are of use

  CircleFit() { edges_.reserve(max_edges); }

  void clear() { edges_.clear(); }
  /// An edge that was at `at_px` age_s ago and has moved to `now_px`; `along` is the unit vector of its motion. Ignored
  /// once the fit is full.
  void add(const Eigen::Vector2d& now_px, const Eigen::Vector2d& at_px, const Eigen::Vector2d& along,
           double speed_px_s, double age_s) {
    if (edges_.size() < max_edges) edges_.push_back({now_px, at_px, along, speed_px_s, age_s});
  }

  /// Velocity of the centre (x, y) and growth of the radius, px/s: robust least squares on the normal speeds of the
  /// edges on the circle.
  [[nodiscard]] Eigen::Vector3d motion(const Circle& circle) const;
  /// The circle through the edges near `circle` that moves like this: weighted least squares, the radius kept within
  /// [r_min_px, r_max_px]. The circle itself where fewer than five edges are near.
  [[nodiscard]] Circle place(Circle circle, const Eigen::Vector3d& motion_px_s, double r_min_px,
                             double r_max_px) const;

 private:
  static constexpr std::size_t max_edges = 512;
  struct Sample {
    Eigen::Vector2d now_px, at_px, along;
    double speed_px_s, age_s;
  };
  ReservedVector<Sample> edges_;
};

}  // namespace saccade
