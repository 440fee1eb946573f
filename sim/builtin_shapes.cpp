#include "sim/builtin_shapes.h"

#include <GL/gl.h>

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "core/error.h"
#include "sim/mujoco_compat.h"

namespace saccade::detail {
namespace {

using std::numbers::pi;

/// Display lists of MuJoCo's renderer from mjrContext::baseBuiltin on.
enum class ShapeList : GLuint { sphere, sphere_top, sphere_bottom, cylinder, open_cylinder, haze, box };

/// A point of the outline of a solid of revolution about z, and the outline's normal there.
struct OutlinePoint {
  double radius;
  double z;
  double normal_radius;
  double normal_z;
};
using RevolvedOutline = std::vector<OutlinePoint>;  ///< from the top

/// The steps `first` to `last` of `turn_steps` that make a full turn, from the top.
RevolvedOutline arc(int first, int last, int turn_steps, double centre_z) {
  RevolvedOutline outline;
  for (int step = first; step <= last; ++step) {
    const double polar = 2.0 * pi * step / turn_steps;
    outline.push_back({std::sin(polar), centre_z + std::cos(polar), std::sin(polar), std::cos(polar)});
  }
  return outline;
}

RevolvedOutline straight(const OutlinePoint& from, const OutlinePoint& to, int steps) {
  RevolvedOutline outline;
  for (int step = 0; step <= steps; ++step) {
    const double u = static_cast<double>(step) / steps;
    outline.push_back({from.radius + u * (to.radius - from.radius), from.z + u * (to.z - from.z),
                       from.normal_radius, from.normal_z});
  }
  return outline;
}

class ShapeWriter {
 public:
  ShapeWriter(const GlContext& gl, const mjrContext& context)
      : base_(context.baseBuiltin),
        new_list_(gl_function<decltype(glNewList)>(gl, "glNewList")),
        end_list_(gl_function<decltype(glEndList)>(gl, "glEndList")),
        begin_(gl_function<decltype(glBegin)>(gl, "glBegin")),
        end_(gl_function<decltype(glEnd)>(gl, "glEnd")),
        texel_(gl_function<decltype(glTexCoord2d)>(gl, "glTexCoord2d")),
        normal_(gl_function<decltype(glNormal3d)>(gl, "glNormal3d")),
        vertex_(gl_function<decltype(glVertex3d)>(gl, "glVertex3d")) {}

  void start(ShapeList shape) const {
    new_list_(base_ + static_cast<GLuint>(shape), GL_COMPILE);
    begin_(GL_QUADS);
  }
  void finish() const {
    end_();
    end_list_();
  }
  /// The first corner of a quad decides how it is split into triangles: MuJoCo's begin with the lower edge.
  enum class FirstEdge { upper, lower };
  void revolve(const RevolvedOutline& outline, int slices, FirstEdge first) const {
    const auto put = [&](const OutlinePoint& point, int slice) {
      const double around = 2.0 * pi * slice / slices;
      corner(
          {point.radius * std::cos(around), point.radius * std::sin(around), point.z},
          {point.normal_radius * std::cos(around), point.normal_radius * std::sin(around), point.normal_z});
    };
    for (std::size_t i = 0; i + 1 < outline.size(); ++i) {
      for (int slice = 0; slice < slices; ++slice) {
        if (first == FirstEdge::upper) put(outline[i], slice);
        put(outline[i + 1], slice);
        put(outline[i + 1], slice + 1);
        put(outline[i], slice + 1);
        if (first == FirstEdge::lower) put(outline[i], slice);
      }
    }
  }
  /// A side of the cube from -1 to 1, as quads x quads squares.
  void side(int axis, double sign, int quads) const {
    const Eigen::Vector3d normal = sign * Eigen::Vector3d::Unit(axis);
    const Eigen::Vector3d u = Eigen::Vector3d::Unit((axis + 1) % 3);
    const Eigen::Vector3d w = sign * Eigen::Vector3d::Unit((axis + 2) % 3);
    const auto put = [&](int column, int row) {
      corner(normal + (2.0 * column / quads - 1.0) * u + (2.0 * row / quads - 1.0) * w, normal);
    };
    for (int column = 0; column < quads; ++column) {
      for (int row = 0; row < quads; ++row) {
        put(column, row);
        put(column + 1, row);
        put(column + 1, row + 1);
        put(column, row + 1);
      }
    }
  }

 private:
  void corner(const Eigen::Vector3d& at, const Eigen::Vector3d& normal) const {
    if constexpr (primitives_have_texels) texel_(0.5 * at.x() - 0.5, -0.5 * at.y() - 0.5);
    normal_(normal.x(), normal.y(), normal.z());
    vertex_(at.x(), at.y(), at.z());
  }

  GLuint base_;
  decltype(&glNewList) new_list_;
  decltype(&glEndList) end_list_;
  decltype(&glBegin) begin_;
  decltype(&glEnd) end_;
  decltype(&glTexCoord2d) texel_;
  decltype(&glNormal3d) normal_;
  decltype(&glVertex3d) vertex_;
};

}  // namespace

void* gl_address(const GlContext& gl, const char* name) {
  void* address = gl.function(name);
  if (address == nullptr) throw RunError(std::string("OpenGL failed: no ") + name);
  return address;
}

void replace_sphere(const GlContext& gl, const mjrContext& context, int sides) {
  const ShapeWriter writer(gl, context);
  writer.start(ShapeList::sphere);
  writer.revolve(arc(0, sides / 2, sides, 0.0), sides, ShapeWriter::FirstEdge::upper);
  writer.finish();
}

void project_textures(const GlContext& gl, const mjrContext& context, const mjVisual& visual) {
  if constexpr (!primitives_have_texels) return;
  const int slices = visual.quality.numslices;
  const int stacks = visual.quality.numstacks;
  const ShapeWriter writer(gl, context);
  const auto round = [&](ShapeList shape, std::initializer_list<RevolvedOutline> outlines) {
    writer.start(shape);
    for (const RevolvedOutline& outline : outlines)
      writer.revolve(outline, slices, ShapeWriter::FirstEdge::lower);
    writer.finish();
  };
  // The halves of a capsule have their centres at 1 and -1; all shapes have the corners of MuJoCo's.
  const RevolvedOutline wall = straight({1.0, 1.0, 1.0, 0.0}, {1.0, -1.0, 1.0, 0.0}, stacks);
  const RevolvedOutline lid = straight({0.0, 1.0, 0.0, 1.0}, {1.0, 1.0, 0.0, 1.0}, stacks / 2);
  const RevolvedOutline floor = straight({1.0, -1.0, 0.0, -1.0}, {0.0, -1.0, 0.0, -1.0}, stacks / 2);
  round(ShapeList::sphere, {arc(0, stacks, 2 * stacks, 0.0)});
  round(ShapeList::sphere_top, {arc(0, stacks / 2, 2 * stacks, 1.0)});
  round(ShapeList::sphere_bottom, {arc(stacks / 2, stacks, 2 * stacks, -1.0)});
  round(ShapeList::open_cylinder, {wall});
  round(ShapeList::cylinder, {lid, wall, floor});
  writer.start(ShapeList::box);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double sign : {1.0, -1.0}) writer.side(axis, sign, visual.quality.numquads);
  }
  writer.finish();
}

}  // namespace saccade::detail
