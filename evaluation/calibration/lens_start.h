#pragma once

#include <vector>

#include "evaluation/calibration/board_fit.h"
#include "evaluation/calibration/calibration_views.h"

namespace saccade {

/// Where the fit of a lens begins, with one board for each view.
///   radial_tangential  what cv::calibrateCamera() finds
///   fisheye            the best equidistant lens (k1 to k4 of 0, its axis through the middle of the image) out of those whose
///                      corners are 15 to 85 deg off the axis
[[nodiscard]] BoardModel start_of_lens(const std::vector<CalibrationView>& views, const DotGrid& grid,
                                       ImageSize size, LensModel lens);

}  // namespace saccade
