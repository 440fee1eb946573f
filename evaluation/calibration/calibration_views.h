#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <vector>

#include "core/camera.h"
#include "evaluation/calibration/grid_finder.h"

namespace saccade {

struct CalibrationLimits;

/// A grid that was found in an image, and the pose of the eye then.
struct CalibrationView {
  GridView grid;
  std::optional<Eigen::Isometry3d> root_from_eye;  ///< from the encoders; none on a bare recording
};

/// Out of all views those to calibrate with: slow, and spread over the image, distances and tilts; sorted by time.
[[nodiscard]] std::vector<CalibrationView> choose_views(const std::vector<CalibrationView>& views,
                                                        const CalibrationLimits& limits);

/// The share of the cells of a raster over the image (coverage_raster in each direction) that have a dot in them.
inline constexpr int coverage_raster = 5;
[[nodiscard]] double covered_share(const std::vector<CalibrationView>& views, ImageSize size);

/// The largest angle between the normals of two boards, deg.
[[nodiscard]] double tilt_range_deg(const std::vector<Eigen::Isometry3d>& boards);

}  // namespace saccade
