#include <fmt/format.h>

#include <algorithm>

#include "apps/view/colours.h"
#include "apps/view/panel.h"
#include "apps/view/panels.h"

namespace saccade {

void HoughPanel::draw(const Area& area, const Snapshot& snapshot) {
  if (!snapshot.hough.empty()) {
    paint_hough(snapshot, rgb_);
    texture_.set(snapshot.camera.size, rgb_);
  }
  const Panel panel("hough", area);
  const DetectorOutput* output = snapshot.selected_output();
  draw_caption(area, output != nullptr ? fmt::format("Hough space, {}", output->name) : "Hough space");
  const Area at = ViewLayout::fit(area, snapshot.camera.size);
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  if (snapshot.hough.empty()) {
    draw.AddText({at.x + 12.0F, at.y + 0.45F * at.height}, colours::dim,
                 output != nullptr ? "This detector has none." : "No detector.");
    return;
  }
  draw_texture(texture_, at);
  const std::size_t best =
      static_cast<std::size_t>(std::ranges::max_element(snapshot.hough) - snapshot.hough.begin());
  const float scale = at.width / static_cast<float>(snapshot.camera.size.width);
  const auto width = static_cast<std::size_t>(snapshot.camera.size.width);
  const ImVec2 peak(at.x + scale * (static_cast<float>(best % width) + 0.5F),
                    at.y + scale * (static_cast<float>(best / width) + 0.5F));
  if (snapshot.hough[best] > 0.0F) draw.AddCircle(peak, 9.0F, IM_COL32(120, 220, 255, 255), 24, 1.4F);
  const std::string text = fmt::format("maximum {:.3g}", snapshot.hough[best]);
  draw.AddRectFilled({at.x, at.y + at.height - 19.0F},
                     {at.x + ImGui::CalcTextSize(text.c_str()).x + 12.0F, at.y + at.height}, colours::rim);
  draw.AddText({at.x + 6.0F, at.y + at.height - 18.0F}, colours::dim, text.c_str());
}

}  // namespace saccade
