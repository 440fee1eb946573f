#pragma once

#include <string>

#include "core/config.h"
#include "sim/model_parts.h"

namespace saccade {

/// A photograph of everything around, as the room: an equirectangular image on a sphere about the head.
struct PanoramaConfig {
  std::string file;          ///< PNG, twice as wide as high, sRGB; its middle is straight ahead
  double heading_deg = 0.0;  ///< turns the photograph to the right
  double distance_m = 4.0;   ///< radius of the sphere
  double brightness = 1.0;   ///< factor of its luminance
};

/// Keys: panorama, heading_deg, distance_m, photo_brightness.
void describe(FieldVisitor& v, PanoramaConfig& config);

/// The sphere, as a mesh that no light changes. Throws InputError for a file that is missing, no PNG, or not twice as wide
/// as high.
[[nodiscard]] ModelParts panorama_parts(const PanoramaConfig& config, const std::string& prefix);

}  // namespace saccade
