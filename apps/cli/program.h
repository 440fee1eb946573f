#pragma once

#include "config/registry.h"

namespace saccade {

/// The command `saccade`: parses the arguments, carries out the subcommand and returns the exit status: 0 fine, 1 the run
/// failed, 2 bad input or usage, 3 an `expect:` of the scenario was not met. `registry` holds everything that files and
/// options can name: built_in_registry(), or that with rows added.
[[nodiscard]] int program(int argc, const char* const* argv, const Registry& registry);

/// What saccade ships.
[[nodiscard]] Registry built_in_registry();

}  // namespace saccade
