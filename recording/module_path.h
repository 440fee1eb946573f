#pragma once

#include <filesystem>

namespace saccade {

/// The file that holds this code: the program, a shared library or a Python module.
[[nodiscard]] std::filesystem::path module_path();

}  // namespace saccade
