#pragma once

#include "recording/format_registry.h"

namespace saccade {

/// Prophesee's DAT: lines `% key value`, two bytes (type of the events, size of one), then events of 8 bytes: a
/// little-endian u32 time in us, which wraps at 2^32, and a u32 address. Types are 0x00 and 0x0C for events of pixels;
/// another one (0x0E are triggers) is an InputError, as is another size than 8.
///   version 2   x bits 0-13, y bits 14-27, polarity bit 28 (1 = ON)
///   version 1   x bits 0-8, y bits 9-16, polarity bit 17; also where the header names no version
/// The origin is top left. The image size is in the header, else in EventReadOptions::image_size; pixels are not checked
/// against it.
[[nodiscard]] RecordingFormat prophesee_dat_format();

}  // namespace saccade
