#pragma once

#include <yarp/os/Bottle.h>
#include <yarp/os/ConnectionReader.h>

#include <optional>

namespace saccade::inline v0_1 {

/// Reads a whole message of at most longest_bottle bytes, whose counts are checked before YARP believes them. None for
/// another message: it is discarded, and its sender loses the connection.
[[nodiscard]] std::optional<yarp::os::Bottle> checked_message(yarp::os::ConnectionReader& reader);

}  // namespace saccade::inline v0_1
