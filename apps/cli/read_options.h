#pragma once

#include "apps/cli/command_line.h"
#include "session/replay_source.h"

namespace saccade {

/// Adds the recording (positional, `name`) and the options for reading it: --size, --columns, --time-unit, --camera,
/// --codec, --layout, --evt, --es-y and --format. The recording is one of `formats`. `options` must outlive the parsing.
/// Returns the recording.
Option add_read_options(Command& command, const char* name, const char* meaning, ReadOptions& options,
                        const FormatRegistry& formats);

/// The same options without the recording.
void add_decoding_options(Command& command, ReadOptions& options, const FormatRegistry& formats);

}  // namespace saccade
