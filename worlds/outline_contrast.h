#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "sim/ball.h"
#include "sim/lab_probe.h"
#include "sim/sim_config.h"
#include "worlds/camera_path.h"

namespace saccade {

/// The contrast of a ball's outline against the lab behind it, at some instants of its motion. Hands, objects and highlights
/// are left out.
class OutlineContrast {
 public:
  /// Follows the ball along the path. `radius_m`: its radius.
  OutlineContrast(const LabConfig& lab, std::uint64_t seed, const CameraPath& path, const Camera& camera,
                  const Trajectory& ball, double radius_m);

  /// Share of the outline, over all instants, at which the difference of log luminance is at least two thresholds of the
  /// sensor (the mean of ON and OFF); 0 if the ball is never in the image.
  [[nodiscard]] double share(const BallConfig& ball, const EmulatorConfig& sensor) const;

 private:
  struct Point {
    Eigen::Vector3d normal;   ///< of the ball at its outline, root frame
    Eigen::Vector3d towards;  ///< from the eye to the ball, root frame
    double behind;            ///< luminance of the lab next to it; 1 is white at its brightest
  };

  LabConfig lab_;
  std::vector<Point> points_;
};

}  // namespace saccade
