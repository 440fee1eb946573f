#include <imgui.h>

#include "apps/view/key_bindings.h"
#include "apps/view/panels.h"

namespace saccade {

void draw_help(int width, int height, ViewState& state) {
  if (!state.help) return;
  ImGui::SetNextWindowPos({0.5F * static_cast<float>(width), 0.45F * static_cast<float>(height)}, 0,
                          {0.5F, 0.5F});
  ImGui::Begin("Keys", &state.help,
               ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoNav);
  for (const KeyBinding& binding : key_bindings()) {
    if (!binding.holds(state.with_playback)) continue;
    ImGui::TextColored({0.5F, 0.74F, 0.95F, 1.0F}, "%s", binding.keys.c_str());
    ImGui::SameLine(110.0F);
    ImGui::TextUnformatted(binding.meaning.c_str());
  }
  ImGui::Separator();
  ImGui::TextUnformatted("Drag in the scene to turn it; the wheel changes the distance.");
  ImGui::TextUnformatted("In the eye's image the wheel enlarges, dragging moves, a double click shows all.");
  ImGui::TextUnformatted("Ctrl-click on a slider to type a number.");
  ImGui::End();
}

void draw_question(int width, int height, ViewState& state) {
  if (!state.asks_to_close) return;
  ImGui::SetNextWindowPos({0.5F * static_cast<float>(width), 0.45F * static_cast<float>(height)}, 0,
                          {0.5F, 0.5F});
  ImGui::SetNextWindowFocus();
  ImGui::Begin("Close the window?", nullptr,
               ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoNav);
  ImGui::TextUnformatted(state.with_playback
                             ? "Settings that were changed are kept only if you saved them (W)."
                             : "The run continues without its window.");
  ImGui::Dummy({0.0F, 4.0F});
  if (ImGui::Button("Close (Enter)", {130.0F, 28.0F})) state.act(Action::Type::close);
  ImGui::SameLine();
  if (ImGui::Button("Stay (Esc)", {130.0F, 28.0F})) state.asks_to_close = false;
  ImGui::End();
}

}  // namespace saccade
