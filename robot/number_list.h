#pragma once

#include <cstddef>
#include <span>
#include <string_view>

namespace saccade {

/// A list of numbers as YARP sends it in binary: a Bottle of numbers or a Vector of float64. Whole messages of robots have
/// at most this many bytes, which is checked before a message is read.
inline constexpr std::size_t longest_number_list = 4096;

/// Reads a message into `values`; numbers beyond their count are checked and discarded. `count`: numbers in the message.
/// Returns what is wrong, empty if nothing; `values` and `count` are then undefined. The counts in a message are only
/// believed as far as its bytes go.
[[nodiscard]] std::string_view read_number_list(std::span<const std::byte> message, std::span<double> values,
                                                int& count);

}  // namespace saccade
