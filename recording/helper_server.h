#pragma once

#include <functional>
#include <memory>

#include "recording/array_rows.h"
#include "recording/event_file.h"

namespace saccade {

/// The main function of a helper process (recording/helper_reader.h): opens a recording and writes its events, or the
/// error, to `pipe`; then the process exits. A call of `open` or of the reader that takes longer than `limit_s` ends the
/// process with SIGALRM.
[[noreturn]] void serve_events(int pipe, const std::function<std::unique_ptr<EventReader>()>& open,
                               unsigned limit_s = 60);

/// The same for an array, of which `open` may return none.
[[noreturn]] void serve_array(int pipe, const std::function<std::unique_ptr<ArrayRows>()>& open,
                              unsigned limit_s = 60);

}  // namespace saccade
