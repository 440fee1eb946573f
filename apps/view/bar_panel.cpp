#include <fmt/format.h>

#include "apps/view/key_bindings.h"
#include "apps/view/panel.h"
#include "apps/view/panels.h"

namespace saccade {
namespace {

const ImVec4 amber = {0.95F, 0.75F, 0.25F, 1.0F};
const ImVec4 green = {0.45F, 0.85F, 0.5F, 1.0F};

const char* word_of(GazePhase phase) {
  switch (phase) {
    case GazePhase::searching:
      return "searching";
    case GazePhase::following:
      return "following";
    case GazePhase::holding:
      return "holding";
    case GazePhase::resting:
      return "resting";
    case GazePhase::none:
      break;
  }
  return "";
}

std::string speed_text(int exponent) {
  if (exponent > SpeedRange::fastest) return "max";
  return exponent < 0 ? fmt::format("1/{} x", 1 << -exponent) : fmt::format("{} x", 1 << exponent);
}

/// A button for an action; its tooltip is `meaning` and the action's key.
void button(ViewState& state, const char* text, const std::string& meaning, const Action& action,
            float width = 0.0F) {
  if (ImGui::Button(text, {width, 26.0F})) state.actions.push_back(action);
  if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s (%s)", meaning.c_str(), key_name(action).c_str());
  ImGui::SameLine();
}

void playback_controls(const Snapshot& snapshot, ViewState& state) {
  using enum Action::Type;
  button(state, snapshot.playing ? "Pause" : "Play", "Play or pause", {toggle_playing}, 62.0F);
  button(state, "|<", "To the start", {seek_start});
  button(state, "-10", "10 ms back", {step, -10'000});
  button(state, "-1", "1 ms back", {step, -1'000});
  button(state, "+1", "1 ms forward", {step, 1'000});
  button(state, "+10", "10 ms forward", {step, 10'000});
  ImGui::SetNextItemWidth(120.0F);
  int exponent = state.speed_exponent;
  ImGui::SetCursorPosY(ImGui::GetCursorPosY() + 2.0F);
  if (ImGui::SliderInt("##speed", &exponent, SpeedRange::slowest, SpeedRange::unlimited, "",
                       ImGuiSliderFlags_NoInput))
    state.act(set_speed, exponent);
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip("Playback speed (%s and %s)", key_name({change_speed, 1}).c_str(),
                      key_name({change_speed, -1}).c_str());
  ImGui::SameLine();
  ImGui::AlignTextToFramePadding();
  ImGui::Text("%s", speed_text(state.speed_exponent).c_str());
  ImGui::SameLine(410.0F);
  ImGui::SetCursorPosY(ImGui::GetCursorPosY() - 2.0F);
}

}  // namespace

void draw_bar_panel(const Area& area, const Snapshot& snapshot, ViewState& state) {
  using enum Action::Type;
  const Panel panel("bar", area);
  if (state.with_playback) playback_controls(snapshot, state);
  ImGui::AlignTextToFramePadding();
  ImGui::Text("%s", state.name.c_str());
  ImGui::SameLine(0.0F, 16.0F);
  ImGui::Text("%.3f s", snapshot.since_start_s(snapshot.now_us));
  ImGui::SameLine();
  ImGui::TextDisabled("of %.3f s", snapshot.since_start_s(snapshot.end_us));
  if (snapshot.seeking) {
    ImGui::SameLine(0.0F, 16.0F);
    ImGui::TextColored(amber, "seeking ...");
  } else if (snapshot.playing) {
    ImGui::SameLine(0.0F, 16.0F);
    ImGui::TextDisabled("%.2f x real time", snapshot.speed);
  }
  if (const std::string phase = word_of(snapshot.phase); !phase.empty()) {
    ImGui::SameLine(0.0F, 16.0F);
    ImGui::TextColored(snapshot.phase == GazePhase::following ? green : amber, "%s", phase.c_str());
  }
  ImGui::SameLine(area.width - (state.can_save ? 274.0F : 224.0F));
  if (state.can_save) button(state, "Save", "Save the settings as YAML", {save_settings});
  button(state, "Screenshot", "Write a PNG file", {take_screenshot});
  const bool filming = state.filming;
  if (filming) ImGui::PushStyleColor(ImGuiCol_Button, {0.65F, 0.15F, 0.12F, 1.0F});
  button(state, filming ? "Stop video" : "Video", "Write an MP4 file", {toggle_video}, 80.0F);
  if (filming) ImGui::PopStyleColor();
  button(state, "Keys", "List of keys", {toggle_help});
}

}  // namespace saccade
