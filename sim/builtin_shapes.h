#pragma once

#include <mujoco/mujoco.h>

#include "sim/gl_context.h"

namespace saccade::detail {

/// The address of an OpenGL function. Throws RunError where OpenGL has none of that name.
[[nodiscard]] void* gl_address(const GlContext& gl, const char* name);
template <class Function>
Function* gl_function(const GlContext& gl, const char* name) {
  return reinterpret_cast<Function*>(gl_address(gl, name));
}

/// Replaces the sphere of MuJoCo's renderer by one with `sides` sides. An outline seen from the side runs through stacks,
/// from above through slices: there are half as many stacks. The OpenGL context must be current, here and below.
void replace_sphere(const GlContext& gl, const mjrContext& context, int sides);

/// MuJoCo 3.12 gives spheres, ellipsoids, capsules, cylinders and boxes texture coordinates of their own; older versions
/// project a 2D texture along the shape's z axis. This replaces these shapes of the renderer by equal ones with the
/// projection, so that a texture looks the same with every version. Does nothing before 3.12. The texture is shifted
/// where texrepeat is not odd: MuJoCo scales it about another point. Call it before replace_sphere().
void project_textures(const GlContext& gl, const mjrContext& context, const mjVisual& visual);

}  // namespace saccade::detail
