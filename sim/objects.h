#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/config.h"
#include "sim/trajectory.h"

namespace saccade {

/// Something else that moves before the robot: what draws attention, or hides the ball.
struct ObjectConfig {
  std::string shape = "box";  ///< box, cylinder (upright), ellipsoid or person
  /// Its extent along x, y, z (of a cylinder x is the diameter); a person is 1.72 m tall.
  std::vector<double> size_m = {0.08, 0.08, 0.08};
  std::vector<double> rgb = {0.10, 0.25, 0.60};  ///< reflectance, linear; of a person's shirt
  /// Of its centre. Of a person the point on the floor between the feet; it walks the way it goes first (along
  /// y, where it has no waypoints), as upright when it turns back.
  TrajectoryConfig trajectory;
};

/// Keys: shape, size_m (not of a person), rgb, trajectory.
void describe(FieldVisitor& v, ObjectConfig& config);

using NamedObjects = std::vector<std::pair<std::string, ObjectConfig>>;

/// Each object under its name.
void describe(FieldVisitor& v, NamedObjects& objects);

/// The objects as MJCF elements for World: mocap bodies whose names begin with `distractor`; nothing where there
/// are none.
[[nodiscard]] std::string objects_mjcf(const NamedObjects& objects);

/// Moves the bodies of objects_mjcf along the objects' trajectories.
class Objects {
 public:
  /// `model` holds objects_mjcf(objects). Each object has a sway of its own. Throws InputError.
  Objects(const NamedObjects& objects, std::uint64_t seed, const mjModel& model);

  /// Puts the bodies to where they are at t_us; kinematics is the caller's.
  void place(std::int64_t t_us, mjData& data) const;

 private:
  struct Part {
    int mocap;
    Eigen::Vector3d joint_m;  ///< where its origin is in the object, x the way it goes
    double swing_rad;         ///< largest angle about the object's y axis
  };
  struct Object {
    Trajectory trajectory;
    double heading_rad;  ///< about z
    std::vector<Part> parts;
  };
  std::vector<Object> objects_;
};

}  // namespace saccade
