#include "sim/board.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "core/units.h"
#include "head/minimum_jerk.h"
#include "sim/mujoco_compat.h"

namespace saccade {
namespace {

constexpr double texel_mm = 0.5;
constexpr double half_thickness_m = 0.002;
constexpr double white = 0.80;  // linear reflectance
constexpr double dark = 0.03;

/// Half the extent of grid and border, mm.
Eigen::Vector2d half_size_mm(const BoardConfig& c) {
  return {0.5 * static_cast<double>(2 * c.columns - 1) * c.spacing_mm + c.border_mm,
          0.5 * static_cast<double>(c.rows - 1) * c.spacing_mm + c.border_mm};
}

Eigen::Vector2i texels(const BoardConfig& c) {
  const Eigen::Vector2d size = 2.0 * half_size_mm(c) / texel_mm;
  return {static_cast<int>(std::ceil(size.x())), static_cast<int>(std::ceil(size.y()))};
}

Eigen::Isometry3d rest_pose(const BoardConfig& c, std::size_t i) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = c.positions_m[i];
  Eigen::Matrix3d facing;  // x right, y down, z away from the robot
  facing << 0.0, 0.0, -1.0, 1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  const Eigen::Vector3d turn = c.rotations_deg[i] * rad_per_deg;
  const double angle = turn.norm();
  pose.linear() = facing;
  if (angle > 0.0) pose.linear() *= Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
  return pose;
}

}  // namespace

void describe(FieldVisitor& v, BoardConfig& c) {
  v.integer("columns", c.columns, {2, 20}, "dots in a row");
  v.integer("rows", c.rows, {3, 21}, "rows; with an odd number the orientation is unambiguous");
  v.real("spacing_mm", c.spacing_mm, {2.0, 200.0},
         "from row to row, and half the distance of the dots in a row");
  v.real("dot_diameter_mm", c.dot_diameter_mm, {1.0, 250.0}, "diameter of a dot");
  v.real("border_mm", c.border_mm, {1.0, 300.0},
         "width of the white border around the centres of the outer dots");
  v.points("positions_m", c.positions_m, {-5.0, 5.0}, "middle of the grid at rest, root frame");
  v.points("rotations_deg", c.rotations_deg, {-180.0, 180.0},
           "rotation vectors of the board at rest; 0 faces the robot");
  v.require(!c.positions_m.empty() && c.positions_m.size() == c.rotations_deg.size(), "rotations_deg",
            std::to_string(c.rotations_deg.size()) + " rotations",
            "one for each of " + std::to_string(c.positions_m.size()) + " positions, and at least one");
  v.real("rest_s", c.rest_s, {0.0, 3600.0}, "rest at each pose");
  v.real("move_s", c.move_s, {0.05, 60.0}, "time from one pose to the next");
  v.require(c.dot_diameter_mm < std::numbers::sqrt2 * c.spacing_mm, "dot_diameter_mm",
            text_of(c.dot_diameter_mm), "less than 1.41 times spacing_mm, so that dots do not touch");
  const double largest_mm = 2.0 * half_size_mm(c).maxCoeff();
  v.require(largest_mm <= 4000.0, "spacing_mm", "a board of " + text_of(largest_mm) + " mm",
            "at most 4000 mm in width and height");
}

Eigen::Isometry3d root_from_board(const BoardConfig& c, std::int64_t t_us) {
  const double t_s = static_cast<double>(std::max<std::int64_t>(t_us, 0)) * 1e-6;
  const double period_s = c.rest_s + c.move_s;
  const std::size_t last = c.positions_m.size() - 1;
  const auto at = static_cast<std::size_t>(t_s / period_s);
  if (at >= last) return rest_pose(c, last);
  const Eigen::Isometry3d from = rest_pose(c, at);
  const double u = (t_s - static_cast<double>(at) * period_s - c.rest_s) / c.move_s;
  if (u <= 0.0) return from;
  const Eigen::Isometry3d to = rest_pose(c, at + 1);
  const double share = minimum_jerk(u);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = from.translation() + share * (to.translation() - from.translation());
  pose.linear() =
      Eigen::Quaterniond(from.linear()).slerp(share, Eigen::Quaterniond(to.linear())).toRotationMatrix();
  return pose;
}

std::string board_mjcf(const BoardConfig& config) {
  check_config("board", config);
  const Eigen::Vector2d half = half_size_mm(config) * 1e-3;
  const Eigen::Vector2i size = texels(config);
  std::string points, texture_points, normals, faces;
  const auto add = [](std::string& text, std::initializer_list<double> values) {
    char number[32];
    for (const double value : values) {
      std::snprintf(number, sizeof number, "%.6f ", value);
      text += number;
    }
  };
  int count = 0;
  // A side of the box: its normal, and the two axes of its plane, right-handed with it.
  const auto side = [&](const Eigen::Vector3d& normal, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    const Eigen::Vector3d extent(half.x(), half.y(), half_thickness_m);
    const Eigen::Vector3d middle(0.0, 0.0, half_thickness_m);  // the dots' plane is z = 0
    const bool front = normal.z() < 0.0;
    for (const auto& [u, w] : {std::pair{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}) {
      const Eigen::Vector3d corner = middle + extent.cwiseProduct(normal + u * a + w * b);
      add(points, {corner.x(), corner.y(), corner.z()});
      add(normals, {normal.x(), normal.y(), normal.z()});
      // The texture's columns and rows go along x and y; the other sides show its white corner.
      if (front) {
        add(texture_points, {0.5 + 0.5 * corner.x() / half.x(), 0.5 + 0.5 * corner.y() / half.y()});
      } else {
        add(texture_points, {0.001, 0.001});
      }
    }
    for (const int i : {0, 1, 2, 0, 2, 3}) faces += std::to_string(count + i) + " ";
    count += 4;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {-1.0, 1.0}) {
      const Eigen::Vector3d a = Eigen::Vector3d::Unit((axis + 1) % 3);
      const Eigen::Vector3d b = Eigen::Vector3d::Unit((axis + 2) % 3);
      side(sign * Eigen::Vector3d::Unit(axis), sign > 0.0 ? a : b, sign > 0.0 ? b : a);
    }
  }
  return "<asset><texture name=\"board\" type=\"2d\" builtin=\"flat\" width=\"" + std::to_string(size.x()) +
         "\" height=\"" + std::to_string(size.y()) +
         "\"/><material name=\"board\" texture=\"board\" specular=\"0\" shininess=\"0\"/><mesh "
         "name=\"board\" vertex=\"" +
         points + "\" normal=\"" + normals + "\" texcoord=\"" + texture_points + "\" face=\"" + faces +
         "\"/></asset><worldbody><body name=\"board\" mocap=\"true\"><geom name=\"board\" type=\"mesh\" "
         "mesh=\"board\" "
         "material=\"board\" group=\"1\" contype=\"0\" conaffinity=\"0\"/></body></worldbody>";
}

void paint_board(mjModel& model, const BoardConfig& config) {
  const int id = mj_name2id(&model, mjOBJ_TEXTURE, "board");
  const Eigen::Vector2i size = texels(config);
  SACCADE_CHECK(id >= 0 && model.tex_width[id] == size.x() && model.tex_height[id] == size.y());
  mjtByte* texel = texture_rgb(model, id);
  const Eigen::Vector2d half_mm = half_size_mm(config);
  const Eigen::Vector2d first_mm = Eigen::Vector2d::Constant(config.border_mm);
  for (int row = 0; row < size.y(); ++row) {
    for (int column = 0; column < size.x(); ++column) {
      const Eigen::Vector2d at_mm(2.0 * half_mm.x() * (column + 0.5) / size.x(),
                                  2.0 * half_mm.y() * (row + 0.5) / size.y());
      const Eigen::Vector2d at = (at_mm - first_mm) / config.spacing_mm;
      const std::int64_t i = std::clamp<std::int64_t>(std::llround(at.y()), 0, config.rows - 1);
      double nearest_mm = 1e9;
      for (std::int64_t r = std::max<std::int64_t>(i - 1, 0); r <= std::min(i + 1, config.rows - 1); ++r) {
        const double odd = static_cast<double>(r % 2);
        const std::int64_t k =
            std::clamp<std::int64_t>(std::llround(0.5 * (at.x() - odd)), 0, config.columns - 1);
        const Eigen::Vector2d dot(2.0 * static_cast<double>(k) + odd, static_cast<double>(r));
        nearest_mm = std::min(nearest_mm, (at - dot).norm() * config.spacing_mm);
      }
      const double cover = std::clamp((0.5 * config.dot_diameter_mm - nearest_mm) / texel_mm + 0.5, 0.0, 1.0);
      const auto value = static_cast<mjtByte>(std::lround(255.0 * (white + cover * (dark - white))));
      for (int channel = 0; channel < 3; ++channel) *texel++ = value;
    }
  }
}

}  // namespace saccade
