#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace saccade {

class World;

/// The shapes of a world's model, simplified, for drawings outside of MuJoCo.
struct SceneOutline {
  struct Geom {
    int body = 0;
    std::string shape;  ///< plane, sphere, capsule, ellipsoid, cylinder, box or mesh
    /// Half lengths as MuJoCo has them: radius; radius and half length; half axes; 0 for a plane without an end in this direction.
    std::array<double, 3> size_m{};
    Eigen::Isometry3d body_from_geom = Eigen::Isometry3d::Identity();
    std::array<double, 4> rgba{};  ///< 0 to 1; the mean of a texture that is not drawn
    int mesh = -1;                 ///< index into meshes; -1: none
    int texture = -1;              ///< index into textures, of a mesh with texels; -1: none
  };
  struct Mesh {
    std::vector<float> vertices_m;  ///< x, y, z one after the other
    std::vector<int> triangles;     ///< three indices of vertices each
    std::vector<float>
        texels;  ///< u, v of each corner of each triangle, 0 to 1 from the texture's first row on; or none
  };
  struct Texture {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> rgb;  ///< row by row
  };
  std::vector<std::string> bodies;  ///< names, in the order of the model
  std::vector<Geom> geoms;          ///< those that can be seen
  std::vector<Mesh> meshes;         ///< of large ones the box around them
  std::vector<Texture> textures;    ///< of meshes, at most most_texels wide and high
  static constexpr int most_texels = 1024;
};

/// Geoms of other shapes than those named are left out.
[[nodiscard]] SceneOutline scene_outline(const World& world);

/// The pose of a body now, world frame.
[[nodiscard]] Eigen::Isometry3d world_from_body(const World& world, std::size_t body);

}  // namespace saccade
