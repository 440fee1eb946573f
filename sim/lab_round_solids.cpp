#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "sim/lab_layout.h"

namespace saccade::lab {
namespace {

using Eigen::Vector3d;

using std::numbers::pi;
constexpr int sides = 32;  ///< of a round outline

Vector3d around(double angle_rad) { return {std::cos(angle_rad), std::sin(angle_rad), 0.0}; }

}  // namespace

void Layout::add_disc(Facing wall, Spot spot, double radius_m, std::size_t patch) {
  const Eigen::Matrix3d axes = axes_of(wall);
  const Vector3d centre = position_of(wall, spot);
  const auto corner = [&](double share, double angle_rad) {
    const Vector3d out = share * around(angle_rad);
    return Corner{centre + radius_m * (axes * out), axes.col(2), 0.5 + 0.5 * out.x(), 0.5 - 0.5 * out.y()};
  };
  for (int i = 0; i < sides; ++i) {
    const double angle_rad = 2.0 * pi * i / sides;
    triangles_.push_back(
        {{corner(0.0, 0.0), corner(1.0, angle_rad), corner(1.0, angle_rad + 2.0 * pi / sides)}, patch});
  }
}

void Layout::add_column(const Vector3d& foot_m, double radius_m, double height_m, std::size_t patch) {
  const auto corner = [&](int side, double up, const Vector3d& normal) {
    return Corner{foot_m + radius_m * around(2.0 * pi * side / sides) + Vector3d(0.0, 0.0, up * height_m),
                  normal, static_cast<double>(side) / sides, 1.0 - up};
  };
  for (int i = 0; i < sides; ++i) {
    const Vector3d here = around(2.0 * pi * i / sides);
    const Vector3d next = around(2.0 * pi * (i + 1) / sides);
    triangles_.push_back({{corner(i, 0.0, here), corner(i + 1, 0.0, next), corner(i + 1, 1.0, next)}, patch});
    triangles_.push_back({{corner(i, 0.0, here), corner(i + 1, 1.0, next), corner(i, 1.0, here)}, patch});
    const Vector3d up = Vector3d::UnitZ();
    const Corner middle{foot_m + height_m * up, up, 0.5, 0.0};
    triangles_.push_back({{corner(i, 1.0, up), corner(i + 1, 1.0, up), middle}, patch});
  }
}

void Layout::add_ball(const Vector3d& centre_m, double radius_m, std::size_t patch) {
  constexpr int stacks = sides / 2;
  const auto corner = [&](int stack, int slice) {
    const double polar_rad = pi * stack / stacks;
    const Vector3d direction =
        std::sin(polar_rad) * around(2.0 * pi * slice / sides) + Vector3d(0.0, 0.0, std::cos(polar_rad));
    return Corner{centre_m + radius_m * direction, direction, static_cast<double>(slice) / sides,
                  static_cast<double>(stack) / stacks};
  };
  for (int stack = 0; stack < stacks; ++stack) {
    for (int slice = 0; slice < sides; ++slice) {
      const Corner a = corner(stack, slice);
      const Corner c = corner(stack + 1, slice + 1);
      if (stack + 1 < stacks) triangles_.push_back({{a, corner(stack + 1, slice), c}, patch});
      if (stack > 0) triangles_.push_back({{a, c, corner(stack, slice + 1)}, patch});
    }
  }
}

}  // namespace saccade::lab
