#pragma once

#include <chrono>
#include <functional>
#include <string>

namespace saccade {

/// Longest time in which deploy and guard close the connections of a robot, and in which serve closes its own.
inline constexpr std::chrono::milliseconds longest_close{3000};
inline constexpr std::chrono::milliseconds longest_serve_close{500};

/// Calls `close`, which closes the connections of a robot. Another program that is halted in the middle of a message can
/// make that wait for ever: after `limit` the program ends here, with status 0, or 1 if there is an `error` (printed).
/// Everything of the run must be on disk before.
void close_within(std::chrono::milliseconds limit, const std::function<void()>& close,
                  const std::string& error);

}  // namespace saccade
