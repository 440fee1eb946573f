#pragma once

#include <imgui.h>

#include <string>

#include "apps/view/layout.h"
#include "apps/view/window.h"

namespace saccade {

/// An ImGui window without decoration at a fixed place, open while this object exists.
class Panel {
 public:
  Panel(const char* name, const Area& area, bool scrolls = false);
  ~Panel() { ImGui::End(); }
  Panel(const Panel&) = delete;
  Panel& operator=(const Panel&) = delete;
};

/// What was rejected or has ended, wrapped at the panel's width.
void draw_problem(const std::string& text);

/// Draws the caption of a panel.
void draw_caption(const Area& area, const std::string& text);

/// Words at the right end of a caption, each after a mark in its colour. The first one that is added is the rightmost.
class Legend {
 public:
  enum class Mark { circle, diamond, square };

  explicit Legend(const Area& area) : x_(area.x + area.width - 8.0F), y_(area.y + 4.0F) {}
  void add(const char* word, ImU32 colour, Mark mark);

 private:
  float x_, y_;
};

/// Draws a texture into the current panel.
void draw_texture(const Window::Texture& texture, const Area& at);

/// Fills the gaps between the panels of a window of width x height. The panels themselves have the window's ground: a
/// software renderer needs time for each pixel that is drawn twice.
void draw_gaps(const ViewLayout& layout, int width, int height);

}  // namespace saccade
