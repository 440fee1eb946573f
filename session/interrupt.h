#pragma once

namespace saccade {

/// After this call Ctrl-C, SIGTERM and the hang-up of the terminal (SIGHUP, unless it is ignored as under nohup) set a flag
/// instead of ending the program; a second Ctrl-C or SIGTERM ends it. After a hang-up, output to the terminal is dropped.
void catch_interrupts();
/// Whether such a signal came.
[[nodiscard]] bool interrupted();

}  // namespace saccade
