#pragma once

#include "recording/format_registry.h"

namespace saccade {

/// The first line of an AEDAT 4.0 file.
inline constexpr std::string_view aedat4_mark = "#!AER-DAT4.0\r\n";

/// AEDAT 4.0 (DV, dv-processing): a line `#!AER-DAT4.0`, a u32 size and a FlatBuffers table of that many bytes
/// (compression, offset of the table of packets at the file's end, XML that describes the streams), then packets of any
/// stream: i32 stream, i32 size, and `size` bytes that are a size-prefixed table, raw or as a frame of LZ4 or ZSTD. All
/// numbers are little-endian. recording/aedat4.fbs is the schema of the tables.
///
/// The reader returns the events of the stream of type EVTS with the lowest number; it skips and counts packets of other
/// streams (images, inertial samples, triggers, further events). An event has 16 bytes: i64 time in us, i16 x, i16 y, u8
/// polarity (1 = ON), 3 unused; the origin is top left. The image size is in the XML, else it is
/// EventReadOptions::image_size; pixels are not checked against it.
///
/// Packets of any size are decompressed in pieces of 64 KiB. The file is whole when its packets end at the table of
/// packets. A file without that table (its recorder was interrupted) ends with its last packet.
///
/// The writer makes one stream of events, number 0, in packets of up to 8192 events with LZ4, and the table of packets at
/// the end that other readers seek by. Times are any i64. It throws InputError for an image larger than 32767 pixels.
[[nodiscard]] RecordingFormat aedat4_format();

/// The writer alone: `RecordingFormat::create` of AEDAT 4.0.
[[nodiscard]] std::unique_ptr<EventWriter> create_aedat4(const std::filesystem::path& path,
                                                         ImageSize image_size, int cameras);

}  // namespace saccade
