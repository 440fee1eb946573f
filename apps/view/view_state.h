#pragma once

#include <string>
#include <vector>

#include "apps/view/actions.h"
#include "apps/view/view_settings.h"
#include "sim/scene_renderer.h"

namespace saccade {

/// What a user has set in the window, and the actions requested since the last drawing.
struct ViewState {
  std::string name;                 ///< of what is shown
  bool with_playback = false;       ///< false beside a run: it cannot be paused, sought in or changed
  std::vector<float> event_counts;  ///< of the recording in equal parts of its time; empty for a simulation
  ViewSettings settings;
  int speed_exponent = 0;  ///< of 2; SpeedRange
  int fade_ms = 40;        ///< events older than this are not drawn
  bool with_image = true;
  bool with_circles = true;
  SceneView scene_view = profile_view();
  bool help = false;
  bool asks_to_close = false;  ///< the question whether to close the window is shown
  bool can_save = false;       ///< the settings can be saved
  bool filming = false;        ///< a video is being written
  std::string message;         ///< in place of the key hints; empty: none
  std::vector<Action> actions;

  void act(Action::Type type, std::int64_t value = 0) { actions.push_back({type, value}); }
};

}  // namespace saccade
