#include "sim/lab_layout.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

namespace saccade::lab {
namespace {

using Eigen::Vector3d;

using std::numbers::pi;

}  // namespace

Eigen::Matrix3d axes_of(Facing facing) {
  Vector3d right = Vector3d::UnitY();
  Vector3d up = Vector3d::UnitZ();
  switch (facing) {
    case Facing::back_wall:
      break;
    case Facing::left_wall:
      right = -Vector3d::UnitX();
      break;
    case Facing::right_wall:
      right = Vector3d::UnitX();
      break;
    case Facing::rear_wall:
      right = -Vector3d::UnitY();
      break;
    case Facing::up:
      up = -Vector3d::UnitX();
      break;
    case Facing::down:
      up = Vector3d::UnitX();
      break;
  }
  Eigen::Matrix3d axes;
  axes << right, up, right.cross(up);
  return axes;
}

std::size_t Layout::add_patch(double width_m, double height_m, double texels_per_m, Painter paint) {
  const auto texels = [&](double m) { return std::clamp(static_cast<int>(m * texels_per_m), 16, 640); };
  patches_.push_back({texels(width_m), texels(height_m), width_m, height_m, std::move(paint)});
  return patches_.size() - 1;
}

void Layout::add_solid(const Vector3d& centre_m, const std::array<double, 3>& half_m, std::size_t patch,
                       Facing facing) {
  const Eigen::Matrix3d axes = axes_of(facing);
  const auto face = [&](Vector3d right, Vector3d up) {
    const Vector3d out = right.cross(up);
    const Vector3d half(half_m[0], half_m[1], half_m[2]);
    const auto corner = [&](double x, double y) {
      return Corner{centre_m + axes * half.cwiseProduct(out + x * right + y * up), axes * out, 0.5 + 0.5 * x,
                    0.5 - 0.5 * y};
    };
    triangles_.push_back({{corner(-1, -1), corner(1, -1), corner(1, 1)}, patch});
    triangles_.push_back({{corner(-1, -1), corner(1, 1), corner(-1, 1)}, patch});
  };
  const Vector3d x = Vector3d::UnitX();
  const Vector3d y = Vector3d::UnitY();
  const Vector3d z = Vector3d::UnitZ();
  face(x, y);
  face(-z, y);
  face(z, y);
  face(x, -z);
  face(x, z);
  face(-x, y);
  ++solids_;
}

void Layout::add_box(Facing wall, Spot spot, double width_m, double height_m, double depth_m,
                     std::size_t patch) {
  spot.out_m += 0.5 * depth_m;
  add_solid(position_of(wall, spot), {0.5 * width_m, 0.5 * height_m, 0.5 * depth_m}, patch, wall);
}

void Layout::add_panel(Facing wall, Spot spot, double width_m, double height_m, double texels_per_m,
                       Painter paint) {
  // Where two overlap, one is in front.
  const double thickness_m = 0.015 + 0.004 * (solids_ % 8);
  add_box(wall, spot, width_m, height_m, thickness_m,
          add_patch(width_m, height_m, texels_per_m, std::move(paint)));
}

void Layout::add_lump(const Vector3d& centre_m, const Vector3d& half_m, double spikes, std::size_t patch,
                      RandomGenerator& random) {
  constexpr int slices = 12;
  constexpr int stacks = 6;
  std::array<std::array<Vector3d, slices>, stacks + 1> points;
  for (int stack = 0; stack <= stacks; ++stack) {
    for (int slice = 0; slice < slices; ++slice) {
      const double polar = pi * stack / stacks;
      const double around = 2.0 * pi * slice / slices;
      const bool pole = stack == 0 || stack == stacks;
      const Vector3d direction(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around),
                               std::cos(polar));
      const double r = 1.0 + (pole ? 0.0 : spikes * random.real(-1.0, 1.0));
      points[static_cast<std::size_t>(stack)][static_cast<std::size_t>(slice)] =
          centre_m + r * half_m.cwiseProduct(direction);
    }
  }
  const auto corner = [&](int stack, int slice) {
    return Corner{points[static_cast<std::size_t>(stack)][static_cast<std::size_t>(slice % slices)],
                  Vector3d::Zero(), static_cast<double>(slice) / slices, static_cast<double>(stack) / stacks};
  };
  const auto facet = [&](Corner a, Corner b, Corner c) {
    a.normal = b.normal = c.normal = (b.point_m - a.point_m).cross(c.point_m - a.point_m).normalized();
    triangles_.push_back({{a, b, c}, patch});
  };
  for (int stack = 0; stack < stacks; ++stack) {
    for (int slice = 0; slice < slices; ++slice) {
      if (stack + 1 < stacks)
        facet(corner(stack, slice), corner(stack + 1, slice), corner(stack + 1, slice + 1));
      if (stack > 0) facet(corner(stack, slice), corner(stack + 1, slice + 1), corner(stack, slice + 1));
    }
  }
}

void Layout::add_room(Painter back, Painter left, Painter right, Painter rear, Painter floor,
                      Painter ceiling) {
  const double middle_x = 0.5 * (rear_m + back_m_);
  const double middle_z = 0.5 * (ceiling_m + floor_m);
  // Outside the room, so that the painted faces are its inside.
  const auto wall = [&](Facing facing, double width_m, Painter paint) {
    add_box(facing, {0.0, middle_z, -0.1}, width_m, height_m(), 0.1,
            add_patch(width_m, height_m(), 125.0, std::move(paint)));
  };
  wall(Facing::back_wall, back_width_m(), std::move(back));
  wall(Facing::left_wall, side_length_m(), std::move(left));
  wall(Facing::right_wall, side_length_m(), std::move(right));
  wall(Facing::rear_wall, back_width_m(), std::move(rear));
  const std::array<double, 3> slab{side_m, 0.5 * side_length_m(), 0.05};
  add_solid({middle_x, 0.0, floor_m - 0.05}, slab,
            add_patch(back_width_m(), side_length_m(), 100.0, std::move(floor)), Facing::up);
  add_solid({middle_x, 0.0, ceiling_m + 0.05}, slab,
            add_patch(back_width_m(), side_length_m(), 80.0, std::move(ceiling)), Facing::down);
}

void Layout::pack() {
  std::vector<Patch*> order;
  for (Patch& patch : patches_) order.push_back(&patch);
  std::stable_sort(order.begin(), order.end(),
                   [](const auto* a, const auto* b) { return a->rows > b->rows; });
  int left = 0;
  int top = 0;
  for (Patch* patch : order) {
    if (left + patch->columns + 2 * rim > texture_columns) {
      left = 0;
      top = texture_rows_;
    }
    patch->left = left + rim;
    patch->top = top + rim;
    left += patch->columns + 2 * rim;
    texture_rows_ = std::max(texture_rows_, top + patch->rows + 2 * rim);
  }
}

Vector3d Layout::position_of(Facing wall, Spot s) const {
  const double middle_x = 0.5 * (rear_m + back_m_);
  switch (wall) {
    case Facing::left_wall:
      return {middle_x - s.along_m, -side_m + s.out_m, s.height_m};
    case Facing::right_wall:
      return {middle_x + s.along_m, side_m - s.out_m, s.height_m};
    case Facing::rear_wall:
      return {rear_m - s.out_m, -s.along_m, s.height_m};
    default:
      return {back_m_ + s.out_m, s.along_m, s.height_m};
  }
}

}  // namespace saccade::lab
