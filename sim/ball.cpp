#include "sim/ball.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.h"
#include "core/rotation_vector.h"
#include "sim/mujoco_compat.h"

namespace saccade {
namespace {

using Eigen::Vector3d;

constexpr int face_texels = 48;  ///< side of a face of the pattern's cube
constexpr int face_count = 6;
constexpr int hidden_group = 3;    ///< of geoms that no eye and no window draws
constexpr double edge_rad = 0.03;  ///< half the width of the transition from one colour to the other

/// 1 above `edge`, 0 below, and a transition of one texel's angle between.
double above(double value, double edge) {
  return std::clamp(0.5 + 0.5 * (value - edge) / edge_rad, 0.0, 1.0);
}

/// The direction of a texel of a cube map, after OpenGL's table of faces; u and v in [-1, 1], v down.
Vector3d cube_direction(int face, double u, double v) {
  switch (face) {
    case 0:
      return Vector3d(1.0, -v, -u).normalized();
    case 1:
      return Vector3d(-1.0, -v, u).normalized();
    case 2:
      return Vector3d(u, 1.0, v).normalized();
    case 3:
      return Vector3d(u, -1.0, -v).normalized();
    case 4:
      return Vector3d(u, -v, 1.0).normalized();
    default:
      return Vector3d(-u, -v, -1.0).normalized();
  }
}

void paint_pattern(mjModel& model, const BallConfig& config) {
  const int texture = mj_name2id(&model, mjOBJ_TEXTURE, "ball_pattern");
  SACCADE_CHECK(texture >= 0 && model.tex_width[texture] == face_texels &&
                model.tex_height[texture] == face_count * face_texels);
  mjtByte* texel = texture_rgb(model, texture);
  for (int face = 0; face < face_count; ++face) {
    for (int row = 0; row < face_texels; ++row) {
      for (int column = 0; column < face_texels; ++column) {
        const double u = (2.0 * column + 1.0) / face_texels - 1.0;
        const double v = (2.0 * row + 1.0) / face_texels - 1.0;
        const double cover = pattern_cover(config.pattern, cube_direction(face, u, v));
        for (std::size_t i = 0; i < 3; ++i) {
          const double colour = (1.0 - cover) * config.rgb[i] + cover * config.pattern_rgb[i];
          *texel++ = static_cast<mjtByte>(std::lround(255.0 * colour));
        }
      }
    }
  }
}

void set_quat(mjtNum* quat, const Eigen::Quaterniond& q) {
  Eigen::Map<Eigen::Vector4d>(quat) << q.w(), q.vec();
}

void hide_geoms(mjModel& model, int body) {
  for (int g = model.body_geomadr[body]; g < model.body_geomadr[body] + model.body_geomnum[body]; ++g) {
    model.geom_group[g] = hidden_group;
  }
}

/// Scales the places of a body's geoms and the lengths of its capsules, not their thickness.
void scale_geoms(mjModel& m, int body, double scale) {
  for (int g = m.body_geomadr[body]; g < m.body_geomadr[body] + m.body_geomnum[body]; ++g) {
    mju_scl3(m.geom_pos + 3 * g, m.geom_pos + 3 * g, scale);
    if (m.geom_type[g] != mjGEOM_CAPSULE) continue;
    m.geom_size[3 * g + 1] *= scale;
    m.geom_rbound[g] = m.geom_size[3 * g] + m.geom_size[3 * g + 1];
  }
}

/// Direction from the hand to the ball's centre, as the hand's file has it.
Vector3d contact_of(Hand hand) {
  if (hand == Hand::sleeve) return Vector3d(0.76, 0.17, 0.62).normalized();
  return hand == Hand::string ? Vector3d(-Vector3d::UnitZ()) : Vector3d(Vector3d::UnitZ());
}

}  // namespace

void describe(FieldVisitor& v, BallConfig& c) {
  v.boolean("present", c.present, "whether the world has a ball; without it there is no hand either");
  v.real("diameter_m", c.diameter_m, {0.03, 0.2}, "diameter of the ball");
  v.reals("rgb", c.rgb, {0.0, 1.0}, "colour: linear reflectance in red, green and blue");
  v.choice("pattern", c.pattern, "pattern of the ball's surface");
  v.when(c.pattern != BallPattern::plain, "pattern: striped, seams or patches", [&] {
    v.reals("pattern_rgb", c.pattern_rgb, {0.0, 1.0}, "colour of the pattern: linear reflectance");
    v.reals("pattern_turn_deg", c.pattern_turn_deg, {-360.0, 360.0},
            "rotation of the pattern, a rotation vector");
  });
  v.real("gloss", c.gloss, {0.0, 1.0}, "strength of the highlights; 0: matt");
  v.choice("hand", c.hand, "what holds the ball");
  v.when(c.hand != Hand::none, "hand: any but none", [&] {
    v.real("hand_turn_deg", c.hand_turn_deg, {-180.0, 180.0},
           "rotation of what holds the ball about the ball's centre and the root's x axis");
  });
  v.choice("sleeve", c.sleeve, "pattern of the sleeve of the arm that holds it");
  v.boolean("rolls", c.rolls, "whether the ball turns as if it rolled on a horizontal plane");
  v.require(!c.rolls || c.hand == Hand::none, "rolls", "true", "false, unless hand is none");
  v.section("trajectory", c.trajectory, "motion of the ball");
}

std::string hand_file(const BallConfig& config) {
  return "hand_" + std::string(word_of(config.hand)) + ".xml";
}

std::string pattern_mjcf(const BallConfig& config) {
  if (config.pattern == BallPattern::plain) return {};
  return "<asset>\n  <texture name=\"ball_pattern\" type=\"cube\" builtin=\"flat\" width=\"" +
         std::to_string(face_texels) + "\" height=\"" + std::to_string(face_count * face_texels) +
         "\" rgb1=\"1 1 1\" rgb2=\"1 1 1\"/>\n"
         "  <material name=\"ball_pattern\" texture=\"ball_pattern\" specular=\"0\" "
         "shininess=\"0\"/>\n</asset>\n";
}

void set_up_ball(mjModel& m, const BallConfig& config) {
  const auto find = [&m](mjtObj type, const char* name) {
    const int id = mj_name2id(&m, type, name);
    if (id < 0) throw RunError("the model has no " + std::string(mju_type2Str(type)) + " named " + name);
    return id;
  };
  const int ball = find(mjOBJ_GEOM, "ball");
  const double radius_m = 0.5 * config.diameter_m;
  const double scale = radius_m / m.geom_size[3 * ball];
  m.geom_size[3 * ball] = m.geom_rbound[ball] = radius_m;
  if (config.pattern == BallPattern::plain) {
    float* rgba = m.mat_rgba + 4 * m.geom_matid[ball];
    for (std::size_t i = 0; i < 3; ++i) rgba[i] = static_cast<float>(config.rgb[i]);
  } else {
    m.geom_matid[ball] = find(mjOBJ_MATERIAL, "ball_pattern");
    set_quat(m.geom_quat + 4 * ball, rotation_of(radians(config.pattern_turn_deg)));
    m.geom_sameframe[ball] = 0;  // else MuJoCo takes the frame of the body for that of the geom
    paint_pattern(m, config);
  }
  if (config.gloss > 0.0) {
    constexpr float shininess = 0.16F;  // of OpenGL's exponent 128: a highlight of about a sixth of the disc
    m.mat_specular[m.geom_matid[ball]] = static_cast<float>(config.gloss);
    m.mat_shininess[m.geom_matid[ball]] = shininess;
    for (int i = 0; i < 3 * m.nlight; ++i) m.light_specular[i] = m.light_diffuse[i];
  }

  const int hand = find(mjOBJ_BODY, "hand");
  const int arm = find(mjOBJ_BODY, "arm");
  if (config.sleeve == Sleeve::checked) {
    const int sleeve = mj_name2id(&m, mjOBJ_GEOM, "arm_sleeve");
    if (sleeve >= 0) m.geom_matid[sleeve] = find(mjOBJ_MATERIAL, "person_sleeve_checked");
  }
  Eigen::Map<Vector3d> hand_pos(m.body_pos + 3 * hand);
  Eigen::Map<Vector3d> arm_pos(m.body_pos + 3 * arm);
  if (config.hand == Hand::fingers) {
    scale_geoms(m, hand, scale);
    arm_pos *= scale;
  } else {  // a hand keeps its size and touches a ball of any size
    const Vector3d nearer_m = (radius_m / scale - radius_m) * contact_of(config.hand);
    hand_pos += nearer_m;
    arm_pos += nearer_m;
  }
  if (config.hand_turn_deg != 0.0) {
    const Eigen::Quaterniond turn = rotation_of(radians({config.hand_turn_deg, 0.0, 0.0}));
    set_quat(m.body_quat + 4 * hand, turn);
    set_quat(m.body_quat + 4 * arm, turn);
    hand_pos = turn * Vector3d(hand_pos);
    arm_pos = turn * Vector3d(arm_pos);
  }
  if (config.present) return;
  hide_geoms(m, m.geom_bodyid[ball]);
  hide_geoms(m, hand);
  hide_geoms(m, arm);
}

Eigen::Quaterniond rolled(const Vector3d& moved_m, double radius_m) {
  const Vector3d along(moved_m.x(), moved_m.y(), 0.0);
  const double length_m = along.norm();
  if (length_m == 0.0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(
      Eigen::AngleAxisd(length_m / radius_m, Vector3d::UnitZ().cross(along / length_m)));
}

double pattern_cover(BallPattern pattern, const Vector3d& point) {
  switch (pattern) {
    case BallPattern::striped: {  // five bands and two caps
      const double latitude_rad = std::asin(std::clamp(point.z(), -1.0, 1.0));
      constexpr double bands_per_rad = 7.0;
      return above(std::sin(bands_per_rad * latitude_rad) / bands_per_rad, 0.0);
    }
    case BallPattern::seams: {
      constexpr double half_width_rad = 0.08;
      return above(-std::min({std::abs(point.x()), std::abs(point.y()), std::abs(point.z())}),
                   -half_width_rad);
    }
    case BallPattern::patches: {  // at the corners of an icosahedron
      constexpr double patch_rad = 0.36;
      double nearest = -1.0;
      for (const double a : {-1.0, 1.0}) {
        for (const double b : {-std::numbers::phi, std::numbers::phi}) {
          for (const Vector3d& corner : {Vector3d(0.0, a, b), Vector3d(a, b, 0.0), Vector3d(b, 0.0, a)}) {
            nearest = std::max(nearest, point.dot(corner.normalized()));
          }
        }
      }
      return above(-std::acos(std::clamp(nearest, -1.0, 1.0)), -patch_rad);
    }
    case BallPattern::plain:
      break;
  }
  return 0.0;
}

}  // namespace saccade
