#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/camera.h"
#include "evaluation/report/gnuplot.h"
#include "evaluation/scoring/eye_movement.h"
#include "head/head_state.h"
#include "recording/run_files.h"

namespace saccade {

/// Figures of a run's gaze. Bytes, names, times and errors as in figures.h.

/// The tables that the figures of a gaze are made of; any may be empty.
struct GazeTables {
  std::span<const TruthRow> truth;
  std::span<const GazeRow> gaze;
  std::span<const EyeRow> eye;
};

/// The angle between the left eye's axis and the ball's centre, deg, above the speed of that axis, deg/s. The targets
/// are marked at the bottom, wrong ones (see is_wrong_move; only with a camera) at the top; saccades are bands, acquisition is
/// an upright line. Errors before acquisition may lie outside the axes.
[[nodiscard]] Figure gaze_over_time_figure(std::string_view name, const GazeTables& tables,
                                           const std::optional<Camera>& camera,
                                           std::optional<std::int64_t> acquired_at_us, std::int64_t start_us);

/// Peak speed of saccades over their size, the "main sequence".
[[nodiscard]] Figure main_sequence_figure(std::string_view name, std::span<const Saccade> saccades,
                                          std::int64_t start_us);

/// A run's gaze in the robot's root frame.
struct GazePath {
  std::string label;  ///< may be empty
  GazeTables tables;
  std::int64_t start_us = 0;
};
/// Ball, gaze targets and gaze (paper, Fig. 7), a row for each run: the plane in front of the robot (y, z) and, on the
/// same scale, the side view (-x, z). The gaze is the fixation point; where the eyes do not converge for most of the
/// run, the left eye's axis at the ball's distance.
[[nodiscard]] Figure gaze_paths_figure(std::string_view name, std::span<const GazePath> gazes);

/// Each head joint over time against its limits, deg.
[[nodiscard]] Figure joints_figure(std::string_view name, std::span<const GazeRow> gaze,
                                   const JointLimits& limits, std::int64_t start_us);

}  // namespace saccade
