#pragma once

#include "apps/view/images.h"
#include "apps/view/layout.h"
#include "apps/view/snapshot.h"
#include "apps/view/view_state.h"
#include "apps/view/window.h"

namespace saccade {

/// The panels of the window. Each draws a snapshot and the state, changes the state where the user edits it, and appends
/// the actions that the user requests. Those with images own a texture.

/// Buttons, speed, time, phase of the gaze. In bar_panel.cpp.
void draw_bar_panel(const Area& area, const Snapshot& snapshot, ViewState& state);

/// Names, scores and colours of the detectors. In detectors_panel.cpp.
void draw_detectors_panel(const Area& area, const Snapshot& snapshot, ViewState& state);

/// The list of keys, where ViewState::help is set, in the middle of a window of width x height. In help_panel.cpp.
void draw_help(int width, int height, ViewState& state);

/// The question whether to close the window, where ViewState::asks_to_close is set, in the middle of the window. In
/// help_panel.cpp.
void draw_question(int width, int height, ViewState& state);

/// Events, camera image, circles and target; the wheel enlarges, dragging moves, a double click shows all. In eye_panel.cpp.
class EyePanel {
 public:
  explicit EyePanel(Window& window) : texture_(window, false) {}
  void draw(const Area& area, const Snapshot& snapshot, ViewState& state);

 private:
  void take_mouse(const Area& frame);

  Window::Texture texture_;
  RgbImage rgb_;
  ImageZoom zoom_;
};

/// The Hough space of the selected detector. In hough_panel.cpp.
class HoughPanel {
 public:
  explicit HoughPanel(Window& window) : texture_(window, false) {}
  void draw(const Area& area, const Snapshot& snapshot);

 private:
  Window::Texture texture_;
  RgbImage rgb_;
};

/// Curves of the last seconds. In plots_panel.cpp.
class PlotsPanel {
 public:
  explicit PlotsPanel(Window& window) : texture_(window, false) {}
  void draw(const Area& area, const Snapshot& snapshot);

 private:
  Window::Texture texture_;
};

/// Time and events of the recording; a drag seeks. In timeline_panel.cpp.
class TimelinePanel {
 public:
  explicit TimelinePanel(Window& window) : texture_(window, false) {}
  void draw(const ViewLayout& layout, const Snapshot& snapshot, ViewState& state);

 private:
  Window::Texture texture_;
  ImageSize size_;
  RgbImage rgb_;
};

}  // namespace saccade
