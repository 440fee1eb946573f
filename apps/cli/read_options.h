#pragma once

#include "apps/cli/command_line.h"
#include "apps/session/played.h"

namespace saccade {

/// Adds the recording (positional, `name`) and what tells how to read it: --size, --columns, --camera, --codec and
/// --layout. Both must outlive the parsing.
void add_read_options(Command& command, const char* name, const char* meaning, ReadOptions& options);

}  // namespace saccade
