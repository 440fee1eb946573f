#pragma once

#include <filesystem>

#include "core/model_arrays.h"

namespace saccade {

/// Reads the arrays of a model: an NPZ file (a ZIP file of arrays in NumPy's format) of float32 in C order, little-endian, as
/// numpy.savez and numpy.savez_compressed write it. An array has the name of its member without `.npy`. Throws InputError for
/// a missing, torn or other file.
[[nodiscard]] ModelArrays read_model(const std::filesystem::path& path);

}  // namespace saccade
