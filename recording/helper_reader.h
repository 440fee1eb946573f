#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "recording/event_file.h"

namespace saccade {

/// A program that reads a recording and sends the events (recording/helper_server.h), and its arguments.
struct HelperCommand {
  std::filesystem::path program;
  std::vector<std::string> arguments;
};

/// Reads a recording in a helper process, for a library that a broken file can crash: a crash is an InputError with the
/// library's name and the signal, after the events before it. The helper is started with posix_spawn, which unlike fork
/// is safe beside other threads; it inherits no open file. Events arrive through a pipe in blocks, so memory does not grow
/// with the file. `name`: of the recording, for messages.
/// Throws the InputError that the helper sends, RunError where the helper cannot be started.
[[nodiscard]] std::unique_ptr<EventReader> open_in_helper(const std::string& name, const std::string& library,
                                                          const HelperCommand& command);

/// The helper of that file name, a program or a library: beside the file that holds this code (module_path.h), in libexec/saccade
/// in a folder above it, in libexec/saccade beside the folder that the environment's SACCADE_DATA names, where it is
/// installed, or where it was built. Throws RunError with these places where none has it.
[[nodiscard]] std::filesystem::path find_helper(std::string_view file_name);
/// Whether one of these places has it.
[[nodiscard]] bool has_helper(std::string_view file_name);

/// A symbol of a helper library, which stays loaded. Throws RunError where the library cannot be loaded or lacks it.
[[nodiscard]] const void* helper_symbol(std::string_view file_name, const char* symbol);

}  // namespace saccade
