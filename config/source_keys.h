#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace saccade {

/// Keys beside one that names a file, such as the joints that are taken from it. A visitor that has them is one of these as
/// well as a FieldVisitor; only a reader returns values, for what the file holds takes the place of the keys.
class SourceKeys {
 public:
  virtual ~SourceKeys() = default;
  /// A list of names; none where the key is absent.
  virtual std::optional<std::vector<std::string>> names(std::string_view key, std::string_view doc) = 0;
  /// One word; none where the key is absent. `usual`: what holds without it, for the reference of keys.
  virtual std::optional<std::string> word(std::string_view key, std::string_view usual,
                                          std::string_view doc) = 0;
};

}  // namespace saccade
