#pragma once

#include <filesystem>
#include <memory>

#include "recording/event_file.h"

namespace saccade {

/// Reads HDF5 (recording/hdf5_codec.h) in this process. libhdf5 crashes on some broken files, so only the helper program
/// saccade-hdf5-reader calls it. Throws InputError.
[[nodiscard]] std::unique_ptr<EventReader> open_hdf5_here(const std::filesystem::path& path,
                                                          const EventReadOptions& options);

}  // namespace saccade
