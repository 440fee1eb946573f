#pragma once

#include <filesystem>

#include "recording/array_file.h"
#include "recording/event_file.h"

namespace saccade {

/// What saccade-hdf5-writer.so offers, which is loaded when the first HDF5 file is written: libhdf5 needs thirty other
/// libraries. The caller owns what the members return; they throw as EventWriter and create_array_file() do. The number in the
/// name of the symbol changes with the members.
struct Hdf5Library {
  EventWriter* (*create_events)(const std::filesystem::path& path, ImageSize size, int cameras);
  ArrayFile* (*create_arrays)(const std::filesystem::path& path);
};

/// Throws RunError where the library is not found or cannot be loaded.
[[nodiscard]] const Hdf5Library& hdf5_library();

}  // namespace saccade
