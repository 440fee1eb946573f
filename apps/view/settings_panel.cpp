#include "apps/view/settings_panel.h"

#include <algorithm>
#include <utility>

#include "apps/view/own_detector.h"
#include "apps/view/panel.h"
#include "core/error.h"

namespace saccade {
namespace {

void draw_display_settings(const Snapshot& snapshot, ViewState& state) {
  ImGui::TextUnformatted("Display");
  ImGui::Separator();
  const auto label = [](const char* text) {
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(text);
    ImGui::SameLine(124.0F);
    ImGui::SetNextItemWidth(-1.0F);
  };
  label("events");
  ImGui::SliderInt("##fade", &state.fade_ms, 1, static_cast<int>(Snapshot::events_us / 1000), "%d ms",
                   ImGuiSliderFlags_Logarithmic);
  if (!snapshot.grey.empty()) {
    label("camera image");
    ImGui::Checkbox("##image", &state.with_image);
  }
  label("circles");
  ImGui::Checkbox("##circles", &state.with_circles);
}

/// The list of detectors and presets to select from.
void draw_detector_choice(const DetectorRegistry& detectors, ViewState& state) {
  ViewSettings& settings = state.settings;
  ImGui::SetNextItemWidth(-1.0F);
  if (!ImGui::BeginCombo("##detector", settings.selected_name().c_str(), ImGuiComboFlags_HeightLarge)) return;
  for (std::size_t i = 0; i < settings.detectors.size(); ++i) {
    if (ImGui::Selectable(settings.detectors[i].name.c_str(), i == settings.selected))
      state.act(Action::Type::select_detector, static_cast<std::int64_t>(i));
  }
  ImGui::Separator();
  for (const DetectorRow& row : detectors.rows()) {
    const std::string& preset = row.name;
    if (!row.selecting_key.empty()) continue;  // draw_own_detector() adds these
    if (std::ranges::find(settings.detectors, preset, &ViewDetector::name) != settings.detectors.end())
      continue;
    if (!ImGui::Selectable(("add " + preset).c_str())) continue;
    settings.detectors.push_back({preset, detectors.config(preset), true});
    state.act(Action::Type::select_detector, static_cast<std::int64_t>(settings.detectors.size()) - 1);
  }
  ImGui::EndCombo();
}

}  // namespace

void SettingsPanel::draw(const Area& area, const Snapshot& snapshot, ViewState& state) {
  const Panel panel("settings", area, true);
  if (!state.with_playback) {
    ImGui::TextWrapped("The window shows a run. Closing it does not stop the run.");
    ImGui::Dummy({0.0F, 6.0F});
    draw_display_settings(snapshot, state);
    return;
  }
  draw_configuration(snapshot, state);
  ImGui::Dummy({0.0F, 4.0F});
  draw_display_settings(snapshot, state);
}

void SettingsPanel::draw_configuration(const Snapshot& snapshot, ViewState& state) {
  ViewSettings& settings = state.settings;
  ImGui::TextUnformatted(settings.gate ? "Detector that drives the gaze" : "Selected detector");
  ImGui::Separator();
  draw_detector_choice(detectors_, state);
  draw_own_detector(state);
  if (!snapshot.problem.empty()) draw_problem("Rejected: " + snapshot.problem);
  if (const DetectorOutput* output = snapshot.selected_output();
      output != nullptr && !output->failure.empty())
    draw_problem("Ended: " + output->failure);
  bool changed = false;
  ImGui::PushStyleVar(ImGuiStyleVar_IndentSpacing, 8.0F);
  if (ViewDetector* selected = settings.selected_detector())
    changed = editor_.edit(selected->name, selected->config, {"preset"}) || changed;
  if (settings.controller) {
    ImGui::Dummy({0.0F, 4.0F});
    ImGui::TextUnformatted("Gaze");
    ImGui::Separator();
    changed = editor_.edit("controller", *settings.controller, {"limits", "script"}) || changed;
    if (settings.gate) changed = editor_.edit("gate", *settings.gate) || changed;
  }
  ImGui::PopStyleVar();
  if (changed) state.act(Action::Type::apply_settings);
}

void SettingsPanel::draw_own_detector(ViewState& state) {
  ViewSettings& settings = state.settings;
  // A detector that could not be made has left the list: its text is there again, to be corrected.
  if (!tried_name_.empty() &&
      std::ranges::find(settings.detectors, tried_name_, &ViewDetector::name) == settings.detectors.end()) {
    if (own_[0] == '\0') own_ = tried_;
    tried_name_.clear();
  }
  ImGui::SetNextItemWidth(-1.0F);
  const bool entered =
      ImGui::InputTextWithHint("##own", "add FILE.py:CLASS or a program", own_.data(), own_.size(),
                               ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll);
  if (ImGui::IsItemHovered())
    ImGui::SetTooltip("%s", "A detector of your own (docs/external_detectors.md); Enter adds it");
  if (entered && own_[0] != '\0') {
    try {
      settings.detectors.push_back(own_detector(detectors_, own_.data(), settings.detectors));
      state.act(Action::Type::select_detector, static_cast<std::int64_t>(settings.detectors.size()) - 1);
      tried_name_ = settings.detectors.back().name;
      tried_ = std::exchange(own_, {});
      own_problem_.clear();
    } catch (const InputError& error) {
      own_problem_ = error.what();
    }
  }
  if (!own_problem_.empty()) draw_problem(own_problem_);
}

}  // namespace saccade
