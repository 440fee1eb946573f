#include "apps/view/action_handler.h"

#include <algorithm>
#include <cmath>

namespace saccade {
namespace {

void change_speed_to(int exponent, ViewState& state, PlayerThread& player) {
  state.speed_exponent = std::clamp(exponent, SpeedRange::slowest, SpeedRange::unlimited);
  player.set_speed(state.speed_exponent > SpeedRange::fastest ? PlayerThread::unlimited_speed
                                                              : std::exp2(state.speed_exponent));
}

/// Where the threshold would leave its range it stays as it is.
void scale_selected_threshold(double factor, ViewState& state, PlayerThread& player) {
  ViewDetector* detector = state.settings.selected_detector();
  if (detector == nullptr || !detector->config.scale_threshold(factor)) return;
  player.apply(state.settings);
}

void select(std::size_t index, ViewState& state, PlayerThread& player) {
  if (index >= state.settings.detectors.size()) return;
  state.settings.selected = index;
  state.settings.detectors[index].enabled = true;
  player.apply(state.settings);
}

void apply_to_playback(const Action& action, const Snapshot& snapshot, ViewState& state,
                       PlayerThread& player) {
  using enum Action::Type;
  switch (action.type) {
    case toggle_playing:
      if (!snapshot.playing && snapshot.now_us >= snapshot.end_us) player.seek(snapshot.start_us);
      return player.play(!snapshot.playing);
    case seek:
      return player.seek(action.value);
    case seek_start:
      return player.seek(snapshot.start_us);
    case step:
      return player.step(action.value);
    case set_speed:
      return change_speed_to(static_cast<int>(action.value), state, player);
    case change_speed:
      return change_speed_to(state.speed_exponent + static_cast<int>(action.value), state, player);
    case scale_threshold:
      return scale_selected_threshold(action.value > 0 ? 1.1 : 1.0 / 1.1, state, player);
    case select_detector:
      return select(static_cast<std::size_t>(action.value), state, player);
    case apply_settings:
      return player.apply(state.settings);
    default:
      return;
  }
}

}  // namespace

bool apply_action(const Action& action, const Snapshot& snapshot, ViewState& state, PlayerThread* player) {
  using enum Action::Type;
  switch (action.type) {
    case close:
    case take_screenshot:
    case toggle_video:
    case save_settings:
      return false;
    case ask_close:
      state.asks_to_close = !state.asks_to_close;
      return true;
    case answer:
      if (state.asks_to_close) state.act(close);
      return true;
    case toggle_image:
      state.with_image = !state.with_image;
      return true;
    case toggle_circles:
      state.with_circles = !state.with_circles;
      return true;
    case toggle_help:
      state.help = !state.help;
      return true;
    default:
      if (player != nullptr) apply_to_playback(action, snapshot, state, *player);
      return true;
  }
}

}  // namespace saccade
