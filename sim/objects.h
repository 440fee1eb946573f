#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "core/config.h"
#include "sim/trajectory.h"

namespace saccade {

/// Shape of an object; a cylinder is upright.
enum class ObjectShape { box, cylinder, ellipsoid, person };
constexpr auto words_of(ObjectShape) {
  return std::to_array<Word<ObjectShape>>({{ObjectShape::box, "box"},
                                           {ObjectShape::cylinder, "cylinder"},
                                           {ObjectShape::ellipsoid, "ellipsoid"},
                                           {ObjectShape::person, "person"}});
}

/// A moving object in front of the robot besides the ball: it distracts, or hides the ball.
struct ObjectConfig {
  ObjectShape shape = ObjectShape::box;
  /// Extent along x, y, z (a cylinder has the diameter x); a person is always 1.72 m tall.
  Eigen::Vector3d size_m = {0.08, 0.08, 0.08};
  std::array<double, 3> rgb = {0.10, 0.25, 0.60};  ///< linear reflectance; for a person that of the shirt
  /// Trajectory of its centre; for a person, of the point on the floor between the feet. A person faces the direction of
  /// the first segment (y without waypoints), also when walking back.
  TrajectoryConfig trajectory;
};

/// Keys: shape, size_m (not of a person), rgb, trajectory.
void describe(FieldVisitor& v, ObjectConfig& config);

/// Objects under their names, in the order of the scenario.
using NamedObjects = std::vector<std::pair<std::string, ObjectConfig>>;

/// The objects as MJCF elements for World: mocap bodies whose names begin with `distractor`. Empty without objects.
[[nodiscard]] std::string objects_mjcf(const NamedObjects& objects);

/// Moves the bodies of objects_mjcf along the objects' trajectories.
class Objects {
 public:
  /// `model` holds objects_mjcf(objects). Each object has a sway of its own. Throws InputError for a config out of range.
  Objects(const NamedObjects& objects, std::uint64_t seed, const mjModel& model);

  /// Sets the poses of the bodies at t_us. The caller updates the kinematics.
  void place(std::int64_t t_us, mjData& data) const;

 private:
  struct Part {
    int mocap;
    Eigen::Vector3d joint_m;  ///< its origin in the object's frame, x the walking direction
    double swing_rad;         ///< amplitude of its rotation about the object's y axis
  };
  struct Object {
    Trajectory trajectory;
    double heading_rad;  ///< about z
    std::vector<Part> parts;
  };
  std::vector<Object> objects_;
};

}  // namespace saccade
