#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>

#include "core/event.h"
#include "sim/gl_context.h"

namespace saccade {

/// A rod drawn into an image of the scene that is not part of the world: a ray, an edge of a frustum. Root frame.
struct SceneMark {
  Eigen::Vector3d from_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_m = Eigen::Vector3d::Zero();
  double radius_m = 0.002;
  std::array<float, 4> rgba = {1.0F, 1.0F, 1.0F,
                               1.0F};  ///< linear; drawn at full brightness, without lighting
};

namespace detail {

/// Draws a model into an offscreen buffer: MuJoCo's abstract scene with its OpenGL resources. Every call makes the
/// context current.
class SceneDrawer {
 public:
  /// `fast` for an eye: coarse shapes but for spheres, no mipmaps, geoms outside the frustum are skipped. `fine` for
  /// people: everything in the model, with multisampling.
  enum class Quality { fast, fine };

  static constexpr std::size_t max_marks = 100;

  /// `model` and `gl` must outlive it. Textures are uploaded here: paint them before. Throws RunError when OpenGL
  /// fails.
  SceneDrawer(const mjModel& model, GlContext& gl, ImageSize buffer, Quality quality);
  ~SceneDrawer();
  SceneDrawer(const SceneDrawer&) = delete;
  SceneDrawer& operator=(const SceneDrawer&) = delete;

  /// Draws the state of `data`, lit and textured; or, if number_of_geom is not empty, each geom flat in the colour
  /// (number, 0, 0), those of number 0 not at all. At most max_marks marks.
  void draw(mjData& data, const mjvGLCamera& camera, mjrRect viewport,
            std::span<const std::uint8_t> number_of_geom = {}, std::span<const SceneMark> marks = {});

  /// Draws each geom flat in the colour of its number in the model plus 1, red the lowest 8 bits, then green and blue.
  void draw_geoms(mjData& data, const mjvGLCamera& camera, mjrRect viewport);

  /// Draws only the geoms whose entry in `is_shown` (per geom of the model) is not 0, lit and textured, before black.
  void draw_some(mjData& data, const mjvGLCamera& camera, mjrRect viewport,
                 std::span<const std::uint8_t> is_shown);

  // Of the newest drawing, bottom row first.
  void read_rgba(mjrRect area, std::uint32_t* rgba);
  void read_rgb(mjrRect area, std::uint8_t* rgb);
  /// 0 at the near plane, 1 at the far plane, as OpenGL has it by default.
  void read_depth(mjrRect area, float* depth);

 private:
  void make(ImageSize buffer);
  void release() noexcept;
  void drop_mipmaps() const;
  void update(mjData& data, const mjvGLCamera& camera);
  void add(const SceneMark& mark);
  [[nodiscard]] std::span<mjvGeom> drawn() { return {scene_.geoms, static_cast<std::size_t>(scene_.ngeom)}; }
  void enlarge_spheres();
  void skip_unseen(const mjvGLCamera& camera, mjrRect viewport);
  void keep(std::span<const std::uint8_t> is_shown);
  void show(const mjvGLCamera& camera, mjrRect viewport);

  const mjModel& model_;
  GlContext& gl_;
  Quality quality_;
  mjvOption option_{};
  mjvScene scene_{};
  mjrContext context_{};
  void* read_pixels_ = nullptr;  ///< glReadPixels
};

}  // namespace detail
}  // namespace saccade
