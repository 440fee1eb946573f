#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace saccade {

/// A file of evaluation/report/page/, or of the JavaScript library that reports embed, by its name. Empty for another name.
[[nodiscard]] std::string_view report_asset(std::string_view name);

/// A Mustache template of evaluation/report/page/ filled with `data`: {{key}} is escaped for HTML, {{{key}}} is not,
/// {{#key}}...{{/key}} is repeated for each element of a list, or shown where the value is true.
[[nodiscard]] std::string rendered(std::string_view name, const nlohmann::ordered_json& data);

}  // namespace saccade
