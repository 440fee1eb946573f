#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "core/camera.h"

namespace saccade {

/// The silhouette of one tracked circle: the region almost without events that an object leaves in the events of the
/// background while the gaze follows it. Fits the circle of maximum likelihood to the events near the tracked one.
///
/// Around the circle events are taken for Poisson distributed in the plane, with one density inside and one for each
/// sector outside; sectors where as little happens outside as inside (the hand that holds the ball) say nothing. The
/// circle is the one of maximum likelihood.
class Silhouette {
 public:
  void clear() { count_ = 0; }

  /// An event at `at_px`; `carried_px` is how far the circle has been carried up to then (CircleTrack::carried_px).
  void add(const Eigen::Vector2d& at_px, const Eigen::Vector2d& carried_px, std::int64_t t_us) {
    near_[count_++ % near_.size()] = {at_px - carried_px, t_us};
  }

  struct Fit {
    Circle circle;
    Eigen::Vector3d sd_px = Eigen::Vector3d::Zero();  ///< of x, y, r; from the curvature of the likelihood
    double seen = 0.0;                                ///< 0 to 1: share of the sectors that tell
    double emptiness = 0.0;                           ///< 0 to 1: 1 less the density inside over that outside
    double tightness = 0.0;  ///< 0 to 1: how dense events are just outside, against further out
  };
  /// None where too little happens around the circle.
  [[nodiscard]] std::optional<Fit> fit(const Circle& circle, const Eigen::Vector2d& carried_px,
                                       std::int64_t now_us) const;

 private:
  struct Near {
    Eigen::Vector2d at_px{};  ///< less what the circle had been carried
    std::int64_t t_us = 0;
  };
  std::array<Near, 512> near_{};
  std::size_t count_ = 0;
};

}  // namespace saccade
