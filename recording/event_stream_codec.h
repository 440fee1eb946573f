#pragma once

#include "recording/format_registry.h"

namespace saccade {

/// Event Stream 2 (.es, of sepia and loris): "Event Stream", three bytes of version, one of type, and for cameras u16
/// width and height, little-endian. Type 1 (DVS) alone is read; generic, ATIS and colour events are an InputError.
/// An event has 5 bytes: the time since the last one in us in bits 1-7 and ON in bit 0, u16 x, u16 y. A byte 0xFF is
/// 127 us without an event, 0xFE a reset, which is skipped and counted.
///
/// The format's origin is bottom left: y is returned as height - 1 - y, with EventReadOptions::event_stream_y "down" as it is
/// stored. A pixel outside the image is returned as it is stored.
[[nodiscard]] RecordingFormat event_stream_format();

}  // namespace saccade
