// The table of key bindings, and the documentation of it.
#include "apps/view/key_bindings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>
#include <utility>

#include "apps/view/action_handler.h"

namespace saccade {
namespace {

using Scope = KeyBinding::Scope;

TEST(KeyBindings, NoKeyHasTwoActions) {
  for (const bool with_playback : {false, true}) {
    std::set<std::pair<int, bool>> taken;
    for (const KeyBinding& binding : key_bindings()) {
      if (!binding.holds(with_playback)) continue;
      for (const KeyAction& key : binding.actions) {
        for (const bool shift : {false, true}) {
          if (key.shift.value_or(shift) != shift) continue;
          EXPECT_TRUE(taken.emplace(key.code, shift).second) << key.name;
          EXPECT_EQ(action_of_key(key.code, shift, false, with_playback), key.action) << key.name;
        }
      }
    }
  }
}

TEST(KeyBindings, AHeldKeyRepeatsOnlyWhereItsBindingSaysSo) {
  for (const KeyBinding& binding : key_bindings()) {
    for (const KeyAction& key : binding.actions) {
      const bool repeats = action_of_key(key.code, key.shift.value_or(false), true, true).has_value();
      EXPECT_EQ(repeats, binding.repeats && binding.holds(true)) << key.name;
    }
  }
}

TEST(KeyBindings, BesideARunThereAreNoKeysOfPlayback) {
  for (const KeyBinding& binding : key_bindings()) {
    if (binding.scope != Scope::playback || binding.keys == "Q") continue;
    for (const KeyAction& key : binding.actions)
      EXPECT_FALSE(action_of_key(key.code, key.shift.value_or(false), false, false)) << key.name;
  }
}

TEST(KeyBindings, EscAsksBeforeItClosesAndOnlyEnterAfterItCloses) {
  const auto action = [](const char* name) {
    for (const KeyBinding& binding : key_bindings()) {
      for (const KeyAction& key : binding.actions) {
        if (key.name == name) return key.action;
      }
    }
    return Action{};
  };
  ViewState state;
  const auto press = [&](const char* name) {
    EXPECT_TRUE(apply_action(action(name), Snapshot{}, state, nullptr)) << "the window is not closed at once";
    return std::exchange(state.actions, {});
  };
  EXPECT_TRUE(press("Enter").empty()) << "nothing is asked";
  EXPECT_TRUE(press("Esc").empty());
  EXPECT_TRUE(state.asks_to_close);
  EXPECT_TRUE(press("Esc").empty());
  EXPECT_FALSE(state.asks_to_close) << "a second Esc hides the question";
  press("Esc");
  EXPECT_THAT(press("Enter"), testing::ElementsAre(Action{Action::Type::close}));
}

TEST(KeyBindings, TheLineBelowTheTimelineNamesTheKeysOfItsScope) {
  EXPECT_THAT(key_hints(true), testing::HasSubstr("Space play"));
  EXPECT_THAT(key_hints(true), testing::HasSubstr("Q quit"));
  EXPECT_THAT(key_hints(false), testing::Not(testing::HasSubstr("Space")));
  EXPECT_THAT(key_hints(false), testing::HasSubstr("Q close the window"));
}

TEST(KeyBindings, TheDocumentListsExactlyTheKeysOfTheTable) {
  std::ifstream file(std::string(SACCADE_SOURCE_DIR) + "/docs/view.md");
  std::stringstream text;
  text << file.rdbuf();
  std::string expected = "| key | action |\n|---|---|\n";
  for (const KeyBinding& binding : key_bindings())
    expected += "| " + binding.keys + " | " + binding.meaning +
                (binding.scope == Scope::run ? " (`run --view`)" : "") + " |\n";
  EXPECT_THAT(text.str(), testing::HasSubstr(expected));
}

}  // namespace
}  // namespace saccade
