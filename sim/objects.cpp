#include "sim/objects.h"

#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

#include "core/error.h"

namespace saccade {
namespace {

constexpr double stride_m = 1.3;  ///< length of a person's double step
constexpr double leg_swing_rad = 0.42;
constexpr double arm_swing_rad = 0.35;

/// A rigid part of an object; x the walking direction, y to its left, z up.
struct Piece {
  Eigen::Vector3d joint_m;
  double swing_rad;
  std::string geoms;
};

std::string geom(std::string_view shape, std::string_view attributes, std::string_view colour) {
  return "<geom type=\"" + std::string(shape) + "\" " + std::string(attributes) + " " + std::string(colour) +
         " contype=\"0\" conaffinity=\"0\"/>";
}

std::string rgba(const std::array<double, 3>& rgb) {
  return "rgba=\"" + text_of(rgb[0]) + " " + text_of(rgb[1]) + " " + text_of(rgb[2]) + " 1\"";
}

std::vector<Piece> pieces_of(const ObjectConfig& object) {
  const std::string colour = rgba(object.rgb);
  if (object.shape != ObjectShape::person) {
    const bool round = object.shape == ObjectShape::cylinder;
    std::string size = text_of(0.5 * object.size_m[0]);
    if (!round) size += " " + text_of(0.5 * object.size_m[1]);
    size += " " + text_of(0.5 * object.size_m[2]);
    return {{Eigen::Vector3d::Zero(), 0.0, geom(word_of(object.shape), "size=\"" + size + "\"", colour)}};
  }
  const std::string skin = "material=\"person_skin\"";
  const std::string trousers = "rgba=\"0.09 0.10 0.13 1\"";
  std::vector<Piece> pieces = {{{0.0, 0.0, 1.15},
                                0.0,
                                geom("ellipsoid", "size=\"0.12 0.20 0.34\"", colour) +
                                    geom("ellipsoid", "size=\"0.10 0.08 0.125\" pos=\"0 0 0.445\"", skin)}};
  for (const double side : {-1.0, 1.0}) {
    pieces.push_back({{0.0, 0.09 * side, 0.90},
                      leg_swing_rad * side,
                      geom("capsule", "size=\"0.075\" fromto=\"0 0 0  0 0 -0.82\"", trousers)});
    pieces.push_back({{0.0, 0.23 * side, 1.38},
                      -arm_swing_rad * side,
                      geom("capsule", "size=\"0.045\" fromto=\"0 0 0  0 0 -0.58\"", colour)});
  }
  return pieces;
}

std::string body_name(std::size_t object, std::size_t piece) {
  return "distractor_" + std::to_string(object) + "_" + std::to_string(piece);
}

/// Direction of the first segment of a trajectory, about z.
double heading_rad(const TrajectoryConfig& trajectory) {
  if (trajectory.kind != TrajectoryKind::waypoints) return std::numbers::pi / 2.0;
  const Eigen::Vector3d along = trajectory.points_m[1] - trajectory.points_m[0];
  return std::atan2(along.y(), along.x());
}

}  // namespace

void describe(FieldVisitor& v, ObjectConfig& c) {
  v.choice("shape", c.shape, "shape of the object");
  v.when(c.shape != ObjectShape::person, "shape: box, cylinder or ellipsoid", [&] {
    v.reals("size_m", c.size_m, {0.001, 3.0}, "extent along x, y and z");
  });
  v.reals("rgb", c.rgb, {0.0, 1.0}, "colour (for a person, of the shirt): linear reflectance");
  v.section("trajectory", c.trajectory, "motion of the object");
}

std::string objects_mjcf(const NamedObjects& objects) {
  std::string bodies;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const std::vector<Piece> pieces = pieces_of(objects[i].second);
    for (std::size_t j = 0; j < pieces.size(); ++j) {
      bodies += "<body name=\"" + body_name(i, j) + "\" mocap=\"true\">" + pieces[j].geoms + "</body>\n";
    }
  }
  return bodies.empty() ? bodies : "<worldbody>\n" + bodies + "</worldbody>\n";
}

Objects::Objects(const NamedObjects& objects, std::uint64_t seed, const mjModel& model) {
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const ObjectConfig& config = objects[i].second;
    const bool walks = config.shape == ObjectShape::person;
    Object object{
        Trajectory(config.trajectory, seed + i + 1), walks ? heading_rad(config.trajectory) : 0.0, {}};
    const std::vector<Piece> pieces = pieces_of(config);
    for (std::size_t j = 0; j < pieces.size(); ++j) {
      const int body = mj_name2id(&model, mjOBJ_BODY, body_name(i, j).c_str());
      SACCADE_CHECK(body >= 0);
      object.parts.push_back({model.body_mocapid[body], pieces[j].joint_m, pieces[j].swing_rad});
    }
    objects_.push_back(std::move(object));
  }
}

void Objects::place(std::int64_t t_us, mjData& data) const {
  for (const Object& object : objects_) {
    const Eigen::Vector3d at_m = object.trajectory.position_m(t_us);
    const Eigen::AngleAxisd turn(object.heading_rad, Eigen::Vector3d::UnitZ());
    const double gone_m = (turn.inverse() * at_m).x();
    const double phase = std::sin(2.0 * std::numbers::pi * gone_m / stride_m);
    for (const Part& part : object.parts) {
      const Eigen::Quaterniond pose(turn *
                                    Eigen::AngleAxisd(part.swing_rad * phase, Eigen::Vector3d::UnitY()));
      Eigen::Map<Eigen::Vector3d>(data.mocap_pos + 3 * part.mocap) = at_m + turn * part.joint_m;
      Eigen::Map<Eigen::Vector4d>(data.mocap_quat + 4 * part.mocap) << pose.w(), pose.vec();
    }
  }
}

}  // namespace saccade
