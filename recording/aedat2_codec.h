#pragma once

#include "recording/format_registry.h"

namespace saccade::inline v0_1 {

/// AEDAT 2.0 (jAER): lines that start with #, then records of a big-endian u32 address and i32 time stamp.
///
/// Layouts of the address, chosen by EventReadOptions::aedat2_layout, else by the `AEChip` line of the header, else by
/// the range of the first addresses:
///   DVS128  polarity bit 0 (0 = ON), x bits 1-7, y bits 8-14, bit 15 special
///   stereo  jAER's DVS128StereoPair: as DVS128, but bit 15 is 1 for the right camera; only by header or option
///   DAVIS   polarity bit 11 (1 = ON), x bits 12-21, y bits 22-30, bits 10 and 31 special
/// Special records (images, inertial samples, triggers) are skipped. jAER's origin is bottom left and it mirrors x of
/// both layouts for display, so pixel (x, y) of an upright W x H image is stored as (W-1-x, H-1-y). W and H of a DAVIS
/// are in the header, or EventReadOptions::image_size, or those of the smallest sensor of the family that contains the
/// first addresses.
///
/// Time stamps that wrap at 2^32 (or at 2^31, as some writers do) are continued; a jump back that is not a wrap is
/// delivered as it is.
///
/// The writer uses the DVS128 layout for 128x128, the stereo layout for two cameras of that size, and the DAVIS layout
/// for other sizes up to 1024x512. It throws InputError for a larger image, for two cameras of another size, and for a
/// time stamp that would not read back the same: a first one outside i32, or a silence of more than 536 s across a wrap.
[[nodiscard]] RecordingFormat aedat2_format();

/// AEDAT 1.0 (jAER): the same with records of a big-endian u16 address, of a DVS128 or a stereo pair, and a u32 time
/// stamp that wraps at 2^32. The line with the version may be missing.
[[nodiscard]] RecordingFormat aedat1_format();

}  // namespace saccade::inline v0_1
