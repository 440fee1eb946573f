#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "sim/lab_painters.h"

namespace saccade::lab {

// Planes of the room, m, root frame (x backward, y right, z up).
inline constexpr double floor_m = -0.62;
inline constexpr double ceiling_m = 1.95;
inline constexpr double side_m = 1.9;  ///< distance of the left and the right wall
inline constexpr double rear_m = 1.7;  ///< the wall behind the robot

/// Direction of a solid's painted face.
enum class Facing { back_wall, left_wall, right_wall, rear_wall, up, down };

/// The axes of a solid (x right, y up, z out of the painted face) as columns, in the root frame.
[[nodiscard]] Eigen::Matrix3d axes_of(Facing facing);

/// A painted surface and its place in the texture that holds all of them.
struct Patch {
  int columns = 0;
  int rows = 0;
  double width_m = 0.0;
  double height_m = 0.0;
  Painter paint;
  int left = 0;  ///< texels
  int top = 0;
};

/// A corner of a triangle: position and normal in the root frame, position in its patch (0 to 1, y down).
struct Corner {
  Eigen::Vector3d point_m;
  Eigen::Vector3d normal;
  double u = 0.0;
  double v = 0.0;
};

struct Triangle {
  std::array<Corner, 3> corners;  ///< counterclockwise from outside
  std::size_t patch = 0;
};

/// A point on a wall: metres along it (to the right for a viewer in the room), height, and distance into the room.
struct Spot {
  double along_m = 0.0;
  double height_m = 0.0;
  double out_m = 0.0;
};

/// The geometry of a lab: triangles, and the painted patches on them, packed into one texture.
class Layout {
 public:
  static constexpr int texture_columns = 2048;
  static constexpr int rim = 2;  ///< texels around a patch

  /// `back_m`: x of the wall in front of the robot, root frame.
  explicit Layout(double back_m) : back_m_(back_m) {}

  [[nodiscard]] const std::vector<Triangle>& triangles() const { return triangles_; }
  [[nodiscard]] const std::vector<Patch>& patches() const { return patches_; }
  /// Rows of the texture; 0 before pack().
  [[nodiscard]] int texture_rows() const { return texture_rows_; }

  [[nodiscard]] double back_m() const { return back_m_; }
  [[nodiscard]] double back_width_m() const { return 2.0 * side_m; }
  [[nodiscard]] double side_length_m() const { return rear_m - back_m_; }
  [[nodiscard]] double height_m() const { return ceiling_m - floor_m; }

  /// Returns the patch's index.
  std::size_t add_patch(double width_m, double height_m, double texels_per_m, Painter paint);
  /// A cuboid with the whole patch on each of its six faces. `half_m`: half its extents along the axes of `facing`:
  /// to the right and up on the painted face, and out of it.
  void add_solid(const Eigen::Vector3d& centre_m, const std::array<double, 3>& half_m, std::size_t patch,
                 Facing facing = Facing::back_wall);
  /// A cuboid that stands against a wall.
  void add_box(Facing wall, Spot spot, double width_m, double height_m, double depth_m, std::size_t patch);
  /// A thin cuboid that hangs on a wall, with a patch of its own. Of two that overlap one is in front.
  void add_panel(Facing wall, Spot spot, double width_m, double height_m, double texels_per_m, Painter paint);
  /// A flat round thing that hangs on a wall; `spot` is its middle, the patch a square around it.
  void add_disc(Facing wall, Spot spot, double radius_m, std::size_t patch);
  /// An upright cylinder that stands on `foot_m`, the patch around it.
  void add_column(const Eigen::Vector3d& foot_m, double radius_m, double height_m, std::size_t patch);
  /// A smooth sphere.
  void add_ball(const Eigen::Vector3d& centre_m, double radius_m, std::size_t patch);
  /// An ellipsoid with flat facets whose corners are moved in and out by up to `spikes` of its size.
  void add_lump(const Eigen::Vector3d& centre_m, const Eigen::Vector3d& half_m, double spikes,
                std::size_t patch, RandomGenerator& random);
  /// Walls, floor and ceiling.
  void add_room(Painter back, Painter left, Painter right, Painter rear, Painter floor, Painter ceiling);

  /// Packs the patches into the texture side by side in rows, the tallest first. Call once, after the last patch.
  void pack();

 private:
  [[nodiscard]] Eigen::Vector3d position_of(Facing wall, Spot spot) const;

  double back_m_;
  int solids_ = 0;
  int texture_rows_ = 0;
  std::vector<Patch> patches_;
  std::vector<Triangle> triangles_;
};

}  // namespace saccade::lab
