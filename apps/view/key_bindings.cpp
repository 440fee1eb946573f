#include "apps/view/key_bindings.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <algorithm>

namespace saccade {
namespace {

std::vector<KeyBinding> make_bindings() {
  using enum Action::Type;
  using enum KeyBinding::Scope;
  const auto any = std::nullopt;
  std::vector<KeyAction> digits;
  for (int i = 0; i < 9; ++i)
    digits.push_back({std::to_string(i + 1), GLFW_KEY_1 + i, any, {select_detector, i}});
  return {
      {"Space", "play, pause", "play", false, playback, {{"Space", GLFW_KEY_SPACE, any, {toggle_playing}}}},
      {"\u2190 \u2192",
       "1 ms back, forward",
       "step",
       true,
       playback,
       {{"\u2190", GLFW_KEY_LEFT, false, {step, -1'000}}, {"\u2192", GLFW_KEY_RIGHT, false, {step, 1'000}}}},
      {"Shift \u2190 \u2192",
       "10 ms back, forward",
       "",
       true,
       playback,
       {{"Shift \u2190", GLFW_KEY_LEFT, true, {step, -10'000}},
        {"Shift \u2192", GLFW_KEY_RIGHT, true, {step, 10'000}}}},
      {"Home", "to the start", "", false, playback, {{"Home", GLFW_KEY_HOME, any, {seek_start}}}},
      {"\u2191 \u2193",
       "faster, slower",
       "speed",
       true,
       playback,
       {{"\u2191", GLFW_KEY_UP, any, {change_speed, 1}}, {"\u2193", GLFW_KEY_DOWN, any, {change_speed, -1}}}},
      {"[ ]",
       "threshold of the selected detector down, up",
       "threshold",
       true,
       playback,
       {{"[", GLFW_KEY_LEFT_BRACKET, any, {scale_threshold, -1}},
        {"]", GLFW_KEY_RIGHT_BRACKET, any, {scale_threshold, 1}}}},
      {"1 to 9", "select a detector; it drives the gaze", "", false, playback, digits},
      {"I", "camera image under the events", "", false, always, {{"I", GLFW_KEY_I, any, {toggle_image}}}},
      {"C", "circles of the detectors", "", false, always, {{"C", GLFW_KEY_C, any, {toggle_circles}}}},
      {"S", "screenshot (PNG)", "screenshot", false, always, {{"S", GLFW_KEY_S, any, {take_screenshot}}}},
      {"V", "start, stop a video (MP4)", "video", false, always, {{"V", GLFW_KEY_V, any, {toggle_video}}}},
      {"H", "list of keys", "keys", false, always, {{"H", GLFW_KEY_H, any, {toggle_help}}}},
      {"W",
       "save the settings: a scenario or a file of detectors (YAML)",
       "save",
       false,
       playback,
       {{"W", GLFW_KEY_W, any, {save_settings}}}},
      {"Q", "quit", "quit", false, playback, {{"Q", GLFW_KEY_Q, any, {close}}}},
      {"Q",
       "close the window; the run continues",
       "close the window, the run continues",
       false,
       run,
       {{"Q", GLFW_KEY_Q, any, {close}}}},
      {"Esc, Enter",
       "the same after a question; Enter answers it, Esc again hides it",
       "",
       false,
       always,
       {{"Esc", GLFW_KEY_ESCAPE, any, {ask_close}}, {"Enter", GLFW_KEY_ENTER, any, {answer}}}},
  };
}

}  // namespace

const std::vector<KeyBinding>& key_bindings() {
  static const std::vector<KeyBinding> bindings = make_bindings();
  return bindings;
}

std::optional<Action> action_of_key(int code, bool shift, bool repeated, bool with_playback) {
  for (const KeyBinding& binding : key_bindings()) {
    if (!binding.holds(with_playback) || (repeated && !binding.repeats)) continue;
    for (const KeyAction& key : binding.actions) {
      if (key.code == code && key.shift.value_or(shift) == shift) return key.action;
    }
  }
  return std::nullopt;
}

std::string key_name(const Action& action) {
  for (const KeyBinding& binding : key_bindings()) {
    const auto key = std::ranges::find(binding.actions, action, &KeyAction::action);
    if (key != binding.actions.end()) return key->name;
  }
  return "";
}

std::string key_hints(bool with_playback) {
  std::string line = with_playback ? "drag to seek" : "";
  for (const KeyBinding& binding : key_bindings()) {
    if (!binding.holds(with_playback) || binding.hint.empty()) continue;
    if (!line.empty()) line += "   ";
    line += binding.keys.substr(0, binding.keys.find(',')) + " " + binding.hint;
  }
  return line;
}

}  // namespace saccade
