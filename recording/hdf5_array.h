#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "recording/array_rows.h"

namespace saccade {

/// open_array() of an HDF5 file in this process; only the helper program saccade-hdf5-reader calls it.
[[nodiscard]] std::unique_ptr<ArrayRows> open_hdf5_array_here(const std::filesystem::path& path,
                                                              const std::string& name);

}  // namespace saccade
