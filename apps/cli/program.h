#pragma once

namespace saccade {

/// The command `saccade`: parses the arguments, carries out the subcommand and returns the exit status: 0 fine, 1 the run
/// failed, 2 bad input or usage, 3 an `expect:` of the scenario was not met.
[[nodiscard]] int program(int argc, const char* const* argv);

}  // namespace saccade
