#pragma once

#include <Eigen/Geometry>
#include <span>

#include "sim/keyframe.h"
#include "sim/keyframe_camera.h"
#include "sim/scene_layers.h"

namespace saccade::detail {

/// Bounds the error of an image that is reprojected from a keyframe, in pixels:
///
/// 1. What the keyframe does not show because something of the same layer hid it: the change of parallax between the two
///    sides of the largest step of depth.
/// 2. What it does not show because it was behind the outline of the layer: thickness times the change of the direction of
///    view; for round geoms the outline moves on the surface, by half the square of it.
/// 3. Highlights, which do not move with the surface: thickness times the change of the direction of view, where they are
///    bright enough to be seen.
///
/// Not in pixels are three limits of their own, beyond which the keyframe is not used: shade (a layer that turned, or is
/// seen from elsewhere, has other light), scale, and the border of the keyframe.
class KeyframeRule {
 public:
  /// `camera` outlives it; `rays`: of pixels along the border of the image, at unit depth.
  KeyframeRule(const KeyframeCamera& camera, std::vector<Eigen::Vector3d> rays, double error_px)
      : camera_(&camera), rays_(std::move(rays)), error_px_(error_px) {}

  /// Whether an image with the layer at camera_from_layer may use the keyframe. `middle_m`: the layer's middle in its
  /// own frame; `root_from_layer`: its rotation now.
  [[nodiscard]] bool permits(const Keyframe& keyframe, const SceneLayer& layer,
                             const Eigen::Vector3d& middle_m, const Eigen::Isometry3d& camera_from_layer,
                             const Eigen::Matrix3d& root_from_layer) const;

 private:
  [[nodiscard]] bool shows_border(const Keyframe& keyframe, const Eigen::Isometry3d& key_from_camera) const;

  const KeyframeCamera* camera_;
  std::vector<Eigen::Vector3d> rays_;
  double error_px_;
};

}  // namespace saccade::detail
