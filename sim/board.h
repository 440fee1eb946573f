#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <vector>

#include "core/config.h"

namespace saccade {

/// A white board with an asymmetric grid of dark dots, to calibrate a camera with. It rests at one pose after
/// another and is carried from each to the next.
///
/// Board frame: the middle of the grid, x along a row, y from row to row, z into the board, so that a camera before
/// it has about the same axes. Dot k of row i is at (2 k + i % 2, i) spacings from the first one, as OpenCV numbers
/// an asymmetric grid. With an odd number of rows it has one way up.
struct BoardConfig {
  std::int64_t columns = 4;  ///< dots in a row
  std::int64_t rows = 7;
  double spacing_mm = 25.0;  ///< from row to row, and half the way between the dots of a row
  double dot_diameter_mm = 21.0;
  double border_mm = 40.0;  ///< of white around the middles of the outer dots
  /// Where the middle of the grid rests, root frame, and how the board is turned there: rotation vectors in the
  /// board frame; at 0 it faces the robot upright.
  std::vector<std::vector<double>> positions_m = {{-0.33, -0.034, 0.347}};
  std::vector<std::vector<double>> rotations_deg = {{0.0, 0.0, 0.0}};
  double rest_s = 5.0;  ///< at a pose
  double move_s = 0.5;  ///< from one to the next, least jerk; it stays at the last
};

/// Keys: columns, rows, spacing_mm, dot_diameter_mm, border_mm, positions_m, rotations_deg, rest_s, move_s.
void describe(FieldVisitor& v, BoardConfig& config);

/// Where the board is at a time.
[[nodiscard]] Eigen::Isometry3d root_from_board(const BoardConfig& config, std::int64_t t_us);

/// The board as MJCF elements: the mocap body `board`, whose frame is the board's. Its texture is flat;
/// paint_board fills it. Throws InputError for a config out of range.
[[nodiscard]] std::string board_mjcf(const BoardConfig& config);

/// Paints the dots into a compiled model that holds board_mjcf(config). Before a renderer uploads it.
void paint_board(mjModel& model, const BoardConfig& config);

}  // namespace saccade
