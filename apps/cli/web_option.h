#pragma once

#include <optional>

#include "apps/cli/command_line.h"
#include "apps/live/live_server.h"

namespace saccade {

/// Adds `--web [ADDRESS:]PORT`. `address` must outlive the parsing.
Option add_web_option(Command& command, std::optional<LiveAddress>& address);

}  // namespace saccade
