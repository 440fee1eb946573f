#include "sim/lab_probe.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>

#include "sim/lab_layout.h"

namespace saccade {
namespace {

using Eigen::Vector3d;

/// Rec. 709's share of the channels in luminance.
constexpr std::array<double, 3> luma = {0.2126, 0.7152, 0.0722};

struct Hit {
  double distance;  ///< in lengths of the ray's direction
  double b, c;      ///< shares of the triangle's second and third corner
};

/// Where a ray meets the front of a triangle (Moeller and Trumbore 1997).
std::optional<Hit> hit(const lab::Triangle& triangle, const Vector3d& from_m, const Vector3d& direction) {
  const Vector3d& a = triangle.corners[0].point_m;
  const Vector3d ab = triangle.corners[1].point_m - a;
  const Vector3d ac = triangle.corners[2].point_m - a;
  const Vector3d p = direction.cross(ac);
  const double determinant = ab.dot(p);
  if (!(determinant > 1e-12)) return std::nullopt;  // from behind
  const Vector3d from_a = from_m - a;
  const double b = from_a.dot(p) / determinant;
  const Vector3d q = from_a.cross(ab);
  const double c = direction.dot(q) / determinant;
  const double distance = ac.dot(q) / determinant;
  if (b < 0.0 || c < 0.0 || b + c > 1.0 || distance <= 0.0) return std::nullopt;
  return Hit{distance, b, c};
}

}  // namespace

double lab_luminance(const LabConfig& config, const Vector3d& normal, const Vector3d& towards,
                     const std::array<double, 3>& rgb) {
  // MuJoCo's default of visual/headlight.
  constexpr double head_ambient = 0.1;
  constexpr double head_diffuse = 0.4;
  double light = head_ambient + head_diffuse * std::max(0.0, -normal.dot(towards.normalized()));
  for (const LabLight& lamp : lab_lights(config)) {
    light += lamp.ambient + lamp.diffuse * std::max(0.0, -normal.dot(lamp.direction.normalized()));
  }
  double luminance = 0.0;
  for (std::size_t i = 0; i < 3; ++i) luminance += luma[i] * std::min(1.0, light * rgb[i]);
  return luminance;
}

LabProbe::LabProbe(const LabConfig& config, std::uint64_t seed)
    : config_(config), lab_(config, seed), patches_(lab_.layout().patches().size()) {}

double LabProbe::luminance(const Vector3d& from_m, const Vector3d& direction) {
  const lab::Triangle* nearest = nullptr;
  Hit at{};
  for (const lab::Triangle& triangle : lab_.layout().triangles()) {
    const auto found = hit(triangle, from_m, direction);
    if (!found || (nearest != nullptr && found->distance >= at.distance)) continue;
    nearest = &triangle;
    at = *found;
  }
  if (nearest == nullptr) return 0.0;
  const auto& [a, b, c] = nearest->corners;
  const double first = 1.0 - at.b - at.c;
  std::optional<Canvas>& canvas = patches_[nearest->patch];
  if (!canvas) canvas.emplace(lab_.painted(nearest->patch));
  const auto texel = [](double share, int count) {
    return std::clamp(static_cast<int>(share * count), 0, count - 1);
  };
  const double u = first * a.u + at.b * b.u + at.c * c.u;
  const double v = first * a.v + at.b * b.v + at.c * c.v;
  const Reflectance colour =
      lab_.with_contrast(canvas->texel(texel(u, canvas->columns()), texel(v, canvas->rows())));
  const Vector3d normal = (first * a.normal + at.b * b.normal + at.c * c.normal).normalized();
  return lab_luminance(config_, normal, direction, {colour.r, colour.g, colour.b});
}

}  // namespace saccade
