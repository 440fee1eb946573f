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

/// How often an eye's image is drawn: as often as what it sees moves.
struct SamplingConfig {
  double max_displacement_px = 0.5;  ///< of anything seen, from one image to the next
  double max_interval_ms = 5.0;      ///< from one image to the next; events come late by at most this
  double min_interval_ms = 0.02;     ///< whatever moves; what may be drawn in real time
};

/// Keys: max_displacement_px, max_interval_ms, min_interval_ms.
void describe(FieldVisitor& v, SamplingConfig& config);

/// How far things move in an eye's image between two states of the world: the largest displacement of
/// - a grid of 5 x 5 rays over the image, corners included, at the nearest and the farthest distance at which
///   the room stands, carried by the motion of the eye;
/// - the ends and sides of every geom that an eye draws and that is not part of the room, as far as they are in
///   the image or within 4 px of it, carried by their own motion and the eye's.
class ImageMotion {
 public:
  /// Nothing of the room (geoms of the world body) is nearer to an eye than this.
  static constexpr double nearest_room_m = 0.5;
  static constexpr double farthest_room_m = 6.0;

  ImageMotion(const mjModel& model, int camera_id, const Camera& camera);

  /// Measures from this state on. Positions of cameras and geoms are up to date in `data`.
  void start_from(const mjData& data);
  /// From there to the state of `data`, px.
  [[nodiscard]] double displacement_px(const mjData& data) const;

 private:
  struct MovingPoint {
    int geom;
    Eigen::Vector3d offset_m;  ///< from the geom's origin, along its axes
  };
  [[nodiscard]] std::optional<Eigen::Vector2d> place_of(const MovingPoint& point, const mjData& data,
                                                        const Eigen::Isometry3d& camera_from_root) const;
  [[nodiscard]] bool is_seen(const Eigen::Vector2d& at_px) const;

  int camera_id_;
  Camera camera_;
  std::vector<Eigen::Vector2d> grid_px_;
  std::vector<Eigen::Vector3d> grid_rays_;  // unit length, camera frame
  std::vector<Eigen::Vector3d> grid_m_;     // near and far point of each ray at the start, root frame
  std::vector<MovingPoint> moving_;
  std::vector<std::optional<Eigen::Vector2d>> moving_px_;  // at the start
};

/// Chooses the instants of an eye's images, tick by tick of the world: whole microseconds, as late as the bound on
/// motion allows (but not sooner than min_interval_ms after the last image), and the end of a tick where the last image would
/// be older than max_interval_ms by the end of the next one; within a tick where that is shorter than a tick.
/// Motion that is left at the end of a tick counts on in the next.
class ImageSampler {
 public:
  /// Shows the world at an instant of the tick, its ends included; the state is good until the next call.
  using Show = std::function<const mjData&(std::int64_t t_us)>;

  /// Throws InputError for a config out of range.
  ImageSampler(const SamplingConfig& config, ImageMotion motion);

  /// An image is drawn at t_us.
  void take(std::int64_t t_us, const mjData& data);
  /// The next instant in [begin_us, end_us], a tick of the world, at which an image is due; none in the rest of
  /// the tick. After the first image; ask again when the image is taken, until none is due.
  [[nodiscard]] std::optional<std::int64_t> next(std::int64_t begin_us, std::int64_t end_us,
                                                 const Show& show);

 private:
  SamplingConfig config_;
  std::int64_t max_interval_us_;
  std::int64_t min_interval_us_;
  ImageMotion motion_;
  std::int64_t last_us_ = 0;  // the newest image
  double moved_px_ = 0.0;     // since then, at the end of the last tick or at the image itself
};

}  // namespace saccade
