#pragma once

#include "recording/event_file.h"
#include "recording/input_file.h"

namespace saccade {

/// AEDAT 4.0 (DV, dv-processing): a line `#!AER-DAT4.0`, a u32 size and a FlatBuffers table of that many
/// bytes (compression, place of the table of packets at the file's end, XML that describes the streams),
/// then packets of any stream: i32 stream, i32 size, and `size` bytes that are a size-prefixed table, raw or
/// as a frame of LZ4 or ZSTD. All numbers are little-endian.
///
/// Events are those of the stream of type EVTS with the lowest number; packets of other streams (images, inertial samples, triggers, further events) are passed over and counted. An
/// event has 16 bytes: i64 time in us, i16 x, i16 y, u8 polarity (1 = ON), 3 unused; the origin is top left.
/// The image size is in the XML, else in EventReadOptions::image_size; pixels are not checked against it.
///
/// Packets of any size are unpacked in pieces of 64 KiB. The file is whole when its packets end at the
/// table of packets; one that never got its table (a recording that was broken off) ends with its last
/// packet.
[[nodiscard]] std::unique_ptr<EventReader> open_aedat4(InputFile file, const EventReadOptions& options);

/// Writes one stream of events, number 0, in packets of up to 8192 events with LZ4, with the table of packets at the end
/// that other readers seek by. Times are whatever i64 holds. Throws InputError for two cameras and for an image larger
/// than 32767 pixels.
[[nodiscard]] std::unique_ptr<EventWriter> create_aedat4(const std::filesystem::path& path,
                                                         ImageSize image_size, int cameras);

}  // namespace saccade
