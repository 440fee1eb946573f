#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "apps/view/colours.h"
#include "apps/view/panel.h"
#include "apps/view/panels.h"

namespace saccade {
namespace {

/// A true circle: dashes of at least 5 px with gaps as long.
void dashed_circle(ImDrawList& draw, const ImVec2& centre, float radius) {
  constexpr float shortest_px = 5.0F;
  const int dashes = std::clamp(static_cast<int>(std::numbers::pi_v<float> * radius / shortest_px), 4, 24);
  const float step = 2.0F * std::numbers::pi_v<float> / static_cast<float>(dashes);
  for (int i = 0; i < dashes; ++i) {
    const float from = step * static_cast<float>(i);
    for (const auto& [colour, width] : {std::pair{colours::rim, 4.0F}, {colours::truth, 2.0F}}) {
      draw.PathArcTo(centre, radius, from, from + 0.5F * step, 8);
      draw.PathStroke(colour, 0, width);
    }
  }
}

/// Circles, gaze target and optical axis over the eye's image at `at`.
void draw_marks(const Area& at, const Snapshot& snapshot, const ViewState& state) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.PushClipRect({at.x, at.y}, {at.x + at.width, at.y + at.height}, true);
  const float scale = at.width / static_cast<float>(snapshot.camera.size.width);
  const auto place = [&](double x_px, double y_px) {
    return ImVec2(at.x + scale * static_cast<float>(x_px + 0.5),
                  at.y + scale * static_cast<float>(y_px + 0.5));
  };
  const auto circle = [&](const Circle& c, ImU32 colour, float width) {
    draw.AddCircle(place(c.x_px, c.y_px), scale * static_cast<float>(c.r_px), colour, 64, width);
  };
  for (const DetectorOutput& output : snapshot.outputs) {
    if (!state.with_circles || !output.tick.at_threshold) continue;
    circle(output.tick.estimate.circle, colours::detector(output.name),
           &output == snapshot.selected_output() ? 2.6F : 1.4F);
  }
  // Over the detections, which show through its gaps where they lie on it.
  if (snapshot.truth && snapshot.truth->circle) {
    const Circle& c = *snapshot.truth->circle;
    dashed_circle(draw, place(c.x_px, c.y_px), scale * static_cast<float>(c.r_px));
  }
  if (snapshot.truth && snapshot.truth->box_px) {
    const auto& [from, to] = *snapshot.truth->box_px;
    for (const auto& [colour, width] : {std::pair{colours::rim, 4.0F}, {colours::truth, 1.6F}})
      draw.AddRect(place(from.x(), from.y()), place(to.x(), to.y()), colour, 0.0F, 0, width);
  }
  if (snapshot.truth && snapshot.truth->target_px) {
    const ImVec2 c = place(snapshot.truth->target_px->x(), snapshot.truth->target_px->y());
    for (const auto& [colour, width] : {std::pair{colours::rim, 4.0F}, {colours::target, 2.0F}})
      draw.AddQuad({c.x - 7, c.y}, {c.x, c.y - 7}, {c.x + 7, c.y}, {c.x, c.y + 7}, colour, width);
  }
  if (snapshot.truth && snapshot.truth->root_from_cam) {
    const ImVec2 c = place(snapshot.camera.cx_px, snapshot.camera.cy_px);
    for (const auto& [colour, width] : {std::pair{colours::rim, 3.0F}, {colours::gaze, 1.2F}}) {
      draw.AddLine({c.x - 6, c.y}, {c.x + 6, c.y}, colour, width);
      draw.AddLine({c.x, c.y - 6}, {c.x, c.y + 6}, colour, width);
    }
  }
  draw.PopClipRect();
}

}  // namespace

void EyePanel::draw(const Area& area, const Snapshot& snapshot, ViewState& state) {
  paint_eye(snapshot, state.fade_ms * 1000, state.with_image, rgb_);
  texture_.set(snapshot.camera.size, rgb_);
  const Panel panel("eye", area);
  draw_caption(area, fmt::format("Eye, events of {} ms", state.fade_ms));
  Legend legend(area);
  if (snapshot.truth && snapshot.truth->target_px)
    legend.add("target", colours::target, Legend::Mark::diamond);
  if (snapshot.truth && snapshot.truth->circle) legend.add("truth", colours::truth, Legend::Mark::circle);
  if (snapshot.truth && snapshot.truth->box_px) legend.add("truth", colours::truth, Legend::Mark::square);
  legend.add("OFF", colours::off, Legend::Mark::square);
  legend.add("ON", colours::on, Legend::Mark::square);
  const Area frame = ViewLayout::below_caption(area);
  take_mouse(frame);
  const Area at = zoom_.place(area, snapshot.camera.size);
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.PushClipRect({frame.x, frame.y}, {frame.x + frame.width, frame.y + frame.height}, true);
  draw_texture(texture_, at);
  draw_marks(at, snapshot, state);
  draw.PopClipRect();
}

void EyePanel::take_mouse(const Area& frame) {
  ImGui::SetCursorScreenPos({frame.x, frame.y});
  ImGui::InvisibleButton("image", {frame.width, frame.height});
  const ImGuiIO& io = ImGui::GetIO();
  if (ImGui::IsItemActive()) zoom_.pan(io.MouseDelta.x, io.MouseDelta.y);
  if (!ImGui::IsItemHovered()) return;
  if (ImGui::IsMouseDoubleClicked(ImGuiMouseButton_Left)) zoom_.reset();
  if (io.MouseWheel != 0.0F)
    zoom_.scale(std::pow(1.2F, io.MouseWheel), io.MousePos.x - frame.x, io.MousePos.y - frame.y);
}

}  // namespace saccade
