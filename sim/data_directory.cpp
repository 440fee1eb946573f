#include "sim/data_directory.h"

#include <array>
#include <cstdlib>
#include <string>

#include "core/error.h"
#include "recording/module_path.h"

namespace saccade {

namespace fs = std::filesystem;

fs::path data_directory() {
  if (const char* const set = std::getenv("SACCADE_DATA"); set != nullptr && *set != '\0') return set;
  std::error_code ignored;
  const fs::path file = module_path();
  for (fs::path folder = file.parent_path(); !folder.empty(); folder = folder.parent_path()) {
    const fs::path data = folder / "share/saccade";
    if (fs::is_directory(data / "models", ignored)) return data;
    if (folder == folder.root_path()) break;
  }
#ifdef SACCADE_SOURCE_DATA_DIR
  return SACCADE_SOURCE_DATA_DIR;
#else
  throw RunError("no folder share/saccade with the models above " + file.string() +
                 "; the environment variable SACCADE_DATA can name it");
#endif
}

fs::path models_directory() { return data_directory() / "models"; }

fs::path shipped_file(const fs::path& path) {
  std::error_code ignored;
  if (path.empty() || path.is_absolute() || fs::exists(path, ignored)) return path;
  fs::path with_ending = path;
  with_ending += ".yaml";
  const fs::path data = data_directory();
  for (const fs::path& name : {path, with_ending}) {
    for (const fs::path& folder : {data, data / "scenarios"}) {
      if (fs::is_regular_file(folder / name, ignored)) return folder / name;
    }
  }
  return path;
}

}  // namespace saccade
