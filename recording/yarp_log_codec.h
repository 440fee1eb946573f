#pragma once

#include "recording/format_registry.h"

namespace saccade {

/// Logs of event-driven (IIT), version 1 as YARP's data dumper wrote them until 2020, version 2 since, one packet per
/// line:
///
///     12 1571751370.660680 AE (911 4726831 1250 4726829)
///     12 1795207852.671570 AE 1000 "bytes"
///
/// a number, the host's time in s (or two of them), and either lists of numbers under the name of their type, in a
/// list AE pairs of a time stamp and an address; or type, duration (us) and the packet's little-endian words, in which
/// NUL, line feed, carriage return, quote and backslash are written as \0 \n \r \" \\. The
/// reader skips and counts what is not AE, and skin events. Channels become Event::camera.
///
/// The layout of a word (yarp_codec.h) is EventReadOptions::yarp_codec, else that of a line `Codec: NAME;` of the log's
/// info file, else it is guessed from the first packets; format() names it and adds "(guessed)". The info file of
/// `data.log` and `binaryevents.log` is `info.log` beside it, that of any other `NAME.log` is `NAME.info.log`. The image
/// size is EventReadOptions::image_size, else that of a line `Size: WxH;` of the info file, else that of the codec's
/// sensor; pixels are not checked against it.
///
/// Times of stamped events are those of the camera's counter, to the nearest us, continued over its wraps with the host's
/// time, plus the number of a line `Origin: us;` of the info file; `Bits: N;` is the counter's width. Bytes without
/// stamps: the packet ends at the host's time, and its events are spread evenly over its duration, the last one at its
/// end. The events of a packet of bytes are returned when the whole packet has been read; it may have up to 64 MiB.
///
/// The writer makes version 2 with the codec ev2_ts and 31 bits of time, and the info file beside it: what YARP's data
/// player reads there, codec, image size, width of the counter and the time of its zero (`Origin: us;`), so that every
/// time reads back the same. Packets end after 1 ms or 4096 events; the host's time of a packet is its last event's. It
/// throws InputError for an image of more than 2048x1024 and for times before 0 or after 4e15 us.
[[nodiscard]] RecordingFormat yarp_log_format();
/// The writer alone: its `create`.
[[nodiscard]] std::unique_ptr<EventWriter> create_yarp_log(const std::filesystem::path& path,
                                                           ImageSize image_size, int cameras);

/// The binary dump of event-driven: nothing but pairs of little-endian words, stamp and address, without a host's time.
/// It has no mark: its name (binaryevents.log) or its info file (`Type: Binary`) identifies it.
[[nodiscard]] RecordingFormat yarp_binary_format();

}  // namespace saccade
