#pragma once

namespace saccade {

/// From here on Ctrl-C and SIGTERM set a flag instead of ending the program; a second one ends it.
void catch_interrupts();
/// Whether one came.
[[nodiscard]] bool interrupted();

}  // namespace saccade
