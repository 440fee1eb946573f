#pragma once

#include <span>
#include <string>
#include <string_view>

namespace saccade {

/// MuJoCo's versions in ranges: between ranges the same scenario and seed give images whose pixels differ by some grey
/// levels, and so other events (docs/install.md). The first line of a run folder's scenario.yaml names the version,
/// "saccade 0.1.0 (9b6774e), MuJoCo 3.5.0".

/// The range of the MuJoCo version that a text names, "3.0 and newer"; empty where it names none.
[[nodiscard]] std::string_view mujoco_range(std::string_view text);

/// One sentence where the texts name versions of several ranges, else empty.
[[nodiscard]] std::string mujoco_warning(std::span<const std::string> texts);

}  // namespace saccade
