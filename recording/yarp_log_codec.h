#pragma once

#include <string_view>

#include "recording/event_file.h"
#include "recording/input_file.h"

namespace saccade {

/// Text logs of event-driven (IIT) as YARP's data dumper wrote them until 2020, one packet per line:
///
///     12 1571751370.660680 AE (911 4726831 1250 4726829)
///
/// a number, the host's time in s (or two of them), and lists of integers under the name of their type. A
/// list AE has pairs of a time stamp in ticks of 80 ns and an address in the codec of 24 bits, from the
/// lowest: polarity (0 = ON), x 1-10, y 12-20, corner 21, channel 22 (0 left, 1 right), type 23, skin 24.
/// The channel becomes Event::camera; corner and type are not looked at. Skin events and lists of other
/// types are passed over and counted.
///
/// The sensor is the ATIS of 304x240 unless EventReadOptions::image_size says another; pixels are not checked
/// against it. Times are rounded to the nearest us; the counter wraps at 24 to 31 bits, which the log does
/// not say: where stamps jump, the host's time tells by how many. Logs from before 2018 have another codec
/// (bit 31 of their stamps is set) and are an InputError.
[[nodiscard]] std::unique_ptr<EventReader> open_yarp_log(InputFile file, const EventReadOptions& options);

/// Whether a file that starts like this is such a log.
[[nodiscard]] bool looks_like_yarp_log(std::string_view start);

}  // namespace saccade
