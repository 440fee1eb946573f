#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace saccade {

/// A key that was renamed: its old path in scenarios and robot files, and the new name of its last word. A word `*` of
/// the path stands for any name.
struct RenamedKey {
  std::string_view old_path;
  std::string_view new_key;
};

/// Every key that was renamed. The reader refuses an old key with the new one in its message; migrate() rewrites it.
[[nodiscard]] const std::vector<RenamedKey>& renamed_keys();

/// The current key for the last word of an old path such as "things"; none for a path that was not renamed.
[[nodiscard]] std::optional<std::string> new_key_of(std::string_view path);

/// One key that migrate() rewrote.
struct KeyRename {
  int line = 0;          ///< from 1
  std::string old_text;  ///< as the file had it: a key, or the path of a sweep's setting
  std::string new_text;
};

struct Migration {
  std::string text;                ///< the file with the keys of today
  std::vector<KeyRename> renames;  ///< in file order; none: the text is unchanged
};

/// Rewrites the old keys of a scenario, robot file or sweep; in a sweep the paths in `set`, `axes`, their `cases`,
/// `except` and `only` too. Everything else, comments and line ends included, stays byte for byte. `file` is its name in
/// messages. Throws InputError for text that is no YAML, for an old key beside its new one, and for a key that cannot be
/// located in the text.
[[nodiscard]] Migration migrate(const std::string& text, const std::string& file);

}  // namespace saccade
