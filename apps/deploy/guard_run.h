#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace saccade {

struct Registry;

/// How guard() runs.
struct GuardOptions {
  std::filesystem::path robot;           ///< robot file, that of deploy
  std::vector<std::string> assignments;  ///< overrides of the robot file
  std::optional<double> duration_s;      ///< none: until an interrupt
};

/// Stops the head that a robot file names when `saccade deploy` with that file dies, hangs or is halted: looks every 2 ms
/// at the time of its newest tick, and has a connection of its own to the head. Runs until an interrupt, beside any number
/// of deploy runs one after the other. A lost connection to the head is made again (GuardHead). Throws InputError; RunError
/// if the network is not there at the start, or the head has a guard already.
void guard(const GuardOptions& options, const Registry& registry);

}  // namespace saccade
