#pragma once

#include <filesystem>
#include <string>

#include "emulator/emulator_config.h"
#include "evaluation/sensor_fit/stimulus.h"

namespace saccade {

/// Reads a stimulus file, and the tables of circles that it names, relative to it. Throws InputError with everything that
/// is wrong.
[[nodiscard]] StimulusFile read_stimulus_file(const std::filesystem::path& path);

/// An event camera as a file with the block `emulator`, all keys in it: for `saccade emulate --config`, and for a scenario.
[[nodiscard]] std::string emulator_yaml(EmulatorConfig config);

}  // namespace saccade
