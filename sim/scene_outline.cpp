#include "sim/scene_outline.h"

#include <algorithm>
#include <map>
#include <optional>

#include "sim/world.h"

namespace saccade {
namespace {

constexpr int most_triangles = 20'000;  // of one mesh

/// Origin and turn as MuJoCo has them.
Eigen::Isometry3d pose_of(const mjtNum* position_m, const mjtNum* turn_wxyz) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() =
      Eigen::Quaterniond(turn_wxyz[0], turn_wxyz[1], turn_wxyz[2], turn_wxyz[3]).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(position_m[0], position_m[1], position_m[2]);
  return pose;
}

std::optional<std::string> shape_name(int type) {
  switch (type) {
    case mjGEOM_PLANE:
      return "plane";
    case mjGEOM_SPHERE:
      return "sphere";
    case mjGEOM_CAPSULE:
      return "capsule";
    case mjGEOM_ELLIPSOID:
      return "ellipsoid";
    case mjGEOM_CYLINDER:
      return "cylinder";
    case mjGEOM_BOX:
      return "box";
    case mjGEOM_MESH:
      return "mesh";
    default:
      return std::nullopt;
  }
}

/// The mean of a texture's texels, 0 to 1.
std::array<double, 3> mean_colour(const mjModel& model, int texture) {
  const int channels = texture_channels(model, texture);
  const std::int64_t count = std::int64_t{model.tex_width[texture]} * model.tex_height[texture];
  const mjtByte* const texels = texels_of(model, texture);
  const std::int64_t step = std::max<std::int64_t>(1, count / 4'096) | 1;
  std::array<double, 3> sum{};
  std::int64_t taken = 0;
  for (std::int64_t i = 0; i < count; i += step, ++taken) {
    for (int c = 0; c < 3; ++c)
      sum[static_cast<std::size_t>(c)] += texels[channels * i + std::min(c, channels - 1)];
  }
  for (double& value : sum) value /= 255.0 * static_cast<double>(std::max<std::int64_t>(1, taken));
  return sum;
}

/// The texture of a geom's material; -1: none.
int texture_of(const mjModel& model, int geom) {
  const int material = model.geom_matid[geom];
  return material >= 0 ? material_texture(model, material) : -1;
}

/// The means of blocks of texels.
SceneOutline::Texture small_texture(const mjModel& model, int texture) {
  const int channels = texture_channels(model, texture);
  const int width = model.tex_width[texture];
  const int height = model.tex_height[texture];
  const mjtByte* const texels = texels_of(model, texture);
  const int block = (std::max(width, height) - 1) / SceneOutline::most_texels + 1;
  SceneOutline::Texture out{(width - 1) / block + 1, (height - 1) / block + 1, {}};
  out.rgb.reserve(3 * static_cast<std::size_t>(out.width) * static_cast<std::size_t>(out.height));
  for (int top = 0; top < height; top += block) {
    for (int left = 0; left < width; left += block) {
      std::array<int, 3> sum{};
      int count = 0;
      for (int y = top; y < std::min(height, top + block); ++y) {
        for (int x = left; x < std::min(width, left + block); ++x, ++count) {
          const mjtByte* const texel = texels + channels * (std::int64_t{y} * width + x);
          for (int c = 0; c < 3; ++c) sum[static_cast<std::size_t>(c)] += texel[std::min(c, channels - 1)];
        }
      }
      for (const int value : sum) out.rgb.push_back(static_cast<std::uint8_t>(value / count));
    }
  }
  return out;
}

std::array<double, 4> colour_of(const mjModel& model, int geom, bool textured) {
  const int material = model.geom_matid[geom];
  const float* const rgba = material >= 0 ? model.mat_rgba + 4 * material : model.geom_rgba + 4 * geom;
  std::array<double, 4> colour{rgba[0], rgba[1], rgba[2], rgba[3]};
  const int texture = texture_of(model, geom);
  if (texture < 0 || textured) return colour;
  const std::array<double, 3> mean = mean_colour(model, texture);
  for (std::size_t c = 0; c < 3; ++c) colour[c] *= mean[c];
  return colour;
}

SceneOutline::Mesh mesh_of(const mjModel& model, int mesh) {
  SceneOutline::Mesh out;
  const float* const vertices = model.mesh_vert + 3 * model.mesh_vertadr[mesh];
  const int count = model.mesh_vertnum[mesh];
  if (model.mesh_facenum[mesh] <= most_triangles) {
    out.vertices_m.assign(vertices, vertices + 3 * count);
    const int* const faces = model.mesh_face + 3 * model.mesh_faceadr[mesh];
    out.triangles.assign(faces, faces + 3 * model.mesh_facenum[mesh]);
    if (model.mesh_texcoordadr[mesh] < 0) return out;
    const float* const texels = model.mesh_texcoord + 2 * model.mesh_texcoordadr[mesh];
    for (int face = 0; face < model.mesh_facenum[mesh]; ++face) {
      for (int k = 0; k < 3; ++k) {
        const int texel = face_texel(model, model.mesh_faceadr[mesh] + face, k);
        out.texels.insert(out.texels.end(), {texels[2 * texel], texels[2 * texel + 1]});
      }
    }
    return out;
  }
  Eigen::AlignedBox3f box;
  for (int i = 0; i < count; ++i) box.extend(Eigen::Map<const Eigen::Vector3f>(vertices + 3 * i));
  for (int corner = 0; corner < 8; ++corner) {
    for (int axis = 0; axis < 3; ++axis)
      out.vertices_m.push_back((corner >> axis & 1) != 0 ? box.max()(axis) : box.min()(axis));
  }
  out.triangles = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                   2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return out;
}

}  // namespace

SceneOutline scene_outline(const World& world) {
  const mjModel& model = world.model();
  SceneOutline scene;
  for (int body = 0; body < model.nbody; ++body) {
    const char* const name = mj_id2name(&model, mjOBJ_BODY, body);
    scene.bodies.emplace_back(name != nullptr ? name : "");
  }
  std::map<int, int> meshes;  // index in the outline by that in the model
  std::map<int, int> textures;
  for (int i = 0; i < model.ngeom; ++i) {
    const std::optional<std::string> shape = shape_name(model.geom_type[i]);
    if (!shape || colour_of(model, i, true)[3] <= 0.0) continue;
    SceneOutline::Geom geom;
    geom.body = model.geom_bodyid[i];
    geom.shape = *shape;
    std::copy_n(model.geom_size + 3 * i, 3, geom.size_m.begin());
    geom.body_from_geom = pose_of(model.geom_pos + 3 * i, model.geom_quat + 4 * i);
    if (*shape == "mesh") {
      const int mesh = model.geom_dataid[i];
      const auto [place, is_new] = meshes.try_emplace(mesh, static_cast<int>(scene.meshes.size()));
      if (is_new) scene.meshes.push_back(mesh_of(model, mesh));
      geom.mesh = place->second;
      const int texture = texture_of(model, i);
      if (texture >= 0 && !scene.meshes[static_cast<std::size_t>(geom.mesh)].texels.empty()) {
        const auto [same, first] = textures.try_emplace(texture, static_cast<int>(scene.textures.size()));
        if (first) scene.textures.push_back(small_texture(model, texture));
        geom.texture = same->second;
      }
    }
    geom.rgba = colour_of(model, i, geom.texture >= 0);
    scene.geoms.push_back(std::move(geom));
  }
  return scene;
}

Eigen::Isometry3d world_from_body(const World& world, std::size_t body) {
  const mjData& data = world.data();
  return pose_of(data.xpos + 3 * body, data.xquat + 4 * body);
}

}  // namespace saccade
