#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "sim/canvas.h"
#include "sim/lab.h"

namespace saccade {

/// Luminance of a matt surface in a lab's light, where white at its brightest is 1. Besides the lamps of the lab there is
/// MuJoCo's headlight, which goes from the eye to the surface. `normal`: unit vector, root frame; `towards`: direction from
/// the eye, of any length.
[[nodiscard]] double lab_luminance(const LabConfig& config, const Eigen::Vector3d& normal,
                                   const Eigen::Vector3d& towards, const std::array<double, 3>& rgb);

/// What an eye would see of a lab, one ray at a time and without OpenGL: paints what the rays meet.
class LabProbe {
 public:
  LabProbe(const LabConfig& config, std::uint64_t seed);

  /// Luminance of the first surface on the ray, where white at its brightest is 1; 0 if the ray meets none.
  [[nodiscard]] double luminance(const Eigen::Vector3d& from_m, const Eigen::Vector3d& direction);

 private:
  LabConfig config_;
  Lab lab_;
  std::vector<std::optional<Canvas>> patches_;  ///< painted when the first ray meets them
};

}  // namespace saccade
