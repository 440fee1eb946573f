#pragma once

#include <map>
#include <string>

#include "apps/cli/command_line.h"

namespace saccade {

/// The man pages of a program: its own, PROGRAM.1, and PROGRAM-COMMAND.1 of each subcommand, in the language of man(7).
/// By file name. `version`: "0.1.0"; `date`: "2026-11-26".
[[nodiscard]] std::map<std::string, std::string> man_pages(const ProgramText& program,
                                                           const std::string& version,
                                                           const std::string& date);

}  // namespace saccade
