#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/camera.h"
#include "sim/eye_renderer.h"
#include "sim/gl_context.h"
#include "sim/lens_resampler.h"
#include "sim/world.h"

namespace saccade {

namespace detail {
class SceneDrawer;
}

/// What the centre of each pixel shows, row by row.
struct TrueImage {
  std::vector<float> depth_m;      ///< along the optical axis; NaN where nothing is drawn
  std::vector<std::int32_t> geom;  ///< of the model; -1 where nothing is drawn
};

/// Draws depth and geoms of an eye's camera.
///
/// Geoms are those of the samples that are nearest to the centres of the pixels, as EyeRenderer draws them. The depth of a sphere
/// is that of the true sphere; of all else that of the drawn surface, interpolated between samples, in the depth buffer's
/// resolution: z^2 / near_m / 2^24.
class TrueImageRenderer {
 public:
  /// `model` and `gl` must outlive it. Throws as EyeRenderer does.
  TrueImageRenderer(const mjModel& model, GlContext& gl, const Camera& camera, const EyeRenderConfig& config);
  ~TrueImageRenderer();

  /// The image of the model's fixed camera `camera_id` at the state of `data` (kinematics computed; not changed).
  void render(mjData& data, int camera_id, TrueImage& image);

 private:
  [[nodiscard]] double sphere_depth(const mjData& data, int camera_id, int geom,
                                    const Eigen::Vector3d& ray) const;

  const mjModel* model_;
  Camera camera_;
  EyeRenderConfig config_;
  LensResampler lens_;
  std::unique_ptr<detail::SceneDrawer> drawer_;
  std::vector<std::uint32_t> rgba_;
  std::vector<float> depth_;
  std::vector<Eigen::Vector3d> rays_;  ///< of the pixels, at unit depth
};

/// Poses at one instant, in MuJoCo's world, which is the root frame.
struct WorldPoses {
  std::int64_t t_us = 0;
  std::vector<Eigen::Isometry3d> root_from_body;
  std::array<Eigen::Isometry3d, 2> root_from_camera;  ///< of the left and the right eye
};
/// Of the world now.
[[nodiscard]] WorldPoses poses_of(const World& world);

/// The optical flow of what each pixel shows at `now`, px/s, x and y of a pixel one after the other: the difference of its true
/// projections at `after` and `before`, over the time between them. `camera_flow`: of a point that rests in the root frame.
/// NaN where nothing is drawn, and where a projection does not exist. `eye`: 0 left, 1 right.
void optical_flow(const Camera& camera, const TrueImage& image, const mjModel& model, std::size_t eye,
                  const WorldPoses& before, const WorldPoses& now, const WorldPoses& after,
                  std::span<float> flow, std::span<float> camera_flow);

/// The objects of a world by number: 0 is what is not drawn, 1 the room.
struct ObjectTable {
  std::vector<std::string> names;            ///< by number
  std::vector<std::uint8_t> number_of_geom;  ///< of each geom of the model
  std::vector<std::string> body_names;       ///< of each body of the model
};
/// Throws RunError for a world with more than 254 objects.
[[nodiscard]] ObjectTable object_table(const World& world);

}  // namespace saccade
