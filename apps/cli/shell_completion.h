#pragma once

#include <string>
#include <vector>

#include "apps/cli/command_line.h"

namespace saccade {

/// Scripts that complete subcommands, options, their values, files and the names of `scenarios`. They need nothing beside
/// the shell.
[[nodiscard]] std::string bash_completion(const ProgramText& program,
                                          const std::vector<std::string>& scenarios);
[[nodiscard]] std::string zsh_completion(const ProgramText& program,
                                         const std::vector<std::string>& scenarios);

}  // namespace saccade
