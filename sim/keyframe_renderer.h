#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/camera.h"
#include "sim/eye_renderer.h"
#include "sim/gl_context.h"
#include "sim/keyframe.h"
#include "sim/keyframe_camera.h"
#include "sim/keyframe_rule.h"
#include "sim/layer_warp.h"
#include "sim/scene_layers.h"
#include "threads/worker_threads.h"

namespace saccade {

/// Computes the images of an eye's camera from keyframes, as linear luminance like EyeRenderer::render.
///
/// The room and every body that an eye sees are layers (SceneLayer). MuJoCo draws each layer alone, with depth, into a
/// keyframe of its own. An image is computed from the newest keyframes: every pixel looks its point up in the keyframe
/// of a layer by the exact reprojection of camera, layer and depth, and the layers are put together in the order of
/// their depths. A layer's keyframe is drawn anew when KeyframeRule no longer permits it. What ball and hand uncover is
/// there, because the room's keyframe is drawn without them.
class KeyframeRenderer {
 public:
  /// `model` and `gl` must outlive it. `threads` share the rows of an image; images do not depend on them. Textures are
  /// uploaded here: paint them before.
  /// Throws InputError for a config or camera out of range, RunError when OpenGL fails.
  KeyframeRenderer(const mjModel& model, GlContext& gl, const Camera& camera, const EyeRenderConfig& config,
                   std::shared_ptr<WorkerThreads> threads);
  ~KeyframeRenderer();

  /// The image of the model's fixed camera `camera_id` at the state of `data` (kinematics computed; not changed).
  /// `luminance`: row by row, height x width of the camera, 0 to 255.
  void render(mjData& data, int camera_id, std::span<float> luminance);

  /// The share of a sphere's disc, in [0, 1], that is inside the newest image and not hidden by anything more than 3 mm in
  /// front of the sphere. `centre_m` in the (OpenCV) camera frame; `body`: of the sphere, whose geoms do not hide it. 0
  /// for a sphere that is not wholly in front of the camera.
  [[nodiscard]] double visible_share(const Eigen::Vector3d& centre_m, double radius_m, int body);

  /// Keyframes drawn so far, of all layers, and their samples.
  struct Counts {
    std::int64_t room = 0;
    std::int64_t bodies = 0;
    std::int64_t samples = 0;
  };
  [[nodiscard]] const Counts& counts() const { return counts_; }

 private:
  /// Pixels [left, right) x [top, bottom) of the image.
  struct PixelRect {
    int left = 0;
    int top = 0;
    int right = 0;
    int bottom = 0;

    [[nodiscard]] bool is_empty() const { return right <= left || bottom <= top; }
    [[nodiscard]] bool has_row(int y) const { return y >= top && y < bottom; }
    [[nodiscard]] bool holds(int x, int y) const { return x >= left && x < right && has_row(y); }
  };
  /// A layer with its keyframe and what the newest image has of it; the size of the image each.
  struct Sheet {
    detail::SceneLayer layer;
    detail::Keyframe keyframe;
    PixelRect pixels;
    detail::WarpRow warp;
    LargeVector<float> inverse_depth_1_m;
    LargeVector<float> luminance;  ///< of a body
    LargeVector<float> cover;      ///< of a body
  };
  /// Intermediate results of a row, one for each band of rows.
  struct Scratch {
    std::vector<float> u;
    std::vector<float> v;
    std::vector<int> at;
    std::vector<const Sheet*> bodies;  ///< with pixels in the row
  };
  /// What one layer shows in a pixel.
  struct Fragment {
    float luminance;
    float cover;
    float inverse_depth_1_m;
  };

  /// Of a sphere's disc.
  struct Share {
    double all = 0.0;
    double visible = 0.0;
  };

  void update(Sheet& sheet, mjData& data, const mjvGLCamera& eye, const Eigen::Isometry3d& camera_from_root);
  [[nodiscard]] bool find_rect(const Sheet& sheet, const mjData& data,
                               const Eigen::Isometry3d& camera_from_root, detail::Keyframe& keyframe) const;
  void draw(Sheet& sheet, mjData& data, mjvGLCamera eye);
  void prepare(Sheet& sheet, const Eigen::Isometry3d& camera_from_layer) const;
  void reproject_rows(Sheet& sheet, int top, int bottom, std::span<float> luminance, Scratch& scratch) const;
  [[nodiscard]] PixelRect pixels_of(const detail::Keyframe& keyframe,
                                    const Eigen::Isometry3d& camera_from_key) const;
  void compose_rows(std::span<float> luminance, int top, int bottom, Scratch& scratch) const;
  void compose_pixel(int x, std::size_t pixel, const std::vector<const Sheet*>& bodies,
                     std::span<float> luminance) const;
  [[nodiscard]] Share share_of_pixel(const Sheet& own, int column, int row, const Eigen::Vector3d& centre_m,
                                     double k) const;

  Camera camera_;
  EyeRenderConfig config_;
  detail::KeyframeCamera key_camera_;
  detail::KeyframeRule rule_;
  detail::KeyframeFilter filter_;
  std::unique_ptr<detail::SceneDrawer> drawer_;
  const mjModel* model_;
  std::vector<Sheet> sheets_;  ///< the room first
  std::vector<float> light_;
  std::vector<float> keyframe_light_;
  // Rays of the pixels at unit depth, row by row, and the change of their x and y along a row and along a column.
  std::vector<float> ray_x_;
  std::vector<float> ray_y_;
  std::vector<std::array<float, 4>> ray_slope_;
  std::shared_ptr<WorkerThreads> threads_;
  std::vector<Scratch> scratch_;  ///< of each band of rows
  std::vector<Share> shares_;     ///< of the pixels where the sphere is
  LargeVector<std::uint32_t> rgba_;
  LargeVector<float> depth_;
  Counts counts_;
};

}  // namespace saccade
