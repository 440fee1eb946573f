#pragma once

#include <optional>
#include <string>
#include <vector>

#include "apps/view/actions.h"

namespace saccade {

/// One key and its action.
struct KeyAction {
  std::string name;           ///< as a user reads it, "Shift \u2190"
  int code = 0;               ///< GLFW's number of the key
  std::optional<bool> shift;  ///< whether Shift must be held; none: either
  Action action;
};

/// A row in the list of keys: keys that belong together.
struct KeyBinding {
  enum class Scope { always, playback, run };  ///< of `saccade view` alone, of `run --view` alone

  std::string keys;      ///< as a user reads them, "\u2190 \u2192"
  std::string meaning;   ///< in the list of keys
  std::string hint;      ///< a word in the line below the timeline; empty: not there
  bool repeats = false;  ///< while the key is held
  Scope scope = Scope::always;
  std::vector<KeyAction> actions;

  /// Whether it holds with playback (`saccade view`) or beside a run.
  [[nodiscard]] bool holds(bool with_playback) const {
    return scope == Scope::always || (scope == Scope::playback) == with_playback;
  }
};

/// All keys of the window: the key handler, the list of keys, the line below the timeline and the tooltips of the
/// buttons read them from here.
[[nodiscard]] const std::vector<KeyBinding>& key_bindings();

/// The action of a key press; none where the key has none.
[[nodiscard]] std::optional<Action> action_of_key(int code, bool shift, bool repeated, bool with_playback);

/// The name of the key with that action, for tooltips; empty where there is none.
[[nodiscard]] std::string key_name(const Action& action);

/// The line below the timeline.
[[nodiscard]] std::string key_hints(bool with_playback);

}  // namespace saccade
