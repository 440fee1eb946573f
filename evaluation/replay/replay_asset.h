#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace saccade {

/// A file of evaluation/replay/page/, or of the library that pages embed, by its name. Empty for another name.
[[nodiscard]] std::string_view replay_asset(std::string_view name);

/// The text with each `{{{name}}}` replaced by its value, which is not searched itself. Every name has a value.
[[nodiscard]] std::string filled_page(
    std::string_view text, const std::vector<std::pair<std::string_view, std::string_view>>& values);

}  // namespace saccade
