#pragma once

#include <Eigen/Core>

#include "core/camera.h"

namespace saccade {

/// A detector's best circle at an instant, before any threshold.
struct Observation {
  Circle circle;                                             ///< image pixels; finite
  double score = 0.0;                                        ///< on the detector's own scale; finite
  Eigen::Matrix3d covariance_px2 = Eigen::Matrix3d::Zero();  ///< of (x, y, r), px^2; zero: unknown
};

}  // namespace saccade
