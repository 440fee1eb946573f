#include "apps/view/circle_snap.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "core/flow/plane_fit_flow.h"
#include "core/tracker/circle_fit.h"

namespace saccade {
namespace {

constexpr int fits = 3;
constexpr double smallest_r_px = 1.0;

struct FlowEdge {
  std::int64_t away_us = 0;  ///< from the instant, before or after it
  Eigen::Vector2d now_px, at_px, along;
  double speed_px_s = 0.0, age_s = 0.0;
};

/// The edges around an instant, the nearest in time first.
std::vector<FlowEdge> edges_at(std::span<const Event> events, ImageSize image, std::int64_t at_us,
                               std::int64_t reach_us) {
  const PlaneFitFlowConfig config;
  PlaneFitFlow flow(config, image);
  std::vector<FlowEdge> edges;
  auto event = std::ranges::lower_bound(events, at_us - reach_us - config.max_age_us, {}, &Event::t_us);
  for (; event != events.end() && event->t_us <= at_us + reach_us; ++event) {
    if (!image.contains(event->x, event->y)) continue;
    flow.add(*event);
    if (event->t_us < at_us - reach_us) continue;
    const auto slope = flow.at(*event);
    if (!slope) continue;
    const Eigen::Vector2d slowness_us_px(slope->dt_dx_us_px, slope->dt_dy_us_px);
    FlowEdge edge;
    edge.away_us = std::abs(at_us - event->t_us);
    edge.at_px = {static_cast<double>(event->x), static_cast<double>(event->y)};
    edge.along = slowness_us_px.normalized();
    edge.speed_px_s = 1e6 / slowness_us_px.norm();
    edge.age_s = 1e-6 * static_cast<double>(at_us - event->t_us);
    edge.now_px = edge.at_px + edge.along * (edge.speed_px_s * edge.age_s);
    edges.push_back(edge);
  }
  std::ranges::stable_sort(edges, {}, &FlowEdge::away_us);
  return edges;
}

}  // namespace

std::optional<Circle> snapped_circle(std::span<const Event> events, ImageSize image, const Circle& placed,
                                     std::int64_t at_us, std::int64_t reach_us) {
  const std::vector<FlowEdge> edges = edges_at(events, image, at_us, reach_us);
  const double largest_r_px = std::max(image.width, image.height);
  Circle circle = placed;
  for (int i = 0; i < fits; ++i) {
    CircleFit fit;
    for (const FlowEdge& edge : edges) {
      if ((edge.at_px - Eigen::Vector2d(circle.x_px, circle.y_px)).norm() < circle.r_px + CircleFit::reach_px)
        fit.add(edge.now_px, edge.at_px, edge.along, edge.speed_px_s, edge.age_s);
    }
    const Circle last = circle;
    circle = fit.place(circle, fit.motion(circle), smallest_r_px, largest_r_px);
    const bool stays = circle.x_px == last.x_px && circle.y_px == last.y_px && circle.r_px == last.r_px;
    if (stays && i == 0) return std::nullopt;  // too few edges
    if (stays) break;
  }
  return circle;
}

}  // namespace saccade
