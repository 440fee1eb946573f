#include "apps/cli/program_digest.h"

#include <fmt/format.h>
#include <mujoco/mujoco.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

#include "recording/file_digest.h"
#include "session/version.h"
#include "sim/data_directory.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;

std::string bytes_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace

std::string program_digest() {
  std::string bytes = bytes_of("/proc/self/exe");
  std::vector<fs::path> models;
  for (const auto& entry : fs::recursive_directory_iterator(models_directory()))
    if (entry.is_regular_file()) models.push_back(entry.path());
  std::sort(models.begin(), models.end());
  for (const fs::path& model : models) bytes += bytes_of(model);
  return fmt::format("saccade {} ({}) {}, MuJoCo {}", version(), commit(), digest(bytes), mj_versionString());
}

}  // namespace saccade
