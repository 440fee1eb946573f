#include "apps/view/field_editor.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>

#include "apps/view/panel.h"
#include "core/error.h"

namespace saccade {
namespace {

constexpr float label_width = 124.0F;

void explain(std::string_view doc) {
  if (!doc.empty() && ImGui::IsItemHovered()) ImGui::SetTooltip("%s", std::string(doc).c_str());
}

const char* format_of(double span) { return span > 200.0 ? "%.0f" : span > 20.0 ? "%.1f" : "%.3g"; }

}  // namespace

void FieldEditor::begin(const std::string& name, const std::set<std::string>& hidden) {
  path_ = name;
  hidden_ = hidden;
  changed_ = false;
  ImGui::PushID(name.c_str());
}

bool FieldEditor::end() {
  ImGui::PopID();
  return changed_;
}

bool FieldEditor::settled(std::string_view key, bool changed, std::vector<double>& wanted) {
  const std::string path = path_ + "." + std::string(key);
  if (ImGui::IsItemActive() && ImGui::GetIO().WantTextInput) {
    if (changed) {
      typed_path_ = path;
      typed_ = wanted;
    }
    return false;
  }
  if (typed_path_ != path || !ImGui::IsItemDeactivated()) return changed;
  typed_path_.clear();
  if (ImGui::IsKeyPressed(ImGuiKey_Escape)) return false;
  wanted = typed_;
  return true;
}

bool FieldEditor::accept(std::string_view key, bool edited, bool valid, const std::string& found,
                         const std::string& expected) {
  const std::string path = path_ + "." + std::string(key);
  if (edited) {
    rejected_path_ = valid ? std::string() : path;
    problem_ = Problem{std::string(key), found, expected}.text();
    changed_ = changed_ || valid;
  }
  if (path == rejected_path_) draw_problem(problem_);
  return edited && valid;
}

void FieldEditor::label(std::string_view key, std::string_view doc) {
  ImGui::AlignTextToFramePadding();
  ImGui::TextUnformatted(key.data(), key.data() + key.size());
  explain(doc);
  ImGui::SameLine(label_width);
  ImGui::SetNextItemWidth(-1.0F);
}

Range FieldEditor::sensible(std::string_view key, double value, Range range) {
  const double first = first_.emplace(path_ + "." + std::string(key), value).first->second;
  const double reach = first == 0.0 ? 1.0 : 4.0 * std::abs(first);
  return {std::max(range.min, first < 0.0 ? -reach : std::max(range.min, -reach)),
          std::max(value, range.max <= 2.5 * reach ? range.max : reach)};
}

void FieldEditor::real(std::string_view key, double& value, Range range, std::string_view doc) {
  if (is_hidden(key)) return;
  const std::string id = "##" + std::string(key);
  const Range slider = sensible(key, value, range);
  label(key, doc);
  std::vector<double> wanted = {value};
  const bool changed = ImGui::SliderScalar(id.c_str(), ImGuiDataType_Double, wanted.data(), &slider.min,
                                           &slider.max, format_of(slider.max - slider.min));
  const bool edited = settled(key, changed, wanted) && wanted.front() != value;
  explain(doc);
  if (accept(key, edited, range.contains(wanted.front()), text_of(wanted.front()),
             expectation_of(range, "a number")))
    value = wanted.front();
}

void FieldEditor::integer(std::string_view key, std::int64_t& value, Range range, std::string_view doc) {
  if (is_hidden(key)) return;
  const std::string id = "##" + std::string(key);
  const Range slider = sensible(key, static_cast<double>(value), range);
  const auto min = static_cast<std::int64_t>(slider.min);
  const auto max = static_cast<std::int64_t>(slider.max);
  label(key, doc);
  std::int64_t wanted = value;
  const bool changed = ImGui::SliderScalar(id.c_str(), ImGuiDataType_S64, &wanted, &min, &max);
  std::vector<double> number = {static_cast<double>(wanted)};
  const bool edited = settled(key, changed, number) && number.front() != static_cast<double>(value);
  explain(doc);
  if (accept(key, edited, range.contains(number.front()), text_of(number.front()),
             expectation_of(range, "a whole number")))
    value = static_cast<std::int64_t>(number.front());
}

void FieldEditor::boolean(std::string_view key, bool& value, std::string_view doc) {
  if (is_hidden(key)) return;
  label(key, doc);
  changed_ = ImGui::Checkbox(("##" + std::string(key)).c_str(), &value) || changed_;
  explain(doc);
}

void FieldEditor::choice(std::string_view key, std::string& value, const std::vector<std::string>& options,
                         std::string_view doc) {
  if (is_hidden(key)) return;
  label(key, doc);
  if (!ImGui::BeginCombo(("##" + std::string(key)).c_str(), value.c_str())) {
    explain(doc);
    return;
  }
  for (const std::string& option : options) {
    if (ImGui::Selectable(option.c_str(), option == value) && option != value) {
      value = option;
      changed_ = true;
    }
  }
  ImGui::EndCombo();
}

void FieldEditor::numbers(std::string_view key, std::span<double> values, Range range, std::string_view doc) {
  if (is_hidden(key) || values.empty()) return;
  label(key, doc);
  std::vector<double> wanted(values.begin(), values.end());
  const auto speed = static_cast<float>(0.02 * std::max(1.0, std::abs(values.back())));
  const bool moved =
      ImGui::DragScalarN(("##" + std::string(key)).c_str(), ImGuiDataType_Double, wanted.data(),
                         static_cast<int>(wanted.size()), speed, &range.min, &range.max, "%.0f");
  const bool edited = settled(key, moved, wanted);
  explain(doc);
  std::string found;
  for (double& number : wanted) {
    number = std::round(number);
    found += (found.empty() ? "[" : ", ") + text_of(number);
  }
  const bool in_range = std::ranges::all_of(wanted, [&](double number) { return range.contains(number); });
  if (accept(key, edited && !std::ranges::equal(wanted, values), in_range && std::ranges::is_sorted(wanted),
             found + "]", expectation_of(range, "numbers") + ", in ascending order"))
    std::ranges::copy(wanted, values.begin());
}

void FieldEditor::section(std::string_view key, const std::function<void(FieldVisitor&)>& describe_section,
                          std::string_view doc) {
  if (is_hidden(key)) return;
  const std::string name(key);
  const bool open = ImGui::TreeNodeEx(name.c_str(), key == "window" ? ImGuiTreeNodeFlags_DefaultOpen : 0);
  explain(doc);
  if (!open) return;
  const std::string outer = path_;
  path_ += "." + name;
  describe_section(*this);
  path_ = outer;
  ImGui::TreePop();
}

}  // namespace saccade
