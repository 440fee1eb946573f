#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

namespace saccade {

/// A surface of triangles, in metres, with a place in a texture at each corner if it has one.
struct TriangleMesh {
  struct Corner {
    int point = 0;
    int texel = -1;  ///< -1: none
  };
  std::vector<Eigen::Vector3d> points_m;
  std::vector<Eigen::Vector2d> texels;           ///< 0 to 1, to the right and down
  std::vector<std::array<Corner, 3>> triangles;  ///< counterclockwise from outside

  [[nodiscard]] bool has_texels() const { return !texels.empty(); }
};

/// Most triangles of a mesh. In software a triangle costs about 60 ns per image.
inline constexpr std::size_t most_triangles = 50'000;

/// Throws InputError at `place` unless the surface is closed and manifold: every edge belongs to two triangles that pass
/// it in opposite directions, the enclosed volume is positive, there are at most most_triangles. Points at the same place
/// count as one.
void check_surface(const TriangleMesh& mesh, const std::string& place);

/// The radius of a surface that is a sphere about the origin, from the mean of its corners; 0 if it is none: if a corner
/// or the middle of a triangle deviates from that radius by more than 3 %.
[[nodiscard]] double sphere_radius_m(const TriangleMesh& mesh);

/// The mesh as an MJCF element <mesh>. Edges sharper than 40 degrees stay sharp.
[[nodiscard]] std::string mesh_mjcf(const TriangleMesh& mesh, const std::string& name);

}  // namespace saccade
