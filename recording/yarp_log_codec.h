#pragma once

#include <string_view>

#include "recording/event_file.h"
#include "recording/input_file.h"

namespace saccade {

/// Logs of event-driven (IIT), version 1 as YARP's data dumper wrote them until 2020, version 2 since, one packet per
/// line:
///
///     12 1571751370.660680 AE (911 4726831 1250 4726829)
///     12 1795207852.671570 AE 1000 "bytes"
///
/// a number, the host's time in s (or two of them), and either lists of numbers under the name of their type, in a
/// list AE pairs of a time stamp and an address; or type, duration (us) and the packet's little-endian words, in which
/// NUL, line feed, carriage return, quote and backslash are written as \0 \n \r \" \\. What is not AE is passed over
/// and counted, skin events too. Channels become Event::camera.
///
/// Which bits of a word are what (yarp_codec.h) is told by EventReadOptions::yarp_codec, else by a line `Codec: NAME;`
/// of the log's info file, else guessed from the first packets; format() says which it is and that it was guessed. The
/// info file of `data.log` and `binaryevents.log` is `info.log` beside it, that of any other `NAME.log` is
/// `NAME.info.log`. The image size is EventReadOptions::image_size, else that of a line `Size: WxH;` of the info file,
/// else that of the codec's sensor; pixels are not checked against it.
///
/// Times of stamped events are those of the camera's counter, to the nearest us, continued over its wraps with the
/// host's time, and later by what a line `Origin: us;` of the info file says; `Bits: N;` tells the counter's width. Bytes without stamps: the packet ends at the host's time, and its events are spread evenly over its
/// duration, the last one at its end.
///
/// The events of a packet of bytes come when the whole packet is there; it may have up to 64 MiB.
[[nodiscard]] std::unique_ptr<EventReader> open_yarp_log(InputFile file, const EventReadOptions& options);

/// Whether a file that starts like this is such a log.
[[nodiscard]] bool looks_like_yarp_log(std::string_view start);

/// event-driven's binary dumper: nothing but pairs of little-endian words, stamp and address, without a host's time.
[[nodiscard]] std::unique_ptr<EventReader> open_yarp_binary(InputFile file, const EventReadOptions& options);

/// Whether a file is such a dump: it has no mark, so its name says it (binaryevents.log), or its info file (`Type:
/// Binary`).
[[nodiscard]] bool is_yarp_binary(const std::filesystem::path& path);

/// Writes version 2 with the codec ev2_ts and 31 bits of time, and the info file beside it: besides what YARP's data
/// player reads there, codec, image size, width of the counter and when it was 0 (`Origin: us;`), so that every time
/// reads back the same. Packets end after 1 ms or 4096 events; the host's time of a packet is its last event's.
/// Throws InputError for an image of more than 2048x1024 and for times before 0 or after 4e15 us.
[[nodiscard]] std::unique_ptr<EventWriter> create_yarp_log(const std::filesystem::path& path,
                                                           ImageSize image_size, int cameras);

}  // namespace saccade
