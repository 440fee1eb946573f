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

/// Adds the recording (positional, `name`) and what tells how to read it: --size, --columns, --camera, --codec and
/// --layout. Both must outlive the parsing.
void add_read_options(CLI::App& command, const char* name, const char* meaning, ReadOptions& options);

/// Whether the recording is the folder of a run, or of detect (else it is a file, or a folder with a log in it).
[[nodiscard]] bool is_run_folder(const std::filesystem::path& recording);
/// The events' file of a run folder, by its metrics.json; anything else as it is. Throws InputError where metrics.json
/// is missing or broken.
[[nodiscard]] std::filesystem::path events_of(const std::filesystem::path& recording);

}  // namespace saccade
