#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <memory>

#include "recording/event_file.h"

namespace saccade {

/// The recording that a subcommand reads, and what its file may leave open.
struct ReadOptions {
  std::filesystem::path recording;
  EventReadOptions read;
};

/// Adds the recording (positional, `name`), --size, --columns and --camera. Both must outlive the parsing.
void add_read_options(CLI::App& command, const char* name, const char* meaning, ReadOptions& options);

}  // namespace saccade
