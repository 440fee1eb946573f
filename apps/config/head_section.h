#pragma once

#include <filesystem>

#include "head/head_config.h"

namespace saccade {

/// The keys of a head: `file`, which read_head() reads, or `ikin_left` and `ikin_right`, lists of links for
/// description_of_ikin(); then those of HeadConfig, which change what the files say.
void describe_head(FieldVisitor& v, HeadConfig& head);

/// Reads the description of a head: a YAML file with the keys of HeadDescription, or with those of HeadConfig beside
/// `model: icub`. Throws InputError with everything that is wrong.
[[nodiscard]] HeadConfig read_head(const std::filesystem::path& path);

}  // namespace saccade
