#include "sim/objects.h"

#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

#include "core/error.h"
#include "core/rotation_vector.h"
#include "sim/file_keys.h"
#include "sim/mesh_file.h"
#include "sim/model_file.h"

namespace saccade {
namespace {

constexpr double stride_m = 1.3;  ///< length of a person's double step
constexpr double leg_swing_rad = 0.42;
constexpr double arm_swing_rad = 0.35;
constexpr double hand_wave_rad = 0.45;  ///< amplitude

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

std::string triple(double x, double y, double z) { return text_of(x) + " " + text_of(y) + " " + text_of(z); }

/// A hexagon is the union of three rectangles. `flats_m`: distance between opposite sides.
std::string prism_geoms(double length_m, double flats_m, const std::string& colour) {
  const std::string size =
      "size=\"" + triple(0.5 * length_m, 0.5 * flats_m, 0.5 * flats_m / std::numbers::sqrt3) + "\"";
  std::string geoms;
  for (const double turn_rad : {0.0, std::numbers::pi / 3.0, 2.0 * std::numbers::pi / 3.0}) {
    geoms += geom("box", size + " axisangle=\"1 0 0 " + text_of(turn_rad) + "\"", colour);
  }
  return geoms;
}

std::string covered_disc_geoms(const ObjectConfig& object, const std::string& colour) {
  const double radius_m = 0.5 * object.size_m.y();
  constexpr double half_thickness_m = 0.004;
  const double top_m = radius_m * std::cos(std::numbers::pi * object.shown_share);
  const double bottom_m = -1.3 * radius_m;
  const std::string cover = "size=\"" + triple(half_thickness_m, 1.25 * radius_m, 0.5 * (top_m - bottom_m)) +
                            "\" pos=\"" + triple(3.0 * half_thickness_m, 0.0, 0.5 * (top_m + bottom_m)) +
                            "\"";
  return geom("ellipsoid", "size=\"" + triple(half_thickness_m, radius_m, radius_m) + "\"", colour) +
         geom("box", cover, rgba(object.cover_rgb));
}

/// Palm to the robot, fingers up; the origin is the elbow's end of the wrist.
std::string hand_geoms(const std::string& sleeve) {
  const std::string skin = "material=\"person_skin\"";
  std::string geoms = geom("ellipsoid", "size=\"0.014 0.043 0.050\" pos=\"0 0 0.05\"", skin) +
                      geom("capsule", "size=\"0.027\" fromto=\"0 0 0  0 0 -0.10\"", skin) +
                      geom("capsule", "size=\"0.040\" fromto=\"0 0 -0.12  -0.05 0 -0.45\"", sleeve) +
                      geom("capsule", "size=\"0.011\" fromto=\"0 -0.035 0.035  0.005 -0.078 0.075\"", skin);
  for (int finger = 0; finger < 4; ++finger) {
    const double y_m = 0.033 - 0.022 * finger;
    const double tip_m = finger == 1 || finger == 2 ? 0.170 : finger == 0 ? 0.145 : 0.155;
    geoms += geom("capsule",
                  "size=\"0.0088\" fromto=\"" + triple(0.0, 0.9 * y_m, 0.09) + "  " +
                      triple(0.004, 1.5 * y_m, tip_m) + "\"",
                  skin);
  }
  return geoms;
}

/// What `shape` is one geom of, as MuJoCo's size attribute.
std::string size_of(const ObjectConfig& object) {
  const Eigen::Vector3d half_m = 0.5 * object.size_m;
  if (object.shape == ObjectShape::sphere) return text_of(half_m.y());
  if (object.shape == ObjectShape::cylinder) return text_of(half_m.x()) + " " + text_of(half_m.z());
  return triple(half_m.x(), half_m.y(), half_m.z());
}

std::vector<Piece> pieces_of(const ObjectConfig& object, const ModelParts& file) {
  if (is_of_a_file(object.shape)) return {{Eigen::Vector3d::Zero(), 0.0, file.geoms}};
  const std::string colour = rgba(object.rgb);
  if (object.shape != ObjectShape::person) {
    std::string geoms;
    switch (object.shape) {
      case ObjectShape::prism:
        geoms = prism_geoms(object.size_m.x(), object.size_m.y(), colour);
        break;
      case ObjectShape::covered_disc:
        geoms = covered_disc_geoms(object, colour);
        break;
      case ObjectShape::hand:
        geoms = hand_geoms(colour);
        break;
      default:
        geoms = geom(word_of(object.shape), "size=\"" + size_of(object) + "\"", colour);
    }
    return {{Eigen::Vector3d::Zero(), 0.0, geoms}};
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
  return object_body_prefix(object) + std::to_string(piece);
}

/// A mesh in one colour, or with a texture.
ModelParts mesh_parts(const ObjectConfig& object, const std::string& prefix) {
  const TriangleMesh mesh = read_mesh_file(object.mesh, object.scale);
  ModelParts parts;
  parts.sphere_radius_m = sphere_radius_m(mesh);
  std::string look = rgba(object.rgb);
  if (!object.texture.empty()) {
    if (!mesh.has_texels()) {
      throw InputError(object.mesh, "no texture coordinates",
                       "texture coordinates (vt) for " + object.texture);
    }
    TextureImage image = read_png(object.texture, prefix + "_texture");
    parts.assets = texture_mjcf(image) + "<material name=\"" + prefix + "\" texture=\"" + image.name +
                   "\" specular=\"0\" shininess=\"0\"/>\n";
    parts.textures.push_back(std::move(image));
    look = "material=\"" + prefix + "\"";
  }
  parts.assets += mesh_mjcf(mesh, prefix + "_mesh");
  parts.geoms = geom("mesh", "mesh=\"" + prefix + "_mesh\"", look);
  return parts;
}

/// The object as a body that MuJoCo can move freely, where its trajectory needs one.
BodyShape body_shape(const ObjectConfig& object, const ModelParts& file) {
  if (!moves_as_free_body(object.trajectory.kind)) return {};
  std::string geoms;
  for (const Piece& piece : pieces_of(object, file)) geoms += piece.geoms;
  return {file.assets, geoms, rotation_of(radians(object.turn_deg))};
}

/// Direction of the first segment of a trajectory, about z.
double heading_rad(const TrajectoryConfig& trajectory) {
  if (trajectory.kind != TrajectoryKind::waypoints) return std::numbers::pi / 2.0;
  const Eigen::Vector3d along = trajectory.points_m[1] - trajectory.points_m[0];
  return std::atan2(along.y(), along.x());
}

}  // namespace

void describe(FieldVisitor& v, ObjectConfig& c) {
  if (c.shape == ObjectShape::box && gives(v, "mjcf")) c.shape = ObjectShape::mjcf;
  if (c.shape == ObjectShape::box && gives(v, "mesh")) c.shape = ObjectShape::mesh;
  v.choice("shape", c.shape, "shape of the object; with the key mjcf or mesh it is that by default");
  v.when(c.shape == ObjectShape::mjcf, "shape: mjcf", [&] {
    v.path("mjcf", c.mjcf, "MJCF file of a rigid object; relative to the scenario");
    v.require(!c.mjcf.empty(), "mjcf", "no such key", "the path of an MJCF file");
  });
  v.when(c.shape == ObjectShape::mesh, "shape: mesh", [&] {
    v.path("mesh", c.mesh, "OBJ or STL file of a closed surface; relative to the scenario");
    v.require(!c.mesh.empty(), "mesh", "no such key", "the path of an OBJ or STL file");
    optional_path(v, "texture", c.texture, "PNG image on the mesh, sRGB; without it the mesh has one colour");
    v.real("scale", c.scale, {1e-6, 1e3}, "factor from the file's coordinates to metres");
  });
  v.when(shape_has_size(c.shape), "shape: any but hand, person, mjcf and mesh", [&] {
    v.reals(
        "size_m", c.size_m, {0.001, 3.0},
        "extent along x, y and z (a sphere and a covered disc: diameter y; a prism: y between its sides)");
  });
  v.when(c.shape != ObjectShape::mjcf && c.texture.empty(), "shape: any but mjcf", [&] {
    v.reals("rgb", c.rgb, {0.0, 1.0}, "colour (for a person and a hand, of the shirt): linear reflectance");
  });
  v.when(c.shape == ObjectShape::covered_disc, "shape: covered_disc", [&] {
    v.real("shown_share", c.shown_share, {0.1, 1.0},
           "share of the disc's outline that the box does not hide");
    v.reals("cover_rgb", c.cover_rgb, {0.0, 1.0}, "colour of the box: linear reflectance");
  });
  v.when(c.shape == ObjectShape::hand, "shape: hand", [&] {
    v.real("wave_hz", c.wave_hz, {0.0, 5.0}, "waves per second");
  });
  v.when(c.shape != ObjectShape::person, "shape: any but person", [&] {
    v.reals("turn_deg", c.turn_deg, {-360.0, 360.0},
            "rotation at the start, a rotation vector in the root frame");
  });
  v.when(!is_of_a_person(c.shape), "shape: any but hand and person", [&] {
    v.reals("turn_deg_s", c.turn_deg_s, {-2000.0, 2000.0}, "speed of its rotation, about a fixed axis");
  });
  v.section("trajectory", c.trajectory, "motion of the object");
  v.require(!is_of_a_person(c.shape) || !moves_as_free_body(c.trajectory.kind), "shape", word_of(c.shape),
            "another shape, for ballistic and pushed motions");
}

std::string object_body_prefix(std::size_t object) { return "distractor_" + std::to_string(object) + "_"; }

std::vector<ModelParts> load_object_files(const NamedObjects& objects) {
  std::vector<ModelParts> files;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const ObjectConfig& object = objects[i].second;
    const std::string prefix = "object_" + std::to_string(i);
    files.emplace_back();
    if (object.shape == ObjectShape::mjcf)
      files.back() = read_model_file(object.mjcf, prefix, ModelUse::object);
    if (object.shape == ObjectShape::mesh) files.back() = mesh_parts(object, prefix);
  }
  return files;
}

std::string objects_mjcf(const NamedObjects& objects, const std::vector<ModelParts>& files) {
  std::string bodies;
  std::string assets;
  for (std::size_t i = 0; i < objects.size(); ++i) {
    assets += files[i].assets;
    const std::vector<Piece> pieces = pieces_of(objects[i].second, files[i]);
    for (std::size_t j = 0; j < pieces.size(); ++j) {
      bodies += "<body name=\"" + body_name(i, j) + "\" mocap=\"true\">" + pieces[j].geoms + "</body>\n";
    }
  }
  if (!assets.empty()) assets = "<asset>\n" + assets + "</asset>\n";
  return bodies.empty() ? bodies : assets + "<worldbody>\n" + bodies + "</worldbody>\n";
}

Objects::Objects(const NamedObjects& objects, const std::vector<ModelParts>& files, std::uint64_t seed,
                 const mjModel& model) {
  for (std::size_t i = 0; i < objects.size(); ++i) {
    const ObjectConfig& config = objects[i].second;
    const bool walks = config.shape == ObjectShape::person;
    const bool waves = config.shape == ObjectShape::hand;
    Object object{
        Trajectory(config.trajectory, object_seed(seed, i), body_shape(config, files[i]),
                   "objects." + objects[i].first + ".trajectory"),
        walks ? heading_rad(config.trajectory) : 0.0,
        walks ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : radians(config.turn_deg),
        is_of_a_person(config.shape) ? Eigen::Vector3d(Eigen::Vector3d::Zero()) : radians(config.turn_deg_s),
        waves ? 2.0 * std::numbers::pi * config.wave_hz : 0.0,
        {},
        std::nullopt};
    if (config.shape == ObjectShape::sphere) object.sphere_radius_m = 0.5 * config.size_m.y();
    if (files[i].sphere_radius_m > 0.0) object.sphere_radius_m = files[i].sphere_radius_m;
    const std::vector<Piece> pieces = pieces_of(config, files[i]);
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
    const double t_s = 1e-6 * static_cast<double>(t_us);
    for (const Part& part : object.parts) {
      Eigen::Quaterniond pose(turn * Eigen::AngleAxisd(part.swing_rad * phase, Eigen::Vector3d::UnitY()));
      if (!object.turn_rad.isZero(0.0)) pose = pose * rotation_of(object.turn_rad);
      if (!object.turn_rad_s.isZero(0.0)) pose = rotation_of(t_s * object.turn_rad_s) * pose;
      if (object.wave_rad_s > 0.0) {
        const double wave_rad = hand_wave_rad * std::sin(object.wave_rad_s * t_s);
        pose = pose * Eigen::AngleAxisd(wave_rad, Eigen::Vector3d::UnitX());
      }
      if (object.trajectory.turns()) pose = object.trajectory.turn(t_us) * pose;
      Eigen::Map<Eigen::Vector3d>(data.mocap_pos + 3 * part.mocap) = at_m + turn * part.joint_m;
      Eigen::Map<Eigen::Vector4d>(data.mocap_quat + 4 * part.mocap) << pose.w(), pose.vec();
    }
  }
}

}  // namespace saccade
