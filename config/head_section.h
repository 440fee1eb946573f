#pragma once

#include <filesystem>
#include <optional>

#include "head/head_config.h"

namespace saccade {

/// The keys of a head: `file`, which read_head() reads, or `ikin_left` and `ikin_right`, lists of links for
/// description_of_ikin(), or `urdf` or `mjcf` with `chain` and `camera`, a model of a robot for chain_of_urdf() or
/// chain_of_mjcf(); then those of HeadConfig, which change what the files say.
void describe_head(FieldVisitor& v, HeadConfig& head);

/// Reads the description of a head: a YAML file with the keys of HeadDescription or of a model, or with those of HeadConfig beside
/// `model: icub`. Throws InputError with everything that is wrong.
[[nodiscard]] HeadConfig read_head(const std::filesystem::path& path);

/// The head of a run: the block `head` of a file with every value, as a run folder has it (scenario.yaml or robot.yaml). Other
/// keys are not looked at. None where the file does not exist or has no such block. Throws InputError for a broken one.
[[nodiscard]] std::optional<HeadConfig> read_recorded_head(const std::filesystem::path& path);

}  // namespace saccade
