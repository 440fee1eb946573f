#pragma once

#include <functional>
#include <memory>
#include <string>

#include "recording/event_file.h"

namespace saccade {

/// Opens a recording, and reads it, in a child process, for a library that a broken file can crash: then this process
/// gets an InputError that names the library and the signal, behind the events that came before. `open` runs in the
/// child, which holds no other file than those that it opens itself; what it throws is thrown here. A child that takes
/// longer than `patience_s` for one block of events is ended, too. Events arrive by a pipe in blocks, so memory does
/// not grow with the file.
/// Throws InputError as `open` does, RunError where there is no further process to be had.
[[nodiscard]] std::unique_ptr<EventReader> open_in_child(
    const std::string& name, const std::string& library,
    const std::function<std::unique_ptr<EventReader>()>& open, unsigned patience_s = 60);

}  // namespace saccade
