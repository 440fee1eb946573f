#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

namespace saccade::detail {

/// Geoms of an eye's image that move together: those of one body.
struct SceneLayer {
  int body = 0;                        ///< 0: the room
  std::vector<int> geoms;              ///< those of groups 0 and 1, which eyes draw
  std::vector<std::uint8_t> is_shown;  ///< per geom of the model: 1 if it belongs to the layer
  /// Whether the outlines are those of spheres, capsules and ellipsoids, which change smoothly with the direction of view.
  bool is_round = true;
  /// Half the thickness of the thickest geom, m: how far its outline can move on its surface.
  double thickness_m = 0.0;
  double shine = 0.0;  ///< brightness of its highlights, a share of full brightness

  [[nodiscard]] bool is_room() const { return body == 0; }
  /// The frame of the body in `data`.
  [[nodiscard]] Eigen::Isometry3d root_from_layer(const mjData& data) const;
};

/// The layers of a model: the room first, even if it is empty, then every other body with geoms that eyes draw.
[[nodiscard]] std::vector<SceneLayer> scene_layers(const mjModel& model);

/// Sets `state` to colours, positions and directions of the model's lights. Keyframes drawn under other lights are out of
/// date.
void read_lights(const mjModel& model, const mjData& data, std::vector<float>& state);

}  // namespace saccade::detail
