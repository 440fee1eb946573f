#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/config.h"

namespace saccade {

/// The reference of one key.
struct KeyRow {
  std::string path;           ///< "ball.diameter_m"; NAME stands for a name that the user chooses
  std::string type;           ///< "number", "whole number", "word", "list of 3 numbers" ...
  std::string unit;           ///< "m", "px", "deg/s" ...; empty without one
  std::string takes;          ///< range or words; empty if there is no restriction
  std::string default_value;  ///< as in YAML; empty where there is none
  std::string condition;      ///< "kind: waypoints" where the key exists only then
  std::string doc;            ///< the meaning
};

/// The keys that `describe_keys` visits, in its order, with the defaults of its config struct; `describe_keys` makes a new
/// struct for every call. Keys that exist only for some value of another key (a word or true and false) are found by
/// trying its values, and have that condition; keys named `preset` are not tried.
[[nodiscard]] std::vector<KeyRow> list_keys(const std::function<void(FieldVisitor&)>& describe_keys);

/// The unit that the last words of a key give: "speed_deg_s" is in deg/s; empty without one.
[[nodiscard]] std::string unit_of_key(std::string_view key);

/// The rows as text for a terminal of `width` columns, or as a Markdown table with `heading` over the paths; where there are no
/// defaults, it has no column for them.
[[nodiscard]] std::string keys_as_text(const std::vector<KeyRow>& rows, std::size_t width);
[[nodiscard]] std::string keys_as_markdown(const std::vector<KeyRow>& rows,
                                           const std::string& heading = "key");

}  // namespace saccade
