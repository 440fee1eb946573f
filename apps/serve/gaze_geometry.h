#pragma once

#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>

#include "apps/serve/request_words.h"
#include "control/head_kinematics.h"
#include "core/camera.h"

namespace saccade {

inline constexpr double least_vergence_deg = 0.5;

/// Where a head looks with its joints at `position_rad`, and the points that requests name: root frame, m. It keeps no
/// copy of what it is made of.
class GazeGeometry {
 public:
  GazeGeometry(const HeadChain& chain, const JointVector& position_rad, const std::array<Camera, 2>& cameras)
      : chain_(chain), position_rad_(position_rad), cameras_(cameras) {}

  /// The target of a request: 3D x y z; mono left|right u v z, or u v ver vergence; stereo ul vl ur vr; ang abs|rel
  /// azimuth elevation vergence. None for other words.
  [[nodiscard]] std::optional<Eigen::Vector3d> point(const std::string& kind, RequestWords& words) const;
  /// Where the ray through a pixel of an eye meets the plane a x + b y + c z + d = 0: left|right u v a b c d.
  [[nodiscard]] std::optional<Eigen::Vector3d> on_plane(RequestWords& words) const;
  /// The fixation point; while the optical axes are parallel, where they would meet with the least vergence.
  [[nodiscard]] Eigen::Vector3d fixation_m() const;
  /// Azimuth, elevation and vergence of the fixation point, or of a point, from the head with the neck at 0, as iKinGazeCtrl
  /// defines them (getAbsAngles): of x right, y down, z ahead atan2(x, z), -atan2(y, |z|), and the vergence of eyes that look
  /// so far straight ahead.
  [[nodiscard]] Eigen::Vector3d angles_deg() const { return angles_deg(fixation_m()); }
  [[nodiscard]] Eigen::Vector3d angles_deg(const Eigen::Vector3d& point_m) const;

 private:
  const HeadChain& chain_;
  const JointVector& position_rad_;
  const std::array<Camera, 2>& cameras_;
};

/// The pinholes of both eyes, as iKinGazeCtrl reports them: projections (3 x 4, row by row) and image sizes.
[[nodiscard]] std::string pinholes_text(const std::array<Camera, 2>& cameras);
/// The same read: other intrinsics for the cameras, whose image sizes stay. False, and nothing changed, for other words.
[[nodiscard]] bool read_pinholes(RequestWords& words, std::array<Camera, 2>& cameras);

}  // namespace saccade
