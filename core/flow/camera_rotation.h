#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "core/camera.h"

namespace saccade {

/// An edge with its normal flow: pixel, unit vector along its motion, speed along that.
struct FlowSample {
  std::uint16_t x = 0, y = 0;
  Eigen::Vector2d along;
  double speed_px_s = 0.0;
};

/// The rotation of the camera, rad/s in its own frame, that explains the motion of most edges, fitted to the normal
/// flows by iteratively reweighted least squares from `start`. Zero where less than half of the edges agree with it, or
/// those that do lie in a part of the image alone: then something moves before a camera at rest. `rays` holds the ray of
/// each pixel (Camera::ray), row by row.
[[nodiscard]] Eigen::Vector3d camera_rotation(std::span<const FlowSample> flows, const Camera& camera,
                                              std::span<const Eigen::Vector3d> rays,
                                              const Eigen::Vector3d& start);

}  // namespace saccade
