#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "core/config.h"

namespace saccade {

/// Limits on the intervals between the images of an eye, which follow the motion in the image.
struct SamplingConfig {
  double max_displacement_px = 0.25;  ///< largest motion in the image from one image to the next
  double max_interval_ms = 5.0;       ///< longest interval between images; the largest delay of events
  double min_interval_ms = 0.02;      ///< shortest interval, also for fast motion
};

/// Keys: max_displacement_px, max_interval_ms, min_interval_ms.
void describe(FieldVisitor& v, SamplingConfig& config);

/// Measures the motion in an eye's image between two states of the world, as the largest displacement of
/// - a grid of 5 x 5 rays over the image, corners included, at the smallest and the largest distance of the room, moved
///   by the motion of the eye;
/// - the ends and sides of every geom that an eye draws and that is not part of the room, if they are in the image or
///   within 4 px of it, moved by their own motion and the eye's.
class ImageMotion {
 public:
  // Distances of the room (geoms of the world body) from an eye.
  static constexpr double nearest_room_m = 0.5;
  static constexpr double farthest_room_m = 6.0;

  ImageMotion(const mjModel& model, int camera_id, const Camera& camera);

  /// Sets the first state. Poses of cameras and geoms are up to date in `data`.
  void start_from(const mjData& data);
  /// Motion from the first state to that of `data`, px.
  [[nodiscard]] double displacement_px(const mjData& data) const;

 private:
  struct MovingPoint {
    int geom;
    Eigen::Vector3d offset_m;  ///< from the geom's origin, along its axes
  };
  [[nodiscard]] std::optional<Eigen::Vector2d> pixel_of(const MovingPoint& point, const mjData& data,
                                                        const Eigen::Isometry3d& camera_from_root) const;
  [[nodiscard]] bool is_near_image(const Eigen::Vector2d& at_px) const;

  int camera_id_;
  Camera camera_;
  std::vector<Eigen::Vector2d> grid_px_;
  std::vector<Eigen::Vector3d> grid_rays_;  // unit length, camera frame
  std::vector<Eigen::Vector3d> grid_m_;     // near and far point of each ray at the start, root frame
  std::vector<MovingPoint> moving_;
  std::vector<std::optional<Eigen::Vector2d>> moving_px_;  // at the start
};

/// Chooses the instants of an eye's images, in each tick of the world: whole microseconds, as late as the bound on motion
/// permits, but at least min_interval_ms after the previous image. The end of a tick is chosen if the newest image would
/// otherwise be older than max_interval_ms at the end of the next tick. Motion since the newest image accumulates from
/// tick to tick.
class ImageSampler {
 public:
  /// Returns the state of the world at an instant of the tick, ends included; valid until the next call.
  using Show = std::function<const mjData&(std::int64_t t_us)>;

  /// Throws InputError for a config out of range.
  ImageSampler(const SamplingConfig& config, ImageMotion motion);

  /// From now on images come at least least_us after each other, whatever moves, and at most a tick later than that if it is
  /// more than max_interval_ms. 0: as configured.
  void hold_back(std::int64_t least_us) { held_us_ = least_us; }
  /// Records that an image is drawn at t_us, with the world in the state of `data`.
  void take(std::int64_t t_us, const mjData& data);
  /// The next instant in [begin_us, end_us], a tick of the world, at which an image is due, or none. Call after the
  /// first image, and again after each take() until none is due.
  [[nodiscard]] std::optional<std::int64_t> next(std::int64_t begin_us, std::int64_t end_us,
                                                 const Show& show);

 private:
  SamplingConfig config_;
  std::int64_t max_interval_us_;
  std::int64_t min_interval_us_;
  std::int64_t held_us_ = 0;
  ImageMotion motion_;
  std::int64_t last_us_ = 0;  // time of the newest image
  double moved_px_ = 0.0;     // since then, at the end of the last tick or at the image itself
};

}  // namespace saccade
