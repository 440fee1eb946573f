#include "control/image_rotation.h"

#include <algorithm>
#include <cmath>

#include "core/time_stamp.h"

namespace saccade {

ImageRotation::ImageRotation(const Camera& camera)
    : camera_(camera), flow_({.max_age_us = 400'000}, camera.size) {
  rays_.reserve(static_cast<std::size_t>(camera.size.width) * static_cast<std::size_t>(camera.size.height));
  for (int y = 0; y < camera.size.height; ++y) {
    for (int x = 0; x < camera.size.width; ++x) rays_.push_back(camera.ray(x, y));
  }
  used_.reserve(most_flows);
}

void ImageRotation::process(std::span<const Event> events) {
  const std::size_t stride = events.size() / flows_per_call + 1;
  std::size_t i = 0;
  for (const Event& event : events) {
    if (!camera_.size.contains(event.x, event.y)) continue;
    flow_.add(event);
    if (i++ % stride != 0) continue;
    const std::optional<NormalFlow> found = flow_.at(event);
    if (!found) continue;
    const Eigen::Vector2d slope(found->dt_dx_us_px, found->dt_dy_us_px);
    const double us_per_px = slope.norm();
    const bool has_ray =
        rays_[static_cast<std::size_t>(event.y) * static_cast<std::size_t>(camera_.size.width) +
              static_cast<std::size_t>(event.x)]
            .allFinite();
    if (!(us_per_px > 0.0) || !has_ray) continue;
    recent_[count_++ % most_flows] = {event.t_us, {event.x, event.y, slope / us_per_px, 1e6 / us_per_px}};
  }
}

std::optional<Eigen::Vector3d> ImageRotation::advance_to(std::int64_t now_us) {
  if (now_us < next_us_) return std::nullopt;
  next_us_ = saturated_sum(now_us, period_us);
  used_.clear();
  for (std::size_t back = 1; back <= std::min(count_, most_flows); ++back) {
    const TimedFlow& timed = recent_[(count_ - back) % most_flows];
    if (saturated_difference(now_us, timed.t_us) >= window_us) break;
    used_.push_back(timed.flow);
  }
  if (used_.size() < fewest_flows) {
    rotation_rad_s_.setZero();
    return std::nullopt;
  }
  rotation_rad_s_ = camera_rotation(used_, camera_, rays_, rotation_rad_s_);
  return rotation_rad_s_;
}

}  // namespace saccade
