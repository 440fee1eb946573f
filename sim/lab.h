#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <string>

#include "core/config.h"

namespace saccade {

/// The room in front of the robot. Root frame: x backward, y right, z up, the waist at the origin; the
/// floor is at z = -0.62 m and the robot looks along -x at the back wall.
struct LabConfig {
  /// "rectilinear": shelves with books, posters, window frames, a monitor, boxes, a door.
  /// "textured": brick, curtain, foliage, patterned cloth, pinned pictures, plants.
  std::string clutter = "textured";
  double density = 1.0;          ///< how many things stand, hang and lie about; 1 is a lived-in lab
  double contrast = 1.0;         ///< of everything painted; 0 is flat grey, 1 as in life
  double brightness = 1.0;       ///< of the light; at 1 a white wall is just below saturation
  double wall_distance_m = 2.2;  ///< from the waist to the wall in front
};

/// Keys: clutter, density, contrast, brightness, wall_distance_m.
void describe(FieldVisitor& v, LabConfig& config);

/// The lab as MJCF elements for World: <asset> and <worldbody> with two lights and one mesh, "lab", of group
/// 1 that touches nothing. (One mesh with one texture for everything: in software each further geom would
/// cost 7 us per image.) The texture is flat in it; paint_lab_textures fills it. The same config and seed
/// give the same text. Throws InputError for a config out of range.
[[nodiscard]] std::string lab_mjcf(const LabConfig& config, std::uint64_t seed);

/// Paints the texture of a compiled model that holds lab_mjcf(config, seed). Colours are linear
/// reflectances between 0.09 and 0.92. Call before a renderer uploads it.
/// Throws RunError when the model does not hold that lab.
void paint_lab_textures(mjModel& model, const LabConfig& config, std::uint64_t seed);

}  // namespace saccade
