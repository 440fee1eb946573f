#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "core/config.h"

namespace saccade {

/// A white board with an asymmetric grid of dark dots, for camera calibration. It rests at one pose after another and
/// moves from each to the next.
///
/// Board frame: origin in the middle of the grid, x along a row, y from row to row, z into the board; a camera in front
/// of it has about the same axes. Dot k of row i is at (2 k + i % 2, i) spacings from the first one, OpenCV's numbering
/// of an asymmetric grid. With an odd number of rows its orientation is unambiguous.
struct BoardConfig {
  std::int64_t columns = 4;  ///< dots in a row
  std::int64_t rows = 7;
  double spacing_mm = 25.0;  ///< from row to row, and half the distance of the dots in a row
  double dot_diameter_mm = 21.0;
  double border_mm = 40.0;  ///< width of the white border around the centres of the outer dots
  /// Poses at rest: middle of the grid, root frame, and rotation vector in the board frame. At rotation 0 the board
  /// faces the robot upright.
  std::vector<Eigen::Vector3d> positions_m = {Eigen::Vector3d(-0.33, -0.034, 0.347)};
  std::vector<Eigen::Vector3d> rotations_deg = {Eigen::Vector3d::Zero()};
  double rest_s = 5.0;  ///< rest at each pose
  double move_s = 0.5;  ///< time from one pose to the next, minimum jerk; it stays at the last one
};

/// Keys: columns, rows, spacing_mm, dot_diameter_mm, border_mm, positions_m, rotations_deg, rest_s, move_s.
void describe(FieldVisitor& v, BoardConfig& config);

/// Pose of the board at a time.
[[nodiscard]] Eigen::Isometry3d root_from_board(const BoardConfig& config, std::int64_t t_us);

/// The board as MJCF elements: the mocap body `board`, whose frame is the board's. Its texture has one colour until
/// paint_board(). Throws InputError for a config out of range.
[[nodiscard]] std::string board_mjcf(const BoardConfig& config);

/// Paints the dots into a compiled model that holds board_mjcf(config). Call before a renderer uploads the texture.
void paint_board(mjModel& model, const BoardConfig& config);

}  // namespace saccade
