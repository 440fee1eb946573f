#pragma once

#include <string>

#include "config/yaml_reader.h"

namespace saccade::python {

/// Keys that came from Python, as a YAML text with one key a line; empty for none. `origin` names them in messages.
[[nodiscard]] inline YamlTree tree_of(const std::string& yaml, const std::string& origin) {
  return yaml.empty() ? YamlTree{} : parse_yaml(yaml, origin);
}

/// The defaults `config` with the keys of `yaml`. Throws InputError with everything that is wrong.
template <class Config>
[[nodiscard]] Config config_of(const std::string& yaml, const std::string& origin, Config config) {
  return read_config(tree_of(yaml, origin), std::move(config));
}

}  // namespace saccade::python
