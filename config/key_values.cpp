#include "config/key_values.h"

#include <utility>

namespace saccade {

std::vector<double> KeyValues::numbers(std::string_view path) const {
  const auto found = numbers_.find(path);
  return found != numbers_.end() ? found->second : std::vector<double>{};
}

void KeyValues::section(std::string_view key, const std::function<void(FieldVisitor&)>& describe_section,
                        std::string_view) {
  add(key, {});
  const std::string outer = std::exchange(prefix_, prefix_ + std::string(key) + ".");
  describe_section(*this);
  prefix_ = outer;
}

}  // namespace saccade
