#include "control/median_gate.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace saccade {
namespace {

struct Spread {
  double median;
  double deviation;
};

/// Upper median and standard deviation; leaves the values in another order.
Spread spread(std::span<double> values) {
  const auto count = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / count;
  double squares = 0.0;
  for (const double value : values) squares += (value - mean) * (value - mean);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return {*middle, std::sqrt(squares / count)};
}

}  // namespace

void describe(FieldVisitor& v, MedianGateConfig& config) {
  v.real("window_s", config.window_s, {0.01, 2.0}, "age up to which detections count");
  v.integer("min_detections", config.min_detections, {1, 2000}, "least number of detections in the window");
  v.real("max_spread_px", config.max_spread_px, {0.1, 1e3},
         "largest standard deviation of x and of y in the window");
  v.real("max_radius_px", config.max_radius_px, {1.0, 1e3}, "upper bound of the radius that gives the depth");
  v.real("max_target_x_m", config.max_target_x_m, {-10.0, 0.0},
         "largest x of a target, root frame (x points backward); nearer targets are moved there");
}

MedianGate::MedianGate(const MedianGateConfig& config, const TargetConfig& target)
    : LocatingGate(target), config_(config), window_us_(std::llround(config.window_s * 1e6)) {
  check_config("gaze.authors_gate", config);
}

std::optional<Eigen::Vector3d> MedianGate::update(std::int64_t now_us, const Estimate& estimate,
                                                  double threshold, const Camera& camera,
                                                  const Eigen::Isometry3d& root_from_cam) {
  while (size_ > 0 && now_us - at(0).t_us >= window_us_) drop_oldest();
  if (!is_detection(estimate, threshold) || estimate.held) return std::nullopt;
  const Circle& c = estimate.circle;
  if (!std::isfinite(c.x_px) || !std::isfinite(c.y_px) || !std::isfinite(c.r_px)) {
    count(TargetStatus::not_finite);
    return std::nullopt;
  }
  const Eigen::Vector3d ray = camera.ray(c.x_px, c.y_px);
  if (!ray.allFinite()) {
    count(TargetStatus::not_finite);
    return std::nullopt;
  }
  if (size_ == capacity) drop_oldest();
  ring_[(first_ + size_++) % capacity] = {now_us, root_from_cam.linear() * ray, c.r_px};
  if (size_ < static_cast<std::size_t>(config_.min_detections)) return std::nullopt;

  const Eigen::Matrix3d cam_from_root = root_from_cam.linear().transpose();
  double r_px = 0.0;
  std::size_t seen = 0;
  for (std::size_t i = 0; i < size_; ++i) {
    const auto at_px = camera.project(cam_from_root * at(i).ray);
    if (!at_px) continue;
    x_px_[seen] = at_px->x();
    y_px_[seen++] = at_px->y();
    r_px = std::max(r_px, at(i).r_px);
  }
  if (seen < static_cast<std::size_t>(config_.min_detections)) return std::nullopt;
  const Spread x = spread(std::span(x_px_).first(seen));
  const Spread y = spread(std::span(y_px_).first(seen));
  if (!(x.deviation < config_.max_spread_px) || !(y.deviation < config_.max_spread_px)) return std::nullopt;
  if (std::abs(c.x_px - x.median) > x.deviation || std::abs(c.y_px - y.median) > y.deviation) {
    return std::nullopt;
  }
  std::optional<Eigen::Vector3d> target =
      locate({x.median, y.median, std::min(r_px, config_.max_radius_px)}, camera, root_from_cam);
  if (target) target->x() = std::min(target->x(), config_.max_target_x_m);
  return target;
}

void MedianGate::drop_oldest() {
  first_ = (first_ + 1) % capacity;
  --size_;
}

}  // namespace saccade
