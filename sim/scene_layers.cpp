#include "sim/scene_layers.h"

#include <algorithm>
#include <iterator>

namespace saccade::detail {
namespace {

constexpr int drawn_groups = 2;  // as EyeRenderer draws

/// The brightest highlight that the lights can make on a geom.
double shine_of(const mjModel& m, int geom) {
  const int material = m.geom_matid[geom];
  // MuJoCo draws a geom without material with specular 0.5.
  const double surface = material < 0 ? 0.5 : static_cast<double>(m.mat_specular[material]);
  double light = static_cast<double>(
      *std::max_element(std::begin(m.vis.headlight.specular), std::end(m.vis.headlight.specular)));
  for (int i = 0; i < 3 * m.nlight; ++i) light = std::max(light, static_cast<double>(m.light_specular[i]));
  return surface * light;
}

void add(const mjModel& m, int geom, SceneLayer& layer) {
  const mjtNum* size = m.geom_size + 3 * geom;
  double half_m = m.geom_rbound[geom];
  switch (m.geom_type[geom]) {
    case mjGEOM_SPHERE:
    case mjGEOM_CAPSULE:
      half_m = size[0];
      break;
    case mjGEOM_ELLIPSOID:
      half_m = std::max({size[0], size[1], size[2]});
      break;
    default:
      layer.is_round = false;
  }
  layer.geoms.push_back(geom);
  layer.is_shown[static_cast<std::size_t>(geom)] = 1;
  layer.thickness_m = std::max(layer.thickness_m, half_m);
  layer.shine = std::max(layer.shine, shine_of(m, geom));
}

}  // namespace

Eigen::Isometry3d SceneLayer::root_from_layer(const mjData& data) const {
  using RowMajor = Eigen::Matrix<mjtNum, 3, 3, Eigen::RowMajor>;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  if (is_room()) return pose;
  pose.linear() = Eigen::Map<const RowMajor>(data.xmat + 9 * body);
  pose.translation() = Eigen::Map<const Eigen::Vector3d>(data.xpos + 3 * body);
  return pose;
}

std::vector<SceneLayer> scene_layers(const mjModel& model) {
  std::vector<SceneLayer> layers;
  for (int body = 0; body < model.nbody; ++body) {
    SceneLayer layer;
    layer.body = body;
    layer.is_shown.resize(static_cast<std::size_t>(model.ngeom));
    for (int geom = 0; geom < model.ngeom; ++geom) {
      if (model.geom_bodyid[geom] == body && model.geom_group[geom] < drawn_groups) add(model, geom, layer);
    }
    if (layer.is_room() || !layer.geoms.empty()) layers.push_back(std::move(layer));
  }
  return layers;
}

void read_lights(const mjModel& m, const mjData& data, std::vector<float>& state) {
  state.clear();
  for (int i = 0; i < m.nlight; ++i) {
    state.push_back(static_cast<float>(m.light_active[i]));
    for (const float* const colour : {m.light_ambient, m.light_diffuse, m.light_specular})
      state.insert(state.end(), colour + 3 * i, colour + 3 * i + 3);
    for (const mjtNum* const vector : {data.light_xpos, data.light_xdir}) {
      for (int axis = 0; axis < 3; ++axis) state.push_back(static_cast<float>(vector[3 * i + axis]));
    }
  }
}

}  // namespace saccade::detail
