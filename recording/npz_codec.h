#pragma once

#include <filesystem>
#include <memory>

#include "recording/format_registry.h"

namespace saccade {

/// NumPy's arrays: one in a `.npy` file, or several in a `.npz` file, which is a ZIP file of them (deflated or not).
///
/// Events are records with the fields t, x, y and p (tonic's layout; in any order, with a field camera or further ones), or
/// arrays of their own with these names, or one array of N rows with the columns of EventReadOptions::columns. Other names
/// and units in them: event_column(); of a field with a title, either. Numbers are whole or floating-point, of either byte
/// order. Times have the unit of EventReadOptions::time_unit, else of the name or of datetime64, else they are us, or s where
/// they are floating-point, to the nearest us; without a unit, times beyond 4e15 us of 0 and those of why_not_seconds() are an
/// InputError. p above 0 is ON.
///
/// The image size is that of an array `sensor_size` (width, height, ...) or of `width` and `height`, else
/// EventReadOptions::image_size.
///
/// The writer makes records of u16 x, u16 y, i64 t, bool p, and u8 camera where there are two: in `.npz` deflated as `events`,
/// with `sensor_size` (width, height, 2).
[[nodiscard]] RecordingFormat numpy_format();

[[nodiscard]] std::unique_ptr<EventWriter> create_numpy(const std::filesystem::path& path,
                                                        ImageSize image_size, int cameras);

}  // namespace saccade
