#pragma once

#include "recording/format_registry.h"

namespace example {

/// Recordings `*.packed`: the line "PACKED1", u16 width, u16 height, then 13 bytes for each event: i64 time in us, u16 x,
/// u16 y, u8 polarity (1 is ON). Numbers are little-endian; the origin is top left; one camera.
[[nodiscard]] saccade::RecordingFormat packed_format();

}  // namespace example
