#pragma once

#include <filesystem>

namespace saccade::inline v0_1 {

/// The file that holds this code: the program, a shared library or a Python module.
[[nodiscard]] std::filesystem::path own_file();

}  // namespace saccade::inline v0_1
