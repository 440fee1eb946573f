#include <fmt/format.h>

#include <algorithm>

#include "apps/view/colours.h"
#include "apps/view/panel.h"
#include "apps/view/panels.h"

namespace saccade {
namespace {

void draw_row(std::size_t index, float right, const Snapshot& snapshot, ViewState& state) {
  ViewDetector& detector = state.settings.detectors[index];
  const bool selected = index == state.settings.selected;
  const ImVec2 row = ImGui::GetCursorScreenPos();
  if (state.with_playback) {
    bool enabled = detector.enabled;
    if (ImGui::Checkbox("##enabled", &enabled) && !selected) {
      detector.enabled = enabled;
      state.act(Action::Type::apply_settings);
    }
    if (ImGui::IsItemHovered())
      ImGui::SetTooltip(selected ? "The selected detector always runs" : "Whether this detector runs");
    ImGui::SameLine();
  }
  const float left = ImGui::GetCursorScreenPos().x;
  ImGui::GetWindowDrawList()->AddRectFilled({left, row.y + 5.0F}, {left + 10.0F, row.y + 15.0F},
                                            colours::detector(detector.name));
  ImGui::SetCursorScreenPos({left + 16.0F, row.y});
  ImGui::AlignTextToFramePadding();
  if (selected) {
    ImGui::TextUnformatted(detector.name.c_str());
  } else {
    ImGui::TextDisabled("%s", detector.name.c_str());
  }
  if (state.with_playback && ImGui::IsItemClicked())
    state.act(Action::Type::select_detector, static_cast<std::int64_t>(index));
  const auto output = std::ranges::find(snapshot.outputs, detector.name, &DetectorOutput::name);
  if (output != snapshot.outputs.end() && !output->failure.empty()) {
    ImGui::SameLine(right - ImGui::CalcTextSize("ended").x);
    ImGui::AlignTextToFramePadding();
    draw_problem("ended");
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", output->failure.c_str());
    return;
  }
  if (output == snapshot.outputs.end() || !output->tick.observed) return;
  const bool accepted = output->tick.at_threshold;
  const std::string text =
      fmt::format("{}{:.2f}", output->tick.estimate.held ? "predicted " : "", output->tick.estimate.score);
  ImGui::SameLine(right - ImGui::CalcTextSize(text.c_str()).x);
  ImGui::AlignTextToFramePadding();
  accepted ? ImGui::TextUnformatted(text.c_str()) : ImGui::TextDisabled("%s", text.c_str());
}

}  // namespace

void draw_detectors_panel(const Area& area, const Snapshot& snapshot, ViewState& state) {
  const Panel panel("detectors", area, true);
  const float right = area.width - 8.0F;
  ImGui::TextUnformatted("Detectors");
  ImGui::SameLine(right - ImGui::CalcTextSize("score").x);
  ImGui::TextDisabled("score");
  if (state.settings.detectors.empty()) ImGui::TextDisabled("none");
  for (std::size_t i = 0; i < state.settings.detectors.size(); ++i) {
    ImGui::PushID(static_cast<int>(i));
    draw_row(i, right, snapshot, state);
    ImGui::PopID();
  }
}

}  // namespace saccade
