#pragma once

#include "recording/event_file.h"
#include "recording/input_file.h"

namespace saccade {

/// AEDAT 3.1 (cAER, libcaer): lines from `#!AER-DAT3.1` to `#!END-HEADER`, then packets of one type and source each. A
/// packet has a header of 28 bytes, all little-endian: i16 type, i16 source, i32 size of an event, i32 place of the time
/// in it, i32 how often the times have wrapped, i32 capacity, i32 events, i32 valid events. An event of type 1
/// (polarity) is a u32 (bit 0 valid, bit 1 ON, y bits 2-16, x bits 17-31) and an i32 time in us, which wraps at 2^31; the
/// origin is top left.
///
/// Packets of other types, events that are marked invalid, and those of another source than the first one of polarity
/// events, are passed over and counted. The image size is the sensor's that a line `#Source N: DAVIS346` names, else
/// EventReadOptions::image_size; pixels are not checked against it. `#Format:` other than RAW is an InputError.
[[nodiscard]] std::unique_ptr<EventReader> open_aedat3(InputFile file, const EventReadOptions& options);

}  // namespace saccade
