#pragma once

#include <string>
#include <string_view>

#include "core/config.h"

namespace saccade {

/// A path that may be absent: empty in the configuration.
inline void optional_path(FieldVisitor& v, std::string_view key, std::string& value, std::string_view doc) {
  if (v.has_section(key, !value.empty())) v.path(key, value, doc);
}

/// Whether what `v` reads has this key; false for visitors that do not read.
[[nodiscard]] inline bool gives(FieldVisitor& v, std::string_view key) {
  return v.fills_defaults() && v.has_section(key, false);
}

}  // namespace saccade
