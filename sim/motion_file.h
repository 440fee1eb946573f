#pragma once

#include <array>
#include <string>

#include "core/config.h"
#include "sim/motion_track.h"

namespace saccade {

/// A motion in a table, for instance of a motion-capture system.
struct MotionFileConfig {
  std::string file;        ///< path of the table
  double max_gap_s = 0.1;  ///< longest time from one row to the next
  /// Pose of the table's frame in the root frame: place of its origin, and a rotation vector.
  std::array<double, 3> origin_m = {0.0, 0.0, 0.0};
  std::array<double, 3> axes_turn_deg = {0.0, 0.0, 0.0};
};

/// Keys: file, max_gap_s, origin_m, axes_turn_deg.
void describe(FieldVisitor& v, MotionFileConfig& config);

/// A table of poses: whether it has orientations, and the poses in the root frame. The first row is at 0 s.
struct MotionTable {
  bool turns = false;
  MotionTrack track;
};

/// Reads a table of comma-separated values. Its first line names the columns: t_s, x_m, y_m, z_m, and with orientations
/// qw, qx, qy, qz (rotation in the table's axes; with 1, 0, 0, 0 the object has the axes of the root frame), in any order. Lines that are empty or begin with # are skipped. Quaternions may
/// deviate from unit length by 1 % and are normalised.
/// Throws InputError with file and line of everything that is wrong (of the first 20 rows): a missing or unknown column,
/// cells that are no finite numbers, times that do not increase, gaps longer than max_gap_s, quaternions that are
/// not of unit length, positions farther than 50 m from the root.
[[nodiscard]] MotionTable read_motion_file(const MotionFileConfig& config);

}  // namespace saccade
