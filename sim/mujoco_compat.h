#pragma once

#include <mujoco/mujoco.h>

#include <cstring>
#include <memory>
#include <string>

#include "core/error.h"

/// Everything that differs between the versions of MuJoCo that saccade is built with, 2.2.2 to 3.12. mjVERSION_HEADER is 222
/// for 2.2.2, 3005000 for 3.5.0.
namespace saccade {

struct MjDelete {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
  void operator()(mjVFS* vfs) const {
    mj_deleteVFS(vfs);
    delete vfs;
  }
};
using MjModelPtr = std::unique_ptr<mjModel, MjDelete>;
using MjDataPtr = std::unique_ptr<mjData, MjDelete>;
using MjVfsPtr = std::unique_ptr<mjVFS, MjDelete>;

/// Adds a text file to MuJoCo's virtual file system, with the function of the installed version
/// (mj_addBufferVFS in 3.x, mj_makeEmptyFileVFS in 2.x). Returns false on failure.
template <class Vfs>
bool add_to_vfs(Vfs* vfs, const std::string& name, const std::string& text) {
  const int size = static_cast<int>(text.size());
  if constexpr (requires { mj_addBufferVFS(vfs, name.c_str(), text.data(), size); }) {
    return mj_addBufferVFS(vfs, name.c_str(), text.data(), size) == 0;
  } else {
    if (mj_makeEmptyFileVFS(vfs, name.c_str(), size) != 0) return false;
    std::memcpy(vfs->filedata[mj_findFileVFS(vfs, name.c_str())], text.data(), text.size());
    return true;
  }
}

/// The texels of a texture, row by row; texture_channels() bytes each.
inline mjtByte* texels_of(const mjModel& model, int texture) {
#if mjVERSION_HEADER >= 320
  return model.tex_data + model.tex_adr[texture];
#else
  return model.tex_rgb + model.tex_adr[texture];
#endif
}
template <class Model>
int texture_channels(const Model& model, int texture) {
  if constexpr (requires { model.tex_nchannel; }) {
    return model.tex_nchannel[texture];
  } else {
    return 3;
  }
}

/// The texels of a texture with three channels: red, green, blue, row by row.
inline mjtByte* texture_rgb(const mjModel& model, int texture) {
  SACCADE_CHECK(texture_channels(model, texture) == 3);
  return texels_of(model, texture);
}

/// The texture of a material's colour; -1: none.
template <class Model>
int material_texture(const Model& model, int material) {
#if mjVERSION_HEADER >= 320
  return model.mat_texid[mjNTEXROLE * material + mjTEXROLE_RGB];
#else
  return model.mat_texid[material];
#endif
}

/// The index of the texture coordinate of a mesh's face (counted over all meshes) at its corner k, in the mesh.
template <class Model>
int face_texel(const Model& model, int face, int k) {
  if constexpr (requires { model.mesh_facetexcoord; }) {
    return model.mesh_facetexcoord[3 * face + k];
  } else {
    return model.mesh_face[3 * face + k];
  }
}

/// Kinds of light as MuJoCo 3.3.3 numbers them. Its renderer draws no others than these two.
enum class LightKind { spot = 0, directional = 1 };
template <class Model>
LightKind light_kind(const Model& model, int light) {
  if constexpr (requires { model.light_directional; }) {
    return model.light_directional[light] != 0 ? LightKind::directional : LightKind::spot;
  } else {
    return static_cast<LightKind>(model.light_type[light]);
  }
}

/// Whether the renderer's spheres, ellipsoids, capsules, cylinders and boxes have texture coordinates of their own.
inline constexpr bool primitives_have_texels = mjVERSION_HEADER >= 3012000;

/// The first geom of the groups that a ray hits, static ones included; -1: none.
template <class Model, class Data>
int first_geom_on_ray(const Model* model, const Data* data, const mjtNum* from_m, const mjtNum* ray,
                      const mjtByte* groups) {
  int geom = -1;
  constexpr int no_body = -1;
  if constexpr (requires { mj_ray(model, data, from_m, ray, groups, 1, no_body, &geom, nullptr); }) {
    mj_ray(model, data, from_m, ray, groups, 1, no_body, &geom, nullptr);
  } else {
    mj_ray(model, data, from_m, ray, groups, 1, no_body, &geom);
  }
  return geom;
}

}  // namespace saccade
