#include "evaluation/replay/scene_file.h"

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "core/error.h"

namespace saccade {

std::string scene_text(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return {};
  std::ifstream in(file, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const auto scene = nlohmann::json::parse(text, nullptr, false);
  if (scene.is_discarded()) throw InputError(file.string(), "text that is not JSON", "the scene of a run");
  if (!scene.is_object() || scene.value("schema", 0) != 1)
    throw InputError(file.string(), "another schema", "schema 1");
  for (const char* const key : {"bodies", "geoms", "meshes", "textures"}) {
    if (!scene.contains(key) || !scene.at(key).is_array())
      throw InputError(file.string(), "no list " + std::string(key), "the scene of a run");
  }
  return text;
}

}  // namespace saccade
