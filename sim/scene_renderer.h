#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>

#include "core/event.h"
#include "sim/gl_context.h"
#include "sim/scene_drawer.h"

namespace saccade {

/// The pose of a camera outside the robot: it looks at a point from a distance.
struct SceneView {
  Eigen::Vector3d look_at_m = Eigen::Vector3d(-0.4, 0.0, 0.2);  ///< root frame
  double distance_m = 1.6;
  double azimuth_rad = 0.0;     ///< heading of the view about z; 0 looks along root x (at the robot's face)
  double elevation_rad = -0.3;  ///< of the view: negative looks down
};

/// Head and ball in profile, from the robot's left, in front of the lab.
[[nodiscard]] SceneView profile_view();

/// Renders third-person images for reports and videos: everything in the model, finely drawn.
class SceneRenderer {
 public:
  /// `model` and `gl` must outlive it. Throws InputError for a size outside 8x8 to 4096x4096, RunError when OpenGL
  /// fails.
  SceneRenderer(const mjModel& model, GlContext& gl, ImageSize size);
  ~SceneRenderer();

  /// `rgb` is row-major, height x width x 3, top row first, sRGB. At most 100 marks.
  void render(mjData& data, const SceneView& view, std::span<std::uint8_t> rgb,
              std::span<const SceneMark> marks = {});

  [[nodiscard]] ImageSize image_size() const { return size_; }

 private:
  ImageSize size_;
  std::unique_ptr<detail::SceneDrawer> drawer_;
};

}  // namespace saccade
