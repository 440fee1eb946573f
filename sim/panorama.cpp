#include "sim/panorama.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/units.h"
#include "sim/triangle_mesh.h"

namespace saccade {
namespace {

using Eigen::Vector3d;
using std::numbers::pi;

const Vector3d eyes_m(-0.06, 0.0, 0.34);  // about, root frame
constexpr int panorama_slices = 48;
constexpr int panorama_stacks = 24;

/// The direction of a point of the photograph, 0 to 1 to the right and down.
Vector3d direction_of(double u, double v, double heading_rad) {
  const double azimuth = 2.0 * pi * (u - 0.5) + heading_rad;
  const double elevation = pi * (0.5 - v);
  return {-std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
          std::sin(elevation)};
}

/// The sphere, seen from inside, and a cube around it: MuJoCo takes closed solids only.
TriangleMesh shell(double radius_m, double heading_rad) {
  TriangleMesh mesh;
  const auto corner = [&](int slice, int stack) {
    const double u = static_cast<double>(slice) / panorama_slices;
    const double v = static_cast<double>(stack) / panorama_stacks;
    mesh.points_m.push_back(eyes_m + radius_m * direction_of(u, v, heading_rad));
    mesh.texels.emplace_back(u, v);
    const int index = static_cast<int>(mesh.points_m.size()) - 1;
    return TriangleMesh::Corner{index, index};
  };
  for (int stack = 0; stack < panorama_stacks; ++stack) {
    for (int slice = 0; slice < panorama_slices; ++slice) {
      const auto top_left = corner(slice, stack);
      const auto bottom_left = corner(slice, stack + 1);
      const auto bottom_right = corner(slice + 1, stack + 1);
      const auto top_right = corner(slice + 1, stack);
      if (stack + 1 < panorama_stacks) mesh.triangles.push_back({top_left, bottom_left, bottom_right});
      if (stack > 0) mesh.triangles.push_back({top_left, bottom_right, top_right});
    }
  }
  const int first = static_cast<int>(mesh.points_m.size());
  for (int i = 0; i < 8; ++i) {
    const Vector3d side((i & 1) != 0 ? 1.0 : -1.0, (i & 2) != 0 ? 1.0 : -1.0, (i & 4) != 0 ? 1.0 : -1.0);
    mesh.points_m.push_back(eyes_m + 1.1 * radius_m * side);
  }
  constexpr std::array<std::array<int, 4>, 6> sides = {
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& side : sides) {
    const auto at = [&](std::size_t k) { return TriangleMesh::Corner{first + side[k], 0}; };
    mesh.triangles.push_back({at(0), at(1), at(2)});
    mesh.triangles.push_back({at(0), at(2), at(3)});
  }
  return mesh;
}

}  // namespace

void describe(FieldVisitor& v, PanoramaConfig& c) {
  v.path("panorama", c.file,
         "equirectangular photograph, a PNG twice as wide as high; relative to the scenario");
  v.require(!c.file.empty(), "panorama", "no such key", "the path of a photograph");
  v.real("heading_deg", c.heading_deg, {-360.0, 360.0},
         "how far the photograph is turned to the right; its middle is ahead at 0");
  v.real("distance_m", c.distance_m, {2.0, 6.0}, "distance from the head to the photograph");
  v.real("photo_brightness", c.brightness, {0.05, 4.0}, "factor of the photograph's luminance");
}

ModelParts panorama_parts(const PanoramaConfig& config, const std::string& prefix) {
  TextureImage image = read_png(config.file, prefix + "_photograph");
  if (image.width != 2 * image.height) {
    throw InputError(config.file,
                     std::to_string(image.width) + "x" + std::to_string(image.height) + " pixels",
                     "an equirectangular photograph, twice as wide as high");
  }
  for (mjtByte& value : image.rgb) {
    value = static_cast<mjtByte>(std::lround(std::min(255.0, config.brightness * value)));
  }
  ModelParts parts;
  const std::string mesh = prefix + "_sphere";
  // Emission lights a surface fully, whatever the lights of the room.
  parts.assets = texture_mjcf(image) + "<material name=\"" + prefix + "\" texture=\"" + image.name +
                 "\" emission=\"1\" specular=\"0\" shininess=\"0\"/>\n" +
                 mesh_mjcf(shell(config.distance_m, config.heading_deg * rad_per_deg), mesh);
  parts.geoms = "<geom name=\"" + prefix + "\" type=\"mesh\" mesh=\"" + mesh + "\" material=\"" + prefix +
                "\" group=\"1\" contype=\"0\" conaffinity=\"0\"/>\n";
  parts.textures.push_back(std::move(image));
  return parts;
}

}  // namespace saccade
