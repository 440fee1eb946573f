#pragma once

#include <filesystem>
#include <string>

namespace saccade {

/// The text of a run's scene.json (docs/run_folder.md); empty where there is none. Throws InputError for text that is not JSON
/// of this schema.
[[nodiscard]] std::string scene_text(const std::filesystem::path& file);

}  // namespace saccade
