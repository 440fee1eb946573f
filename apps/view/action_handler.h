#pragma once

#include "apps/view/player_thread.h"
#include "apps/view/view_state.h"

namespace saccade {

/// Applies an action to state and playback. `player` is null beside a run; then actions on playback do nothing.
/// False for actions on the window and on files (close, take_screenshot, toggle_video, save_settings), which are the caller's.
bool apply_action(const Action& action, const Snapshot& snapshot, ViewState& state, PlayerThread* player);

}  // namespace saccade
