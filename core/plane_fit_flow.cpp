#include "core/plane_fit_flow.h"

#include <array>
#include <cmath>
#include <limits>

namespace saccade {
namespace {

constexpr int max_half_width = 5;
constexpr std::size_t max_points = (2 * max_half_width + 1) * (2 * max_half_width + 1);
constexpr std::int64_t never_us = std::numeric_limits<std::int64_t>::min() / 2;
constexpr int refits = 2;

struct Point {
  int dx, dy, dt;  // from the event; dt <= 0, us
};

/// Sums of a least squares fit of dt = a dx + b dy + d, exact in integers.
struct PlaneSums {
  std::int64_t n = 0, x = 0, y = 0, t = 0, xx = 0, xy = 0, yy = 0, xt = 0, yt = 0;

  void add(const Point& p) {
    ++n;
    x += p.dx;
    y += p.dy;
    t += p.dt;
    xx += p.dx * p.dx;
    xy += p.dx * p.dy;
    yy += p.dy * p.dy;
    xt += static_cast<std::int64_t>(p.dx) * p.dt;
    yt += static_cast<std::int64_t>(p.dy) * p.dt;
  }

  struct Plane {
    double a, b, d;
  };
  [[nodiscard]] std::optional<Plane> solve() const {
    // Normal equations with the means removed, times n: integers throughout.
    const std::int64_t cxx = n * xx - x * x;
    const std::int64_t cxy = n * xy - x * y;
    const std::int64_t cyy = n * yy - y * y;
    const std::int64_t det = cxx * cyy - cxy * cxy;
    if (det <= 0) return std::nullopt;  // the points lie on one line
    const std::int64_t cxt = n * xt - x * t;
    const std::int64_t cyt = n * yt - y * t;
    const double scale = 1.0 / static_cast<double>(det);
    const double a = static_cast<double>(cyy * cxt - cxy * cyt) * scale;
    const double b = static_cast<double>(cxx * cyt - cxy * cxt) * scale;
    const double d = (static_cast<double>(t) - a * static_cast<double>(x) - b * static_cast<double>(y)) /
                     static_cast<double>(n);
    return Plane{a, b, d};
  }
};

}  // namespace

void describe(FieldVisitor& v, PlaneFitFlowConfig& config) {
  v.integer("half_width_px", config.half_width_px, {1, max_half_width}, "neighbourhood of 2 n + 1 pixels");
  v.integer("max_age_us", config.max_age_us, {100, 1e6}, "oldest neighbour that counts");
  v.integer("min_inliers", config.min_inliers, {3, max_points}, "neighbours that must lie on the plane");
  v.real("inlier_px", config.inlier_px, {0.05, 10.0}, "distance from the plane, along the flow");
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
  const std::int64_t oldest = event.t_us - config_.max_age_us;
  const std::int64_t* centre = surface_.data() + index(event);
  std::array<Point, max_points> points;
  std::size_t count = 0;
  PlaneSums sums;
  for (int dy = -half; dy <= half; ++dy) {
    const std::int64_t* row = centre + dy * static_cast<std::ptrdiff_t>(stride_);
    for (int dx = -half; dx <= half; ++dx) {
      if (row[dx] < oldest) continue;
      points[count] = {dx, dy, static_cast<int>(row[dx] - event.t_us)};
      sums.add(points[count++]);
    }
  }
  for (int fit = 0;; ++fit) {
    if (sums.n < config_.min_inliers) return std::nullopt;
    const auto plane = sums.solve();
    if (!plane) return std::nullopt;
    const double slope = std::sqrt(plane->a * plane->a + plane->b * plane->b);
    if (!(slope > 0.0)) return std::nullopt;
    if (fit == refits) return NormalFlow{plane->a, plane->b};
    const double tolerance = config_.inlier_px * slope;
    PlaneSums inliers;
    for (std::size_t i = 0; i < count; ++i) {
      const Point& p = points[i];
      if (std::abs(plane->a * p.dx + plane->b * p.dy + plane->d - p.dt) <= tolerance) inliers.add(p);
    }
    sums = inliers;
  }
}

}  // namespace saccade
