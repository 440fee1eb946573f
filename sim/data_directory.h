#pragma once

#include <filesystem>

namespace saccade {

/// Folder with models/ and scenarios/: the environment's SACCADE_DATA, or share/saccade in the nearest folder above the
/// file that holds this code (the program, a shared library, a Python module). An installed tree can thus be moved.
/// Throws RunError where there is none.
[[nodiscard]] std::filesystem::path data_directory();

/// Its folder of MJCF models.
[[nodiscard]] std::filesystem::path models_directory();

/// `path` if there is such a file, otherwise that file of data_directory() or of its scenarios/, `.yaml` added where it is
/// missing: "look_at_ball" is scenarios/look_at_ball.yaml. `path` itself where there is none.
[[nodiscard]] std::filesystem::path shipped_file(const std::filesystem::path& path);

}  // namespace saccade
