#pragma once

#include <string_view>

namespace saccade {

/// A file of evaluation/replay/page/, or of the library that pages embed, by its name. Empty for another name.
[[nodiscard]] std::string_view replay_asset(std::string_view name);

}  // namespace saccade
