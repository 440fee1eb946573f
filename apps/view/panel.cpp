#include "apps/view/panel.h"

#include "apps/view/colours.h"

namespace saccade {

Panel::Panel(const char* name, const Area& area, bool scrolls) {
  ImGui::SetNextWindowPos({area.x, area.y});
  ImGui::SetNextWindowSize({area.width, area.height});
  ImGui::Begin(name, nullptr,
               ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                   ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoBringToFrontOnFocus |
                   ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoBackground |
                   (scrolls ? 0 : ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse));
}

void draw_problem(const std::string& text) {
  ImGui::PushStyleColor(ImGuiCol_Text, colours::problem);
  ImGui::PushTextWrapPos(0.0F);
  ImGui::TextUnformatted(text.c_str());
  ImGui::PopTextWrapPos();
  ImGui::PopStyleColor();
}

void draw_caption(const Area& area, const std::string& text) {
  ImGui::GetWindowDrawList()->AddText({area.x + 8.0F, area.y + 4.0F}, ImGui::GetColorU32(ImGuiCol_Text),
                                      text.c_str());
}

void Legend::add(const char* word, ImU32 colour, Mark mark) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  x_ -= ImGui::CalcTextSize(word).x;
  draw.AddText({x_, y_}, colours::dim, word);
  x_ -= 10.0F;
  const ImVec2 at(x_, y_ + 8.0F);
  switch (mark) {
    case Mark::circle:
      draw.AddCircle(at, 4.0F, colour, 12, 1.6F);
      break;
    case Mark::diamond:
      draw.AddQuad({at.x - 5, at.y}, {at.x, at.y - 5}, {at.x + 5, at.y}, {at.x, at.y + 5}, colour, 1.6F);
      break;
    case Mark::square:
      draw.AddRectFilled({at.x - 4, at.y - 4}, {at.x + 4, at.y + 4}, colour);
      break;
  }
  x_ -= 14.0F;
}

void draw_texture(const Window::Texture& texture, const Area& at) {
  ImGui::GetWindowDrawList()->AddImage(texture.id(), {at.x, at.y}, {at.x + at.width, at.y + at.height});
}

void draw_gaps(const ViewLayout& layout, int width, int height) {
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  const auto w = static_cast<float>(width);
  const auto h = static_cast<float>(height);
  const auto fill = [&](float left, float top, float right, float bottom) {
    draw.AddRectFilled({left, top}, {right, bottom}, colours::gap);
  };
  const auto below = [](const Area& area) { return area.y + area.height; };
  const auto beside = [](const Area& area) { return area.x + area.width; };
  fill(0, 0, w, layout.bar.y);
  fill(0, below(layout.bar), w, layout.scene.y);
  fill(0, below(layout.scene), layout.settings.x, layout.plots.y);
  fill(0, below(layout.plots), w, layout.timeline.y);
  fill(0, below(layout.timeline), w, h);
  fill(0, layout.bar.y, layout.bar.x, below(layout.timeline));
  fill(beside(layout.bar), layout.bar.y, w, below(layout.timeline));
  fill(beside(layout.scene), layout.scene.y, layout.eye.x, below(layout.scene));
  fill(beside(layout.eye), layout.eye.y, layout.hough.x, below(layout.eye));
  fill(beside(layout.hough), layout.hough.y, layout.settings.x, below(layout.settings));
  fill(layout.hough.x, below(layout.hough), beside(layout.hough), layout.detectors.y);
}

}  // namespace saccade
