#pragma once

#include "recording/format_registry.h"

namespace saccade {

/// AEDAT 3.1 (cAER, libcaer): lines from `#!AER-DAT3.1` to `#!END-HEADER`, then packets of one type and source each. A
/// packet has a header of 28 bytes, all little-endian: i16 type, i16 source, i32 size of an event, i32 offset of the time
/// in it, i32 number of wraps of the times, i32 capacity, i32 events, i32 valid events. An event of type 1 (polarity) is
/// a u32 (bit 0 valid, bit 1 ON, y bits 2-16, x bits 17-31) and an i32 time in us, which wraps at 2^31; the origin is top
/// left.
///
/// The reader skips and counts packets of other types, events that are marked invalid, and those of another source than
/// the first one with polarity events. The image size is that of the sensor in a line `#Source N: DAVIS346`, else
/// EventReadOptions::image_size; pixels are not checked against it. `#Format:` other than RAW is an InputError.
[[nodiscard]] RecordingFormat aedat3_format();

}  // namespace saccade
