#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/camera.h"
#include "core/config.h"
#include "sim/gl_context.h"
#include "sim/lens_resampler.h"
#include "threads/worker_threads.h"

namespace saccade {

namespace detail {
class SceneDrawer;
}

/// How an eye's images are made.
enum class RenderMethod {
  direct,     ///< MuJoCo draws every image (EyeRenderer)
  keyframes,  ///< MuJoCo draws keyframes, images are reprojected from them (KeyframeRenderer)
};
constexpr auto words_of(RenderMethod) {
  return std::to_array<Word<RenderMethod>>(
      {{RenderMethod::direct, "direct"}, {RenderMethod::keyframes, "keyframes"}});
}

struct EyeRenderConfig {
  RenderMethod method = RenderMethod::keyframes;
  std::int64_t supersampling = 2;     ///< samples per pixel and direction
  std::int64_t keyframe_samples = 5;  ///< the same of keyframes
  double keyframe_error_px = 0.25;    ///< bound on the error of reprojection
  double near_m = 0.02;               ///< distance along the optical axis of the nearest drawn surface
  double far_m = 12.0;                ///< and of the farthest
};

/// Keys: method, supersampling or keyframe_samples and keyframe_error_px, near_m, far_m.
void describe(FieldVisitor& v, EyeRenderConfig& config);

/// MuJoCo's view of the model's fixed camera `camera_id` for the drawn image of `lens`; that lies shift of the principal point,
/// samples, further right and down.
[[nodiscard]] mjvGLCamera eye_view(const mjData& data, int camera_id, const LensResampler& lens,
                                   const EyeRenderConfig& config,
                                   const Eigen::Vector2d& shift = Eigen::Vector2d::Zero());

/// Renders the image of an eye's camera, as linear luminance.
///
/// Draws geoms of groups 0 and 1 (the robot's own shell is group 2: no eye sees its head from inside), with the lights
/// of the model, but no shadows, reflections or haze. Luminance is Rec. 709's of the drawn colours, taken as linear
/// reflectances, in units of one 8-bit grey level, 0 to 255 with fractions. LensResampler makes the lens. A sphere is
/// drawn as a polyhedron whose outline has the area of the true one.
class EyeRenderer {
 public:
  /// What is less than that in front of a sphere does not hide it.
  static constexpr double hidden_by_m = 0.003;

  /// `model` and `gl` must outlive it. Textures are uploaded here: paint them before. `threads` share the work of an image
  /// after OpenGL.
  /// Throws InputError for a config or camera out of range, RunError when OpenGL fails.
  EyeRenderer(const mjModel& model, GlContext& gl, const Camera& camera, const EyeRenderConfig& config,
              std::shared_ptr<WorkerThreads> threads = std::make_shared<WorkerThreads>(1));
  ~EyeRenderer();

  /// The image of the model's fixed camera `camera_id` at the state of `data` (kinematics computed; not changed).
  /// `luminance`: row by row, height x width of the camera.
  void render(mjData& data, int camera_id, std::span<float> luminance);

  /// The same in colour: linear red, green and blue, 0 to 255 with fractions, as three images one after the other in
  /// `rgb`. The image lies shift_px further right and down in the pixel grid (with a lens: that is the shift on the
  /// optical axis), so that several images can share the samples of one.
  void render_colour(mjData& data, int camera_id, const Eigen::Vector2d& shift_px, std::span<float> rgb);

  /// The number of the object in each pixel. `number_of_geom` has a number from 1 to 254 for each geom of the model, 0 for those that are not drawn;
  /// where several are in a pixel's samples the smallest counts, and `nothing` where there is none. Costs about as much
  /// as an image. `numbers`: row by row, height x width of the camera.
  void label(mjData& data, int camera_id, std::span<const std::uint8_t> number_of_geom, std::uint8_t nothing,
             std::span<std::uint8_t> numbers);

  /// The share of a sphere's disc, in [0, 1], that is inside the newest image and not hidden by anything drawn more
  /// than 3 mm in front of the sphere. `centre_m` in the (OpenCV) camera frame. 0 for a sphere that is not wholly in
  /// front of the camera.
  [[nodiscard]] double visible_share(const Eigen::Vector3d& centre_m, double radius_m);

  [[nodiscard]] const Camera& camera() const { return camera_; }

 private:
  void draw(mjData& data, int camera_id, const Eigen::Vector2d& shift_px,
            std::span<const std::uint8_t> number_of_geom = {});

  Camera camera_;
  EyeRenderConfig config_;
  LensResampler lens_;
  std::shared_ptr<WorkerThreads> threads_;
  std::vector<std::uint32_t> rgba_;  ///< the drawn image, bottom row first
  std::vector<float> depth_;
  std::unique_ptr<detail::SceneDrawer> drawer_;
};

}  // namespace saccade
