#include "sim/scene_drawer.h"

#include <GL/gl.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string>

#include "core/error.h"
#include "sim/builtin_shapes.h"

namespace saccade::detail {
namespace {

constexpr int sphere_sides = 40;  ///< of the outline of a sphere in an eye

}  // namespace

SceneDrawer::SceneDrawer(const mjModel& model, GlContext& gl, ImageSize buffer, Quality quality)
    : model_(model), gl_(gl), quality_(quality) {
  mjv_defaultOption(&option_);
  mjv_defaultScene(&scene_);
  mjr_defaultContext(&context_);
  gl.make_current();
  try {
    make(buffer);
  } catch (...) {
    release();
    throw;
  }
}

SceneDrawer::~SceneDrawer() { release(); }

void SceneDrawer::make(ImageSize buffer) {
  // A shallow copy with visual settings that do not depend on the MJCF.
  mjModel settings = model_;
  settings.vis.global.offwidth = buffer.width;
  settings.vis.global.offheight = buffer.height;
  const bool fine = quality_ == Quality::fine;
  settings.vis.quality.offsamples = fine ? 4 : 0;
  settings.vis.quality.shadowsize = 0;
  // A triangle costs 60 ns in software: hands and pots are coarse in an eye, only the ball is not.
  settings.vis.quality.numslices = fine ? 32 : 10;
  settings.vis.quality.numstacks = fine ? 16 : 4;
  settings.vis.quality.numquads = fine ? 8 : 1;
  mjv_makeScene(&settings, &scene_, static_cast<int>(model_.ngeom) + static_cast<int>(max_marks));
  mjr_makeContext(&settings, &context_, mjFONTSCALE_50);
  mjr_setBuffer(mjFB_OFFSCREEN, &context_);
  if (context_.currentBuffer != mjFB_OFFSCREEN || context_.offWidth < buffer.width) {
    throw RunError("OpenGL failed: no offscreen buffer");
  }
  read_pixels_ = reinterpret_cast<void*>(gl_function<decltype(glReadPixels)>(gl_, "glReadPixels"));
  project_textures(gl_, context_, settings.vis);
  if (!fine) {
    replace_sphere(gl_, context_, sphere_sides);
    drop_mipmaps();
  }
  std::fill(std::begin(scene_.flags), std::end(scene_.flags), mjtByte{0});
  scene_.flags[mjRND_CULL_FACE] = 1;
  for (int group = 0; group < mjNGROUP; ++group) option_.geomgroup[group] = group < (fine ? 3 : 2) ? 1 : 0;
}

void SceneDrawer::release() noexcept {
  try {
    gl_.make_current();
    mjr_freeContext(&context_);
  } catch (const RunError&) {  // without its OpenGL context there is nothing to free
  }
  mjv_freeScene(&scene_);
}

void SceneDrawer::draw(mjData& data, const mjvGLCamera& camera, mjrRect viewport,
                       std::span<const std::uint8_t> number_of_geom, std::span<const SceneMark> marks) {
  gl_.make_current();
  update(data, camera);
  for (const SceneMark& mark : marks) add(mark);
  const bool numbered = !number_of_geom.empty();
  scene_.flags[mjRND_SEGMENT] = scene_.flags[mjRND_IDCOLOR] = numbered ? 1 : 0;
  if (numbered) {
    const std::span geoms = drawn();
    const auto last = std::remove_if(geoms.begin(), geoms.end(), [&](const mjvGeom& geom) {
      return number_of_geom[static_cast<std::size_t>(geom.objid)] == 0;
    });
    scene_.ngeom = static_cast<int>(last - geoms.begin());
    for (mjvGeom& geom : drawn()) geom.segid = number_of_geom[static_cast<std::size_t>(geom.objid)] - 1;
  }
  show(camera, viewport);
}

void SceneDrawer::draw_geoms(mjData& data, const mjvGLCamera& camera, mjrRect viewport) {
  gl_.make_current();
  update(data, camera);
  scene_.flags[mjRND_SEGMENT] = scene_.flags[mjRND_IDCOLOR] = 1;
  for (mjvGeom& geom : drawn()) geom.segid = geom.objid;
  show(camera, viewport);
}

void SceneDrawer::draw_some(mjData& data, const mjvGLCamera& camera, mjrRect viewport,
                            std::span<const std::uint8_t> is_shown) {
  gl_.make_current();
  update(data, camera);
  keep(is_shown);
  scene_.flags[mjRND_SEGMENT] = scene_.flags[mjRND_IDCOLOR] = 0;
  show(camera, viewport);
}

void SceneDrawer::show(const mjvGLCamera& camera, mjrRect viewport) {
  if (quality_ == Quality::fast) {
    enlarge_spheres();
    skip_unseen(camera, viewport);
  }
  mjr_restoreBuffer(&context_);  // another drawer may have drawn meanwhile
  mjr_render(viewport, &scene_, &context_);
}

void SceneDrawer::read_rgba(mjrRect area, std::uint32_t* rgba) {
  gl_.make_current();
  mjr_restoreBuffer(&context_);
  reinterpret_cast<decltype(glReadPixels)*>(read_pixels_)(area.left, area.bottom, area.width, area.height,
                                                          GL_RGBA, GL_UNSIGNED_BYTE, rgba);
}

void SceneDrawer::read_rgb(mjrRect area, std::uint8_t* rgb) {
  gl_.make_current();
  mjr_restoreBuffer(&context_);
  mjr_readPixels(rgb, nullptr, area, &context_);
}

void SceneDrawer::read_depth(mjrRect area, float* depth) {
  gl_.make_current();
  mjr_restoreBuffer(&context_);
  mjr_readPixels(nullptr, depth, area, &context_);
}

/// The lab's texels are about as large as samples: without mipmaps 2 x 2 samples come nearer to the true
/// mean of a pixel, and cost a third less.
void SceneDrawer::drop_mipmaps() const {
  auto* const bind = gl_function<decltype(glBindTexture)>(gl_, "glBindTexture");
  auto* const set = gl_function<decltype(glTexParameteri)>(gl_, "glTexParameteri");
  for (int i = 0; i < context_.ntexture; ++i) {
    const GLenum target = context_.textureType[i] == mjTEXTURE_2D ? GL_TEXTURE_2D : GL_TEXTURE_CUBE_MAP;
    bind(target, context_.texture[i]);
    set(target, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    bind(target, 0);
  }
}

void SceneDrawer::update(mjData& data, const mjvGLCamera& camera) {
  scene_.ngeom = 0;
  mjv_addGeoms(&model_, &data, &option_, nullptr, mjCAT_STATIC | mjCAT_DYNAMIC, &scene_);
  scene_.camera[0] = scene_.camera[1] = camera;  // MuJoCo 3 places the headlight there
  scene_.nlight = 0;
  mjv_makeLights(&model_, &data, &scene_);
  // Geoms that are not part of the room are nearest: drawn first, they save drawing the pixels behind them.
  const std::span geoms = drawn();
  std::stable_partition(geoms.begin(), geoms.end(),
                        [this](const mjvGeom& geom) { return model_.geom_bodyid[geom.objid] != 0; });
}

void SceneDrawer::add(const SceneMark& mark) {
  SACCADE_CHECK(scene_.ngeom < scene_.maxgeom);
  const Eigen::Vector3d along = mark.to_m - mark.from_m;
  const Eigen::Vector3d middle = 0.5 * (mark.from_m + mark.to_m);
  const std::array<mjtNum, 3> size = {mark.radius_m, 0.5 * along.norm(), 0.0};
  std::array<mjtNum, 4> turn_wxyz{};
  std::array<mjtNum, 9> rotation{};
  mju_quatZ2Vec(turn_wxyz.data(), along.data());
  mju_quat2Mat(rotation.data(), turn_wxyz.data());
  mjvGeom& geom = scene_.geoms[scene_.ngeom++];
  mjv_initGeom(&geom, mjGEOM_CAPSULE, size.data(), middle.data(), rotation.data(), mark.rgba.data());
  geom.emission = 1.0F;
}

/// A regular polygon of n sides has the area of its circumscribed circle times 1 - (2 pi / n)^2 / 6.
void SceneDrawer::enlarge_spheres() {
  constexpr double step = 2.0 * std::numbers::pi / sphere_sides;
  constexpr auto same_area = static_cast<float>(1.0 + step * step / 12.0);
  for (mjvGeom& geom : drawn()) {
    if (geom.type != mjGEOM_SPHERE) continue;
    for (float& size : geom.size) size *= same_area;
  }
}

void SceneDrawer::keep(std::span<const std::uint8_t> is_shown) {
  const std::span geoms = drawn();
  const auto hidden = [&](const mjvGeom& geom) {
    return is_shown[static_cast<std::size_t>(geom.objid)] == 0;
  };
  scene_.ngeom = static_cast<int>(std::remove_if(geoms.begin(), geoms.end(), hidden) - geoms.begin());
}

/// Every geom costs some microseconds even when no pixel of it is in the image.
void SceneDrawer::skip_unseen(const mjvGLCamera& camera, mjrRect viewport) {
  using Eigen::Vector3f;
  const Vector3f position(camera.pos);
  const Vector3f forward(camera.forward);
  const Vector3f up(camera.up);
  const Vector3f right = forward.cross(up);
  const float half_width = 0.5F * (camera.frustum_top - camera.frustum_bottom) *
                           static_cast<float>(viewport.width) / static_cast<float>(viewport.height);
  const float near = camera.frustum_near;
  // Normals of the frustum's sides, pointing out.
  const std::array<Vector3f, 4> sides{
      (near * right - (camera.frustum_center + half_width) * forward).normalized(),
      (-near * right + (camera.frustum_center - half_width) * forward).normalized(),
      (near * up - camera.frustum_top * forward).normalized(),
      (-near * up + camera.frustum_bottom * forward).normalized()};
  const std::span geoms = drawn();
  const auto unseen = [&](const mjvGeom& geom) {
    const float reach = geom.modelrbound;
    if (!(reach > 0.0F)) return false;  // without bounds
    const Vector3f from_eye = Vector3f(geom.pos) - position;
    return std::any_of(sides.begin(), sides.end(),
                       [&](const Vector3f& out) { return out.dot(from_eye) > 1.01F * reach; });
  };
  scene_.ngeom = static_cast<int>(std::remove_if(geoms.begin(), geoms.end(), unseen) - geoms.begin());
}

}  // namespace saccade::detail
