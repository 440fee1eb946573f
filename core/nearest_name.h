#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace saccade {

/// The one of `known` that was probably meant: close to `name` in spelling, or the same with a unit; empty where none is.
[[nodiscard]] std::string nearest_name(std::string_view name, const std::vector<std::string>& known);

}  // namespace saccade
