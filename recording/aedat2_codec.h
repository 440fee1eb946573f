#pragma once

#include "recording/format_registry.h"

namespace saccade {

/// AEDAT 2.0 (jAER): lines that start with #, then records of a big-endian u32 address and i32 time stamp.
///
/// recording/aedat2_layout.h has the layouts of the address. Layout and image size are those of the header's line `AEChip`,
/// else of EventReadOptions::aedat2_layout and image_size; an option goes before the header's layout. What neither says is
/// determined from the addresses of all records before the first event is read, and format() marks it as guessed: the layout
/// that the fewest records contradict, and of a DAVIS the smallest sensor of the family that has all pixels. Where a larger
/// sensor has them as well, so that every pixel could be shifted, it is an InputError that asks for the size.
///
/// Records that are no events (special events, APS and IMU samples, addresses of other layouts) are skipped and counted by
/// kind. A pixel outside the image is returned as it is stored. jAER's origin is bottom left and it mirrors x for display, so
/// pixel (x, y) of an upright W x H image is stored as (W-1-x, H-1-y).
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

}  // namespace saccade
