#pragma once

#include <Eigen/Geometry>
#include <array>
#include <string>

#include "core/config.h"
#include "sim/motion_track.h"

namespace saccade {

/// The body that moves, as MJCF elements; an empty one is a ball of 9.5 cm.
struct BodyShape {
  std::string assets;  ///< inside <asset>
  std::string geoms;   ///< inside <body>
  Eigen::Quaterniond turn =
      Eigen::Quaterniond::Identity();  ///< of the body at the start; motions are relative to it
};

/// How a body touches the surface below it.
struct SurfaceContact {
  double bounce = 0.7;    ///< speed after a straight bounce over the speed before
  double friction = 0.4;  ///< coefficient of sliding friction
};

/// A body that is thrown and bounces on a horizontal surface.
struct BallisticConfig {
  Eigen::Vector3d from_m = {-0.6, -0.4, 0.4};
  Eigen::Vector3d velocity_m_s = {0.0, 0.8, 1.0};
  std::array<double, 3> spin_deg_s = {0.0, 0.0, 0.0};  ///< rotation vector
  double surface_m = 0.0;                              ///< height of the surface, root frame
  SurfaceContact contact;
  double lasts_s = 10.0;
};

/// A body that rests on a horizontal surface and is pushed; it slides or rolls until friction stops it.
struct PushConfig {
  Eigen::Vector3d from_m = {-0.55, -0.15, 0.35};  ///< the surface is just below the body
  Eigen::Vector2d push_m_s = {0.0, 0.6};  ///< velocity that an unhindered body would have after the push
  double push_s = 0.1;
  double friction = 0.2;
  double lasts_s = 10.0;
};

/// Keys: from_m, velocity_m_s, spin_deg_s, surface_m, bounce, friction, lasts_s.
void describe(FieldVisitor& v, BallisticConfig& config);
/// Keys: from_m, push_m_s, push_s, friction, lasts_s.
void describe(FieldVisitor& v, PushConfig& config);

/// The motion of a body as MuJoCo computes it, with steps of 0.1 ms, sampled every 1 ms: from time 0 until the body rests
/// or `lasts_s` is over. The body keeps its pose from then on.
/// Throws InputError at `place` where the body begins inside the surface, and for a shape that MuJoCo rejects.
[[nodiscard]] MotionTrack ballistic_motion(const BallisticConfig& config, const BodyShape& shape,
                                           const std::string& place);
[[nodiscard]] MotionTrack pushed_motion(const PushConfig& config, const BodyShape& shape,
                                        const std::string& place);

/// The damping ratio of a spring and damper against which a mass bounces with this ratio of speeds, in (0, 1).
/// Source: Schwager and Poeschel, Granular Matter 9, 2007.
[[nodiscard]] double damping_ratio_of_bounce(double bounce);

}  // namespace saccade
