#include "sim/image_sampler.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/world.h"

namespace saccade {
namespace {

constexpr int grid_side = 5;
constexpr double margin_px = 4.0;
constexpr double kept_share = 0.98;    // of the bound: parts between the points move a little more
constexpr double close_share = 0.998;  // of the way to the bound, so that rounding does not exceed it
constexpr int drawn_groups = 2;        // as EyeRenderer draws

/// Half the extent of a geom along its axes.
Eigen::Vector3d half_extent_m(const mjModel& model, int geom) {
  const mjtNum* size = model.geom_size + 3 * geom;
  switch (model.geom_type[geom]) {
    case mjGEOM_SPHERE:
      return Eigen::Vector3d::Constant(size[0]);
    case mjGEOM_CAPSULE:
      return {size[0], size[0], size[0] + size[1]};
    case mjGEOM_CYLINDER:
      return {size[0], size[0], size[1]};
    case mjGEOM_ELLIPSOID:
    case mjGEOM_BOX:
      return {size[0], size[1], size[2]};
    default:
      return Eigen::Vector3d::Constant(model.geom_rbound[geom]);
  }
}

}  // namespace

void describe(FieldVisitor& v, SamplingConfig& c) {
  v.real("max_displacement_px", c.max_displacement_px, {0.05, 10.0},
         "largest motion in the image between two images");
  v.real("max_interval_ms", c.max_interval_ms, {0.05, 5.0}, "longest interval between images");
  v.real("min_interval_ms", c.min_interval_ms, {0.02, 5.0}, "shortest interval between images");
  v.require(c.min_interval_ms <= c.max_interval_ms, "min_interval_ms", text_of(c.min_interval_ms),
            "at most max_interval_ms");
}

ImageMotion::ImageMotion(const mjModel& model, int camera_id, const Camera& camera)
    : camera_id_(camera_id), camera_(camera) {
  for (int row = 0; row < grid_side; ++row) {
    for (int column = 0; column < grid_side; ++column) {
      grid_px_.emplace_back(camera.size.width * column / (grid_side - 1.0) - 0.5,
                            camera.size.height * row / (grid_side - 1.0) - 0.5);
      grid_rays_.push_back(camera.ray(grid_px_.back().x(), grid_px_.back().y()).normalized());
    }
  }
  grid_m_.resize(2 * grid_rays_.size());
  for (int geom = 0; geom < model.ngeom; ++geom) {
    if (model.geom_group[geom] >= drawn_groups || model.geom_bodyid[geom] == 0) continue;
    const Eigen::Vector3d half_m = half_extent_m(model, geom);
    for (int axis = 0; axis < 3; ++axis) {
      for (const double side : {-1.0, 1.0}) {
        moving_.push_back({geom, side * half_m[axis] * Eigen::Vector3d::Unit(axis)});
      }
    }
  }
  moving_px_.resize(moving_.size());
}

bool ImageMotion::is_near_image(const Eigen::Vector2d& at_px) const {
  return at_px.x() > -margin_px && at_px.y() > -margin_px && at_px.x() < camera_.size.width + margin_px &&
         at_px.y() < camera_.size.height + margin_px;
}

std::optional<Eigen::Vector2d> ImageMotion::pixel_of(const MovingPoint& point, const mjData& data,
                                                     const Eigen::Isometry3d& camera_from_root) const {
  using Rotation = Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>;
  const Eigen::Map<const Eigen::Vector3d> origin(data.geom_xpos + 3 * point.geom);
  const Eigen::Map<const Rotation> axes(data.geom_xmat + 9 * point.geom);
  return camera_.project(camera_from_root * (origin + axes * point.offset_m));
}

void ImageMotion::start_from(const mjData& data) {
  const Eigen::Isometry3d root_from_camera = World::root_from_camera(data, camera_id_);
  for (std::size_t i = 0; i < grid_rays_.size(); ++i) {
    grid_m_[2 * i] = root_from_camera * (nearest_room_m * grid_rays_[i]);
    grid_m_[2 * i + 1] = root_from_camera * (farthest_room_m * grid_rays_[i]);
  }
  const Eigen::Isometry3d camera_from_root = root_from_camera.inverse();
  for (std::size_t i = 0; i < moving_.size(); ++i) {
    moving_px_[i] = pixel_of(moving_[i], data, camera_from_root);
  }
}

double ImageMotion::displacement_px(const mjData& data) const {
  const Eigen::Isometry3d camera_from_root = World::root_from_camera(data, camera_id_).inverse();
  double largest2 = 0.0;
  for (std::size_t i = 0; i < grid_m_.size(); ++i) {
    const auto now_px = camera_.project(camera_from_root * grid_m_[i]);
    if (now_px) largest2 = std::max(largest2, (*now_px - grid_px_[i / 2]).squaredNorm());
  }
  for (std::size_t i = 0; i < moving_.size(); ++i) {
    const auto now_px = pixel_of(moving_[i], data, camera_from_root);
    if (!now_px || !moving_px_[i] || !(is_near_image(*now_px) || is_near_image(*moving_px_[i]))) continue;
    largest2 = std::max(largest2, (*now_px - *moving_px_[i]).squaredNorm());
  }
  return std::sqrt(largest2);
}

ImageSampler::ImageSampler(const SamplingConfig& config, ImageMotion motion)
    : config_(config),
      max_interval_us_(std::llround(config.max_interval_ms * 1e3)),
      min_interval_us_(std::llround(config.min_interval_ms * 1e3)),
      motion_(std::move(motion)) {
  check_config("render", config);
}

void ImageSampler::take(std::int64_t t_us, const mjData& data) {
  last_us_ = t_us;
  moved_px_ = 0.0;
  motion_.start_from(data);
}

std::optional<std::int64_t> ImageSampler::next(std::int64_t begin_us, std::int64_t end_us, const Show& show) {
  if (last_us_ == end_us) return std::nullopt;
  const double bound_px = kept_share * config_.max_displacement_px;
  const std::int64_t tick_us = end_us - begin_us;
  const std::int64_t longest_us =
      held_us_ > 0 ? std::max(max_interval_us_, held_us_ + tick_us) : max_interval_us_;
  const std::int64_t earliest_us = std::max(begin_us, last_us_);
  const std::int64_t soonest_us = std::max(begin_us, last_us_ + std::max(min_interval_us_, held_us_));
  // The tick can begin later than that where images were held back until now.
  const std::int64_t latest_us = std::clamp(last_us_ + longest_us, begin_us, end_us);
  const double latest_px = motion_.displacement_px(show(latest_us));
  if (latest_px > bound_px && latest_us > soonest_us) {
    // Between an instant within the bound and one beyond it. In a tick motion is nearly even.
    if (moved_px_ >= bound_px) return soonest_us;
    std::int64_t t_us = latest_us;
    for (double px = latest_px; px > bound_px && t_us > soonest_us;) {
      const double share = close_share * (bound_px - moved_px_) / (px - moved_px_);
      const auto guess_us = static_cast<std::int64_t>(share * static_cast<double>(t_us - earliest_us));
      t_us = std::max(soonest_us, std::min(earliest_us + guess_us, t_us - 1));
      px = motion_.displacement_px(show(t_us));
    }
    return t_us;
  }
  const bool young_enough = end_us + tick_us - last_us_ <= longest_us;
  if (latest_us < end_us || !young_enough) return latest_us;
  moved_px_ = latest_px;
  return std::nullopt;
}

}  // namespace saccade
