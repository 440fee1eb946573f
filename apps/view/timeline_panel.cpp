#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/view/colours.h"
#include "apps/view/key_bindings.h"
#include "apps/view/panel.h"
#include "apps/view/panels.h"

namespace saccade {

void TimelinePanel::draw(const ViewLayout& layout, const Snapshot& snapshot, ViewState& state) {
  const Panel panel("timeline", layout.timeline);
  const Area strip = layout.time_strip();
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const double span_us = std::max(1.0, static_cast<double>(snapshot.end_us - snapshot.start_us));
  const float bottom = strip.y + strip.height;
  draw.AddRectFilled({strip.x, strip.y}, {strip.x + strip.width, bottom}, colours::sheet, 3.0F);
  const double share_done = static_cast<double>(snapshot.now_us - snapshot.start_us) / span_us;
  const float now_x = strip.x + strip.width * static_cast<float>(share_done);
  if (state.event_counts.empty()) {
    draw.AddRectFilled({strip.x, strip.y}, {now_x, bottom}, IM_COL32(46, 66, 88, 255), 3.0F);
  } else {
    const ImageSize size{static_cast<int>(strip.width), static_cast<int>(strip.height)};
    if (size != size_) {
      paint_event_counts(state.event_counts, size, rgb_);
      texture_.set(size, rgb_);
      size_ = size;
    }
    draw_texture(texture_, strip);
    draw.AddRectFilled({strip.x, strip.y}, {now_x, bottom}, IM_COL32(70, 130, 200, 80));
  }
  if (state.with_playback) {
    ImGui::SetCursorScreenPos({strip.x, strip.y - 4.0F});
    ImGui::InvisibleButton("time", {strip.width, strip.height + 8.0F});
    const float share = std::clamp((ImGui::GetIO().MousePos.x - strip.x) / strip.width, 0.0F, 1.0F);
    const std::int64_t at_us = snapshot.start_us + std::llround(static_cast<double>(share) * span_us);
    const bool moved = ImGui::GetIO().MouseDelta.x != 0.0F || ImGui::IsItemActivated();
    if (ImGui::IsItemActive() && moved) state.act(Action::Type::seek, at_us);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%.3f s", snapshot.since_start_s(at_us));
  }
  draw.AddRectFilled({now_x - 1.0F, strip.y - 3.0F}, {now_x + 1.0F, bottom + 3.0F}, colours::white);
  const float text_y = bottom + 2.0F;
  draw.AddText({strip.x, text_y}, colours::dim, "0 s");
  const std::string end = fmt::format("{:.3f} s", snapshot.since_start_s(snapshot.end_us));
  draw.AddText({strip.x + strip.width - ImGui::CalcTextSize(end.c_str()).x, text_y}, colours::dim,
               end.c_str());
  const std::string text = state.message.empty() ? key_hints(state.with_playback) : state.message;
  const float text_width = ImGui::CalcTextSize(text.c_str()).x;
  draw.AddText({strip.x + 0.5F * (strip.width - text_width), text_y}, colours::dim, text.c_str());
}

}  // namespace saccade
