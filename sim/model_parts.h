#pragma once

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

namespace saccade {

/// An image as a texture: red, green, blue, row by row from the top, as the renderer takes them (linear reflectances).
struct TextureImage {
  std::string name;  ///< in the model
  int width = 0;
  int height = 0;
  std::vector<mjtByte> rgb;
};

/// What a file adds to the world: MJCF elements whose names begin with a prefix of their own, so that files cannot disturb
/// each other, and the images that take the place of their flat textures once the model is compiled.
struct ModelParts {
  std::string assets;  ///< inside <asset>
  std::string geoms;   ///< inside a <body> or <worldbody>; nothing collides
  std::string lights;  ///< inside <worldbody>
  std::vector<TextureImage> textures;
  /// The radius where the parts are one sphere about the origin, else 0.
  double sphere_radius_m = 0.0;
};

/// <texture> for an image, flat until paint_textures(). A cube map has six square faces one below the other.
[[nodiscard]] std::string texture_mjcf(const TextureImage& image, bool is_cube = false);
/// Paints the textures of a compiled model that holds the parts. Call before a renderer uploads them.
void paint_textures(const ModelParts& parts, mjModel& model);

/// Reads a PNG image in sRGB and converts it to linear reflectances. Throws InputError for a missing or invalid file and
/// for sides longer than 8192.
[[nodiscard]] TextureImage read_png(const std::string& path, std::string name);

/// A text as the value of an XML attribute.
[[nodiscard]] std::string xml_escaped(std::string_view text);

}  // namespace saccade
