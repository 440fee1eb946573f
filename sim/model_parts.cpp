#include "sim/model_parts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "core/error.h"
#include "emulator/srgb.h"
#include "sim/model_file.h"
#include "sim/mujoco_compat.h"

namespace saccade {

std::string texture_mjcf(const TextureImage& image, bool is_cube) {
  return "<texture name=\"" + image.name + "\" type=\"" + (is_cube ? "cube" : "2d") +
         "\" builtin=\"flat\" width=\"" + std::to_string(image.width) + "\" height=\"" +
         std::to_string(image.height) + "\" rgb1=\"1 1 1\" rgb2=\"1 1 1\"/>\n";
}

void paint_textures(const ModelParts& parts, mjModel& model) {
  for (const TextureImage& image : parts.textures) {
    const int id = mj_name2id(&model, mjOBJ_TEXTURE, image.name.c_str());
    SACCADE_CHECK(id >= 0 && model.tex_width[id] == image.width && model.tex_height[id] == image.height);
    std::copy(image.rgb.begin(), image.rgb.end(), texture_rgb(model, id));
  }
}

TextureImage read_png(const std::string& path, std::string name) {
  constexpr int longest_px = 8192;
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) throw InputError(path, "", "a readable PNG image");
  const std::string mjcf = "<mujoco><asset><texture name=\"image\" type=\"2d\" file=\"" + xml_escaped(path) +
                           "\"/></asset></mujoco>";
  const MjModelPtr model = compile_mjcf_text(mjcf, path, "a PNG image");
  TextureImage image{
      std::move(name), static_cast<int>(model->tex_width[0]), static_cast<int>(model->tex_height[0]), {}};
  if (image.width > longest_px || image.height > longest_px) {
    throw InputError(path, std::to_string(image.width) + "x" + std::to_string(image.height) + " pixels",
                     "at most " + std::to_string(longest_px) + " along each side");
  }
  std::array<mjtByte, 256> linear{};
  for (std::size_t i = 0; i < linear.size(); ++i) {
    linear[i] = static_cast<mjtByte>(std::lround(255.0 * linear_from_srgb(static_cast<double>(i) / 255.0)));
  }
  const mjtByte* const rgb = texture_rgb(*model, 0);
  image.rgb.resize(3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
  std::transform(rgb, rgb + image.rgb.size(), image.rgb.begin(),
                 [&](mjtByte value) { return linear[value]; });
  return image;
}

std::string xml_escaped(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    switch (c) {
      case '&':
        escaped += "&amp;";
        break;
      case '<':
        escaped += "&lt;";
        break;
      case '"':
        escaped += "&quot;";
        break;
      default:
        escaped += c;
    }
  }
  return escaped;
}

}  // namespace saccade
