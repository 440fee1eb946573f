#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/config.h"
#include "core/event.h"
#include "core/time_stamp.h"

namespace saccade {

struct PlaneFitFlowConfig {
  std::int64_t half_width_px = 2;     ///< the neighbourhood is a square of 2 n + 1 pixels
  std::int64_t max_age_us = 100'000;  ///< older neighbours do not belong to this edge
  std::int64_t min_inliers = 6;       ///< with fewer, the event has no flow
  double inlier_px = 0.8;             ///< how far, along the flow, a neighbour may lie from the plane
};

/// Keys: half_width_px, max_age_us, min_inliers, inlier_px.
void describe(FieldVisitor& v, PlaneFitFlowConfig& config);

/// Slope of the surface of active events at one event: the inverse of the normal flow.
struct NormalFlow {
  double dt_dx_us_px = 0.0;
  double dt_dy_us_px = 0.0;
};

/// Standard deviation of the speed of a plane-fit flow, px/s: a share of it, and what an image at rest shows. Chosen: a
/// robust scale, which the fits that use it do not depend on closely.
[[nodiscard]] inline double flow_sd_px_s(double speed_px_s) { return 0.3 * std::abs(speed_px_s) + 15.0; }

/// Normal flow by local plane fitting (paper, section II-C; Benosman et al., TNNLS 25(2), 2014): a plane
/// t = a x + b y + d is fitted by least squares to the newest time stamps of one polarity around an event,
/// neighbours that lie further than `inlier_px` from it are left out, and the plane is fitted again. The
/// slope (a, b) points along the edge's motion, with 1 / |(a, b)| the speed.
///
/// Time stamps of earlier edges are excluded from the first fit. An edge has passed at least four of the eight pixels
/// around the event in about the time that it needs for one pixel. So stamps older than four times the age of the fourth
/// newest of these eight belong to earlier edges.
class PlaneFitFlow {
 public:
  PlaneFitFlow(const PlaneFitFlowConfig& config, ImageSize size);

  /// Adds an event to the surface of active events. It lies inside the image.
  void add(const Event& event) { surface_[index(event)] = event.t_us; }
  /// Adds an event unless it follows the last one added at its pixel and polarity within `pause_us`; false then.
  bool add_first(const Event& event, std::int64_t pause_us) {
    std::int64_t& last = surface_[index(event)];
    if (event.t_us < saturated_sum(last, pause_us)) return false;
    last = event.t_us;
    return true;
  }

  /// Loads what an event inside the image changes into the cache, some events before it is added.
  void prefetch(const Event& event) const { __builtin_prefetch(&surface_[index(event)], 1); }

  /// The flow at the event that was added last; none if fewer than `min_inliers` neighbours lie on a plane or the
  /// plane is level.
  [[nodiscard]] std::optional<NormalFlow> at(const Event& event) const;

 private:
  [[nodiscard]] std::size_t index(const Event& e) const {
    return (e.on ? plane_size_ : 0) + (e.y + border_) * stride_ + e.x + border_;
  }

  PlaneFitFlowConfig config_;
  std::size_t border_, stride_, plane_size_;
  std::vector<std::int64_t> surface_;  // 2 polarities x padded rows x padded columns, newest stamp
};

}  // namespace saccade
