#pragma once

#include <string>

#include "evaluation/report/run_data.h"

namespace saccade {

/// The images of a run's report, as HTML figures; empty where the run has nothing to show. Throw InputError for a
/// saved image that cannot be read or has another size than the camera.

/// The eye's images with events, truth and detections, and the scene beside them where it was saved.
[[nodiscard]] std::string frames_figure(const RunData& run);
/// The accumulated Hough spaces over the events (paper, Fig. 2).
[[nodiscard]] std::string hough_figure(const RunData& run);
/// The eye's images before and after the largest gaze shifts (paper, Fig. 6).
[[nodiscard]] std::string shifts_figure(const RunData& run);

}  // namespace saccade
