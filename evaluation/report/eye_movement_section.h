#pragma once

#include <span>
#include <string>

#include "evaluation/report/figures.h"
#include "evaluation/report/html.h"
#include "evaluation/report/run_data.h"
#include "evaluation/scoring/eye_movement_score.h"

namespace saccade {

/// The section "Eye movements" of a run's report: figures of EyeMovementScore, directions of gaze and ball over time, speeds of
/// the ball's image. Empty for a run without them. Throws RunError as figures.h says.
[[nodiscard]] std::string eye_movement_section(const RunData& run);

/// The figures of one run, or of several side by side.
struct EyeMovementColumn {
  std::string label;
  const EyeMovementScore* score;  ///< not null
};
[[nodiscard]] std::string eye_movement_table(std::span<const EyeMovementColumn> columns);

/// Gain and phase over frequency (Bode plot): of pursuit as `pursuit`, and of the counter-rotation against the body's sway.
/// Columns of the same label are joined; empty where no label has two frequencies.
[[nodiscard]] std::string bode_figures(std::span<const EyeMovementColumn> columns,
                                       const FigureFolder& folder);

}  // namespace saccade
