#include "core/flow/plane_fit_flow.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/time_stamp.h"

namespace saccade {
namespace {

constexpr int max_half_width = 5;   // of the key half_width_px: bounds memory and work
constexpr std::size_t max_points =  // of that neighbourhood
    (2 * max_half_width + 1) * (2 * max_half_width + 1);
constexpr std::int64_t never_us = std::numeric_limits<std::int64_t>::min();  // a pixel without an event
constexpr std::int64_t own_edge_px =
    4;  // an edge passes four of eight neighbours in the time of one pixel (header)

/// Neighbours of an event, whole numbers from it: pixels, and us <= 0. Arrays and masks, so that nothing
/// branches on the data and loops vectorise.
struct Neighbours {
  int count = 0;
  std::array<std::int32_t, max_points> x, y, t;
  std::array<std::int32_t, max_points> taken;  ///< all bits or none
};

struct Plane {
  double a, b, d;
};

/// Least squares fit of t = a x + b y + d to the neighbours that are taken; none where they are fewer than
/// `min_points` or lie on one line. All sums are exact: |x|, |y| <= 5, |t| <= 1e6, at most 121 points.
std::optional<Plane> fit_plane(const Neighbours& p, std::int64_t min_points) {
  std::int32_t n = 0, x = 0, y = 0, t = 0, xx = 0, xy = 0, yy = 0, xt = 0, yt = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(p.count); ++i) {
    const std::int32_t px = p.x[i] & p.taken[i];
    const std::int32_t py = p.y[i] & p.taken[i];
    n -= p.taken[i];
    x += px;
    y += py;
    t += p.t[i] & p.taken[i];
    xx += px * px;
    xy += px * py;
    yy += py * py;
    xt += px * p.t[i];
    yt += py * p.t[i];
  }
  if (n < min_points) return std::nullopt;
  // Normal equations with the means removed, times n: integers throughout.
  const auto centred = [n](std::int64_t sum_uv, std::int64_t sum_u, std::int64_t sum_v) {
    return n * sum_uv - sum_u * sum_v;
  };
  const std::int64_t cxx = centred(xx, x, x);
  const std::int64_t cxy = centred(xy, x, y);
  const std::int64_t cyy = centred(yy, y, y);
  const std::int64_t det = cxx * cyy - cxy * cxy;
  if (det <= 0) return std::nullopt;
  const std::int64_t cxt = centred(xt, x, t);
  const std::int64_t cyt = centred(yt, y, t);
  const double scale = 1.0 / static_cast<double>(det);
  const double a = static_cast<double>(cyy * cxt - cxy * cyt) * scale;
  const double b = static_cast<double>(cxx * cyt - cxy * cxt) * scale;
  return Plane{a, b, (t - a * x - b * y) / n};
}

/// The fourth newest stamp of the eight pixels around one: two sorted halves, merged as far as that.
std::int64_t fourth_newest_around(const std::int64_t* centre, std::ptrdiff_t stride) {
  const std::int64_t* above = centre - stride;
  const std::int64_t* below = centre + stride;
  std::array<std::int64_t, 8> t{above[-1], above[0],  above[1], centre[-1],
                                centre[1], below[-1], below[0], below[1]};
  const auto newer_first = [&t](std::size_t i, std::size_t j) {
    const std::int64_t newer = std::max(t[i], t[j]);
    t[j] = std::min(t[i], t[j]);
    t[i] = newer;
  };
  for (std::size_t half = 0; half < t.size(); half += t.size() / 2) {
    newer_first(half, half + 1);
    newer_first(half + 2, half + 3);
    newer_first(half, half + 2);
    newer_first(half + 1, half + 3);
    newer_first(half + 1, half + 2);
  }
  return std::max({t[3], std::min(t[2], t[4]), std::min(t[1], t[5]), std::min(t[0], t[6]), t[7]});
}

void leave_out_far(Neighbours& p, const Plane& plane, double px) {
  const double tolerance = px * px * (plane.a * plane.a + plane.b * plane.b);
  for (std::size_t i = 0; i < static_cast<std::size_t>(p.count); ++i) {
    const double off = plane.a * p.x[i] + plane.b * p.y[i] + plane.d - p.t[i];
    p.taken[i] = off * off <= tolerance ? -1 : 0;
  }
}

}  // namespace

void describe(FieldVisitor& v, PlaneFitFlowConfig& config) {
  v.integer("half_width_px", config.half_width_px, {1, max_half_width}, "neighbourhood of 2 n + 1 pixels");
  v.integer("max_age_us", config.max_age_us, {100, 1e6}, "largest age of a neighbour that counts");
  v.integer("min_inliers", config.min_inliers, {3, max_points}, "least number of neighbours on the plane");
  v.real("inlier_px", config.inlier_px, {0.05, 10.0},
         "largest distance of an inlier from the plane, along the flow");
}

PlaneFitFlow::PlaneFitFlow(const PlaneFitFlowConfig& config, ImageSize size)
    : config_(config),
      border_(static_cast<std::size_t>(config.half_width_px)),
      stride_(static_cast<std::size_t>(size.width) + 2 * border_),
      plane_size_(stride_ * (static_cast<std::size_t>(size.height) + 2 * border_)) {
  check_config("flow", config);
  surface_.assign(2 * plane_size_, never_us);
}

std::optional<NormalFlow> PlaneFitFlow::at(const Event& event) const {
  const int half = static_cast<int>(config_.half_width_px);
  const std::int64_t* centre = surface_.data() + index(event);
  const std::int64_t next_age_us =
      saturated_difference(event.t_us, fourth_newest_around(centre, static_cast<std::ptrdiff_t>(stride_)));
  const std::int64_t span_us =
      std::min(config_.max_age_us, own_edge_px * std::min(config_.max_age_us, next_age_us));
  const std::int64_t oldest = std::max(saturated_difference(event.t_us, span_us), never_us + 1);
  Neighbours near;
  for (int dy = -half; dy <= half; ++dy) {
    const std::int64_t* row = centre + dy * static_cast<std::ptrdiff_t>(stride_);
    for (int dx = -half; dx <= half; ++dx) {
      const auto i = static_cast<std::size_t>(near.count);
      near.x[i] = dx;
      near.y[i] = dy;
      // Modulo 2^32, which is exact for the neighbours that count; the others are overwritten.
      near.t[i] = static_cast<std::int32_t>(static_cast<std::uint64_t>(row[dx]) -
                                            static_cast<std::uint64_t>(event.t_us));
      near.taken[i] = -1;
      near.count += row[dx] >= oldest ? 1 : 0;
    }
  }
  const auto first = fit_plane(near, config_.min_inliers);
  if (!first) return std::nullopt;
  leave_out_far(near, *first, config_.inlier_px);
  const auto plane = fit_plane(near, config_.min_inliers);
  if (!plane || (plane->a == 0.0 && plane->b == 0.0)) return std::nullopt;
  return NormalFlow{plane->a, plane->b};
}

}  // namespace saccade
