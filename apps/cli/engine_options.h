#pragma once

#include "apps/cli/command_line.h"
#include "apps/sweep/sweep_engine.h"

namespace saccade {

/// Adds `--engine`, `--jobs`, `--batch` and `--sbatch`. `engine` must outlive the parsing.
void add_engine_options(Command& command, SweepEngineConfig& engine);

}  // namespace saccade
