#pragma once

#include <string>

#include "sim/model_parts.h"
#include "sim/mujoco_compat.h"

namespace saccade {

/// What an MJCF file describes.
enum class ModelUse {
  object,  ///< one rigid object: no joints but one free joint, which is dropped, for the trajectory moves the object
  lab,  ///< a room: no joints; its lights are used
};

/// Reads an MJCF model with everything that it includes. Its geoms stay where they are at its reference pose, in the frame
/// of its world; geoms of groups above 2, cameras, sites and everything that concerns dynamics are dropped. Colours and
/// textures are taken as linear reflectances. `prefix` begins the names of the parts.
/// Throws InputError, with the file's path: for a file that MuJoCo rejects (with its message), joints, height fields, a
/// model without geoms; for an object also planes, extents above 5 m and meshes that check_surface() rejects.
[[nodiscard]] ModelParts read_model_file(const std::string& path, const std::string& prefix, ModelUse use);

/// A model from a text in MJCF. Throws InputError at `place`, with MuJoCo's message in one line, if it is rejected.
[[nodiscard]] MjModelPtr compile_mjcf_text(const std::string& mjcf, const std::string& place,
                                           const std::string& expectation);

}  // namespace saccade
