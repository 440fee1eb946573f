#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/config.h"
#include "sim/model_parts.h"
#include "sim/trajectory.h"

namespace saccade {

/// Shape of an object.
enum class ObjectShape {
  box,
  cylinder,  ///< upright
  ellipsoid,
  sphere,
  prism,         ///< hexagonal, its axis along x
  covered_disc,  ///< a disc normal to x whose lower part is behind a box that moves with it
  hand,          ///< an open hand with forearm that waves about x
  person,
  mjcf,  ///< a model of a file
  mesh,  ///< a mesh of a file
};
constexpr auto words_of(ObjectShape) {
  return std::to_array<Word<ObjectShape>>({{ObjectShape::box, "box"},
                                           {ObjectShape::cylinder, "cylinder"},
                                           {ObjectShape::ellipsoid, "ellipsoid"},
                                           {ObjectShape::sphere, "sphere"},
                                           {ObjectShape::prism, "prism"},
                                           {ObjectShape::covered_disc, "covered_disc"},
                                           {ObjectShape::hand, "hand"},
                                           {ObjectShape::person, "person"},
                                           {ObjectShape::mjcf, "mjcf"},
                                           {ObjectShape::mesh, "mesh"}});
}

/// Whether a hand or a person, which move their parts; they have no size of their own (a person is 1.72 m tall).
[[nodiscard]] constexpr bool is_of_a_person(ObjectShape shape) {
  return shape == ObjectShape::hand || shape == ObjectShape::person;
}
/// Whether the shape is in a file, and with it the size.
[[nodiscard]] constexpr bool is_of_a_file(ObjectShape shape) {
  return shape == ObjectShape::mjcf || shape == ObjectShape::mesh;
}
[[nodiscard]] constexpr bool shape_has_size(ObjectShape shape) {
  return !is_of_a_person(shape) && !is_of_a_file(shape);
}

/// A moving object in front of the robot besides the ball: it distracts, or hides the ball.
struct ObjectConfig {
  ObjectShape shape = ObjectShape::box;
  std::string mjcf;     ///< path of the MJCF file
  std::string mesh;     ///< path of the OBJ or STL file
  std::string texture;  ///< mesh: path of a PNG image; empty: the object has one colour
  double scale = 1.0;   ///< mesh: factor from its coordinates to metres
  /// Extent along x, y, z. A cylinder has the diameter x, a sphere and a covered disc the diameter y, a prism the
  /// distance y between opposite sides.
  Eigen::Vector3d size_m = {0.08, 0.08, 0.08};
  std::array<double, 3> rgb = {0.10, 0.25, 0.60};  ///< linear reflectance; for a person that of the shirt
  double shown_share = 0.5;  ///< covered disc: share of the outline that the box does not hide
  std::array<double, 3> cover_rgb = {0.45, 0.42, 0.36};  ///< covered disc: linear reflectance of the box
  double wave_hz = 1.5;                                  ///< hand: waves per second
  /// Rotation at the start (not of a person), and its speed (not of a hand): rotation vectors, root frame.
  std::array<double, 3> turn_deg = {0.0, 0.0, 0.0};
  std::array<double, 3> turn_deg_s = {0.0, 0.0, 0.0};
  /// Trajectory of its centre (of a file: of the file's origin); for a person, of the point on the floor between the feet. A person faces the direction of
  /// the first segment (y without waypoints), also when walking back.
  TrajectoryConfig trajectory;
};

/// Keys: shape, mjcf, mesh, texture, scale, size_m, rgb, shown_share, cover_rgb, wave_hz, turn_deg, turn_deg_s, trajectory; of the shapes that have
/// them.
void describe(FieldVisitor& v, ObjectConfig& config);

/// Objects under their names, in the order of the scenario.
using NamedObjects = std::vector<std::pair<std::string, ObjectConfig>>;

/// The seed of the sway of the object with this index.
[[nodiscard]] constexpr std::uint64_t object_seed(std::uint64_t seed, std::size_t index) {
  return seed + index + 1;
}

/// What the files of the objects add to the world, for each object; without parts for the others. Throws InputError as
/// read_model_file() and read_mesh_file(), and for a texture without texture coordinates.
[[nodiscard]] std::vector<ModelParts> load_object_files(const NamedObjects& objects);

/// The objects as MJCF elements for World: mocap bodies whose names begin with `distractor`. Empty without objects.
[[nodiscard]] std::string objects_mjcf(const NamedObjects& objects, const std::vector<ModelParts>& files);

/// How the names of the bodies of the object with this index begin.
[[nodiscard]] std::string object_body_prefix(std::size_t object);

/// Moves the bodies of objects_mjcf along the objects' trajectories.
class Objects {
 public:
  /// `model` holds objects_mjcf(objects, files). Each object has a sway of its own. Throws InputError for a config out of
  /// range.
  Objects(const NamedObjects& objects, const std::vector<ModelParts>& files, std::uint64_t seed,
          const mjModel& model);

  /// Sets the poses of the bodies at t_us. The caller updates the kinematics.
  void place(std::int64_t t_us, mjData& data) const;

  /// Of the object with this index: its trajectory, the mocap body of its first part, and its radius if it is a sphere.
  [[nodiscard]] const Trajectory& trajectory(std::size_t object) const { return objects_[object].trajectory; }
  [[nodiscard]] int mocap(std::size_t object) const { return objects_[object].parts.front().mocap; }
  [[nodiscard]] std::optional<double> sphere_radius_m(std::size_t object) const {
    return objects_[object].sphere_radius_m;
  }

 private:
  struct Part {
    int mocap;
    Eigen::Vector3d joint_m;  ///< its origin in the object's frame, x the walking direction
    double swing_rad;         ///< amplitude of its rotation about the object's y axis
  };
  struct Object {
    Trajectory trajectory;
    double heading_rad;          ///< about z
    Eigen::Vector3d turn_rad;    ///< rotation vector at the start
    Eigen::Vector3d turn_rad_s;  ///< and its speed
    double wave_rad_s;           ///< angular frequency of a hand
    std::vector<Part> parts;
    std::optional<double> sphere_radius_m;
  };
  std::vector<Object> objects_;
};

}  // namespace saccade
