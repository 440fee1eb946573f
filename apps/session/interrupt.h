#pragma once

namespace saccade::inline v0_1 {

/// After this call Ctrl-C and SIGTERM set a flag instead of ending the program; a second signal ends it.
void catch_interrupts();
/// Whether such a signal came.
[[nodiscard]] bool interrupted();

}  // namespace saccade::inline v0_1
