#include "apps/view/label_window.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "apps/view/capture.h"
#include "apps/view/colours.h"
#include "apps/view/label_editor.h"
#include "apps/view/label_layout.h"
#include "apps/view/panel.h"
#include "apps/view/wall_clock.h"
#include "core/error.h"
#include "session/interrupt.h"

namespace saccade {
namespace {

constexpr double wait_s = 0.05;  ///< for keyboard and mouse between two drawings
constexpr double playing_wait_s = 1.0 / 60.0;
constexpr double radius_step_px = 0.5;
constexpr double fine = 0.2;          ///< share of a step with Shift
constexpr float drag_from_px = 3.0F;  ///< in the window; a press that moves less is a click

/// All events of the eye that is labelled, and the image's size: the file's, else the smallest that contains them.
LabelEditor open_editor(const LabelSettings& settings) {
  const ReplaySource source = open_replay_source(settings.input, {});
  const auto reader = open_event_file(source.formats, source.events, source.read);
  std::vector<Event> events;
  while (reader->read(events, 1 << 16) > 0) {
  }
  if (events.empty())
    throw InputError(settings.input.recording.string(), "no events of the chosen eye",
                     "a recording with events; saccade info lists what it holds");
  ImageSize size{1, 1};
  for (const Event& event : events)
    size = {std::max(size.width, event.x + 1), std::max(size.height, event.y + 1)};
  CircleLabels labels;
  if (std::filesystem::exists(settings.out)) labels = CircleLabels::read(settings.out);
  return {std::move(events), reader->image_size().value_or(size), std::move(labels)};
}

class LabelWindow {
 public:
  LabelWindow(const LabelSettings& settings, const std::string& name)
      : settings_(settings),
        editor_(open_editor(settings)),
        window_("saccade label: " + name, 1280, 720),
        texture_(window_, false),
        strip_(window_, true),
        capture_(name, settings.pictures),
        keys_(make_keys()) {
    if (!editor_.labels().rows().empty()) editor_.seek(editor_.labels().rows().front().t_us);
  }

  void run() {
    while (!finished_ && !interrupted()) {
      draw();
      if (!window_.closed()) continue;
      window_.keep_open();
      ask_or_close(false);
    }
    if (interrupted() && editor_.unsaved()) save();
    window_.hide();
    fmt::print("{}: {}\n", settings_.out.string(), labelled_instants());
    if (editor_.unsaved()) fmt::print("the last changes were not saved\n");
  }

 private:
  [[nodiscard]] std::string labelled_instants() const {
    const std::size_t count = editor_.labels().rows().size();
    return fmt::format("{} {}", count, count == 1 ? "instant" : "instants");
  }

  struct KeyRow {
    std::string keys;
    std::string meaning;
    bool repeats = false;
    /// Codes of GLFW, and what each does; the argument says whether Shift is held.
    std::vector<std::pair<int, std::function<void(bool)>>> actions;
  };

  std::vector<KeyRow> make_keys() {
    const auto step = [this](int direction) {
      return [this, direction](bool shift) {
        const double step_us = 1e3 * settings_.step_ms * (shift ? 10.0 : 1.0);
        editor_.seek(editor_.now_us() + direction * std::llround(step_us));
      };
    };
    const auto move = [this](double x, double y) {
      return [this, x, y](bool shift) {
        const double px = radius_step_px * (shift ? fine : 1.0);
        editor_.move(x * px, y * px);
      };
    };
    const auto grow = [this](double sign) {
      return [this, sign](bool shift) { editor_.grow(sign * radius_step_px * (shift ? fine : 1.0)); };
    };
    return {
        {"\u2190 \u2192",
         fmt::format("{} ms back, forward; with Shift {} ms", settings_.step_ms, 10.0 * settings_.step_ms),
         true,
         {{GLFW_KEY_LEFT, step(-1)}, {GLFW_KEY_RIGHT, step(1)}}},
        {"Space", "play, pause", false, {{GLFW_KEY_SPACE, [this](bool) { editor_.toggle_playing(); }}}},
        {", .",
         "slower, faster: 1/20 to 2 x",
         false,
         {{GLFW_KEY_COMMA, [this](bool) { editor_.change_speed(-1); }},
          {GLFW_KEY_PERIOD, [this](bool) { editor_.change_speed(1); }}}},
        {"Page \u2191 \u2193",
         "previous, next label",
         true,
         {{GLFW_KEY_PAGE_UP, [this](bool) { editor_.seek_previous_label(); }},
          {GLFW_KEY_PAGE_DOWN, [this](bool) { editor_.seek_next_label(); }}}},
        {"Home, End",
         "first, last event",
         false,
         {{GLFW_KEY_HOME, [this](bool) { editor_.seek(editor_.first_us()); }},
          {GLFW_KEY_END, [this](bool) { editor_.seek(editor_.last_us()); }}}},
        {"\u2191 \u2193",
         "events of twice, half the time",
         true,
         {{GLFW_KEY_UP, [this](bool) { editor_.scale_reach(2.0); }},
          {GLFW_KEY_DOWN, [this](bool) { editor_.scale_reach(0.5); }}}},
        {"Enter",
         "the hint becomes a label",
         false,
         {{GLFW_KEY_ENTER, [this](bool) { editor_.accept_hint(); }}}},
        {"F",
         "fit the circle to the edges near it",
         false,
         {{GLFW_KEY_F,
           [this](bool) {
             const bool any = editor_.circle().has_value();
             if (!editor_.snap())
               message_ = any ? "not fitted: too few edges near the circle" : "no circle to fit";
           }}}},
        {"[ ]",
         "radius 0.5 px down, up; with Shift 0.1 px",
         true,
         {{GLFW_KEY_LEFT_BRACKET, grow(-1.0)}, {GLFW_KEY_RIGHT_BRACKET, grow(1.0)}}},
        {"J L I K",
         "centre 0.5 px left, right, up, down; Shift 0.1 px",
         true,
         {{GLFW_KEY_J, move(-1, 0)},
          {GLFW_KEY_L, move(1, 0)},
          {GLFW_KEY_I, move(0, -1)},
          {GLFW_KEY_K, move(0, 1)}}},
        {"X",
         "the ball is hidden here, or not",
         false,
         {{GLFW_KEY_X, [this](bool) { editor_.toggle_hidden(); }}}},
        {"Delete", "remove the label", false, {{GLFW_KEY_DELETE, [this](bool) { editor_.remove(); }}}},
        {"U", "undo", true, {{GLFW_KEY_U, [this](bool) { editor_.undo(); }}}},
        {"W", "save", false, {{GLFW_KEY_W, [this](bool) { save(); }}}},
        {"S", "screenshot (PNG)", false, {{GLFW_KEY_S, [this](bool) { capture_.request_screenshot(0); }}}},
        {"Q, Esc",
         "quit; asks first",
         false,
         {{GLFW_KEY_Q, [this](bool) { ask_or_close(false); }},
          {GLFW_KEY_ESCAPE, [this](bool) { ask_or_close(true); }}}},
    };
  }

  /// Q closes at once where all is saved, Esc never does.
  void ask_or_close(bool always_ask) {
    asks_ = always_ask || editor_.unsaved();
    finished_ = !asks_;
  }

  void save() {
    try {
      editor_.labels().write(settings_.out);
      editor_.mark_saved();
      message_ = "saved: " + settings_.out.string();
    } catch (const RunError& error) {
      message_ = error.what();
    }
  }

  void save_and_close() {
    if (editor_.unsaved()) save();
    finished_ = !editor_.unsaved();
    asks_ = false;
  }

  void take_keys() {
    for (const Window::Key& key : window_.keys()) {
      if (asks_) {
        if (key.code == GLFW_KEY_ENTER) save_and_close();
        if (key.code == GLFW_KEY_D) finished_ = true;
        if (key.code == GLFW_KEY_S) capture_.request_screenshot(0);
        if (key.code == GLFW_KEY_ESCAPE) asks_ = false;
        continue;
      }
      for (const KeyRow& row : keys_) {
        for (const auto& [code, action] : row.actions) {
          if (code == key.code && (row.repeats || !key.repeated)) {
            message_.clear();
            action(key.shift);
          }
        }
      }
    }
  }

  void draw() {
    window_.begin(editor_.playing() ? playing_wait_s : wait_s);
    const WallClock::time_point now = WallClock::now();
    if (!asks_) editor_.advance(seconds_between(drawn_, now));
    drawn_ = now;
    take_keys();
    const LabelLayout layout(window_.width(), window_.height());
    draw_bar(layout.bar);
    draw_image(layout.image);
    draw_list(layout.list);
    draw_keys(layout.keys);
    draw_timeline(layout);
    if (asks_) draw_question(layout);
    Snapshot snapshot;
    snapshot.start_us = editor_.first_us();
    snapshot.now_us = editor_.now_us();
    snapshot.end_us = editor_.last_us();
    cv::Mat shown;
    const bool grab = capture_.needs_image(snapshot, true);
    window_.end(grab ? &shown : nullptr);
    if (grab) capture_.add(shown, snapshot, true);
  }

  [[nodiscard]] std::string since_start(std::int64_t t_us) const {
    return fmt::format("{:.4f} s", static_cast<double>(t_us - editor_.first_us()) * 1e-6);
  }

  void draw_bar(const Area& area) {
    const Panel panel("bar", area);
    const std::optional<Circle> circle = editor_.circle();
    std::string text = since_start(editor_.now_us()) + "   t_us " + std::to_string(editor_.now_us()) + "   ";
    if (circle)
      text += fmt::format("x {:.2f}   y {:.2f}   r {:.2f} px   ", circle->x_px, circle->y_px, circle->r_px);
    const char* state = "no circle: click to place one";
    if (circle) state = editor_.labelled() ? "label" : "hint: Enter makes it a label, a click places one";
    if (editor_.hidden()) state = "ball hidden";
    ImGui::SetCursorPosY(10.0F);
    ImGui::TextUnformatted((text + state).c_str());
    const std::string screenshot = capture_.message();
    const std::string right = fmt::format("{}{}", labelled_instants(),
                                          !screenshot.empty() ? ", " + screenshot
                                          : !message_.empty() ? ", " + message_
                                          : editor_.unsaved() ? ", not saved"
                                                              : "");
    const float width = ImGui::CalcTextSize(right.c_str()).x;
    ImGui::GetWindowDrawList()->AddText({area.x + area.width - width - 10.0F, area.y + 10.0F}, colours::dim,
                                        right.c_str());
  }

  void draw_image(const Area& area) {
    paint_instant(editor_, rgb_);
    texture_.set(editor_.image_size(), rgb_);
    const Panel panel("image", area);
    draw_caption(area, fmt::format("Events of {} ms before and after, {} {} x",
                                   static_cast<double>(editor_.reach_us()) * 1e-3,
                                   editor_.playing() ? "playing" : "paused", editor_.speed_text()));
    Legend legend(area);
    legend.add("hint", colours::target, Legend::Mark::circle);
    legend.add("label", colours::truth, Legend::Mark::circle);
    legend.add("OFF", colours::off, Legend::Mark::square);
    legend.add("ON", colours::on, Legend::Mark::square);
    const Area at = zoom_.place(area, editor_.image_size());
    const Area frame = ViewLayout::below_caption(area);
    take_mouse(frame, at);
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    draw.PushClipRect({frame.x, frame.y}, {frame.x + frame.width, frame.y + frame.height}, true);
    draw_texture(texture_, at);
    if (const std::optional<Circle> circle = editor_.circle()) {
      const float scale = at.width / static_cast<float>(editor_.image_size().width);
      const ImVec2 centre(at.x + scale * static_cast<float>(circle->x_px + 0.5),
                          at.y + scale * static_cast<float>(circle->y_px + 0.5));
      const float radius = scale * static_cast<float>(circle->r_px);
      const ImU32 colour = editor_.labelled() ? colours::truth : colours::target;
      for (const auto& [c, width] : {std::pair{colours::rim, 4.0F}, {colour, 1.6F}}) {
        draw.AddCircle(centre, radius, c, 96, width);
        draw.AddLine({centre.x - 5, centre.y}, {centre.x + 5, centre.y}, c, width);
        draw.AddLine({centre.x, centre.y - 5}, {centre.x, centre.y + 5}, c, width);
      }
    }
    draw.PopClipRect();
  }

  void take_mouse(const Area& frame, const Area& at) {
    ImGui::SetCursorScreenPos({frame.x, frame.y});
    ImGui::InvisibleButton("circle", {frame.width, frame.height},
                           ImGuiButtonFlags_MouseButtonLeft | ImGuiButtonFlags_MouseButtonRight);
    if (asks_) return;
    const ImGuiIO& io = ImGui::GetIO();
    const float scale = at.width / static_cast<float>(editor_.image_size().width);
    const double x_px = static_cast<double>((io.MousePos.x - at.x) / scale) - 0.5;
    const double y_px = static_cast<double>((io.MousePos.y - at.y) / scale) - 0.5;
    const bool left = ImGui::IsMouseDown(ImGuiMouseButton_Left);
    if (ImGui::IsItemActivated() && left) {
      message_.clear();
      editor_.press(x_px, y_px);
    } else if (ImGui::IsItemActive() && ImGui::IsMouseDragging(ImGuiMouseButton_Left, drag_from_px) &&
               (io.MouseDelta.x != 0.0F || io.MouseDelta.y != 0.0F)) {
      editor_.drag(x_px, y_px);
    } else if (ImGui::IsItemActive() && ImGui::IsMouseDown(ImGuiMouseButton_Right)) {
      zoom_.pan(io.MouseDelta.x, io.MouseDelta.y);
    }
    if (ImGui::IsItemDeactivated()) editor_.release();
    if (!ImGui::IsItemHovered() || io.MouseWheel == 0.0F) return;
    if (io.KeyCtrl) {
      zoom_.scale(std::pow(1.2F, io.MouseWheel), io.MousePos.x - frame.x, io.MousePos.y - frame.y);
    } else {
      editor_.grow(static_cast<double>(io.MouseWheel) * radius_step_px * (io.KeyShift ? fine : 1.0));
    }
  }

  void draw_list(const Area& area) {
    const Panel panel("labels", area, true);
    ImGui::TextDisabled("%s", "time, s       x        y        r, px");
    std::optional<std::int64_t> chosen_us;
    for (const TruthRow& row : editor_.labels().rows()) {
      const double t_s = static_cast<double>(row.t_us - editor_.first_us()) * 1e-6;
      const bool shows = row.visible > 0.0 && std::isfinite(row.circle.x_px);
      const std::string text = shows
                                   ? fmt::format("{:.4f}   {:.1f}   {:.1f}   {:.1f}##{}", t_s,
                                                 row.circle.x_px, row.circle.y_px, row.circle.r_px, row.t_us)
                                   : fmt::format("{:.4f}   hidden##{}", t_s, row.t_us);
      const bool here = row.t_us == editor_.now_us();
      if (ImGui::Selectable(text.c_str(), here)) chosen_us = row.t_us;
      if (here && listed_us_ != row.t_us) ImGui::SetScrollHereY();
      if (here) listed_us_ = row.t_us;
    }
    if (chosen_us) editor_.seek(*chosen_us);
  }

  void draw_keys(const Area& area) {
    const Panel panel("keys", area, true);
    const auto line = [](const std::string& keys, const std::string& meaning) {
      ImGui::TextColored({0.5F, 0.74F, 0.95F, 1.0F}, "%s", keys.c_str());
      ImGui::SameLine(88.0F);
      ImGui::PushTextWrapPos(0.0F);
      ImGui::TextUnformatted(meaning.c_str());
      ImGui::PopTextWrapPos();
    };
    line("click", "place the circle, also inside another");
    line("drag", "inside: centre; outline: radius");
    line("wheel", "radius 0.5 px; with Shift 0.1 px");
    line("Ctrl wheel", "zoom; drag with the right button");
    for (const KeyRow& row : keys_) line(row.keys, row.meaning);
  }

  void draw_timeline(const LabelLayout& layout) {
    const Panel panel("timeline", layout.timeline);
    const Area strip = layout.time_strip();
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const ImageSize size{static_cast<int>(strip.width), static_cast<int>(strip.height)};
    if (size != strip_size_) {
      paint_event_counts(editor_.event_counts(600), size, strip_rgb_);
      strip_.set(size, strip_rgb_);
      strip_size_ = size;
    }
    draw_texture(strip_, strip);
    const double span_us = std::max(1.0, static_cast<double>(editor_.last_us() - editor_.first_us()));
    const auto place = [&](std::int64_t t_us) {
      return strip.x +
             strip.width * static_cast<float>(static_cast<double>(t_us - editor_.first_us()) / span_us);
    };
    for (const TruthRow& row : editor_.labels().rows())
      draw.AddLine({place(row.t_us), strip.y}, {place(row.t_us), strip.y + strip.height},
                   row.visible > 0.0 ? colours::truth : colours::dim, 1.5F);
    ImGui::SetCursorScreenPos({strip.x, strip.y - 4.0F});
    ImGui::InvisibleButton("time", {strip.width, strip.height + 8.0F});
    const float share = std::clamp((ImGui::GetIO().MousePos.x - strip.x) / strip.width, 0.0F, 1.0F);
    const std::int64_t at_us = editor_.first_us() + std::llround(static_cast<double>(share) * span_us);
    const bool moved = ImGui::GetIO().MouseDelta.x != 0.0F || ImGui::IsItemActivated();
    if (ImGui::IsItemActive() && moved && !asks_) editor_.seek(at_us);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", since_start(at_us).c_str());
    const float now_x = place(editor_.now_us());
    draw.AddRectFilled({now_x - 1.0F, strip.y - 3.0F}, {now_x + 1.0F, strip.y + strip.height + 3.0F},
                       colours::white);
    const float text_y = strip.y + strip.height + 2.0F;
    draw.AddText({strip.x, text_y}, colours::dim, "0 s");
    const std::string end = since_start(editor_.last_us());
    draw.AddText({strip.x + strip.width - ImGui::CalcTextSize(end.c_str()).x, text_y}, colours::dim,
                 end.c_str());
  }

  void draw_question(const LabelLayout& layout) {
    ImGui::SetNextWindowPos(
        {layout.image.x + 0.5F * layout.image.width, layout.image.y + 0.4F * layout.image.height}, 0,
        {0.5F, 0.5F});
    ImGui::SetNextWindowFocus();
    ImGui::Begin("Close the window?", nullptr,
                 ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoNav);
    ImGui::TextUnformatted(editor_.unsaved() ? "Changes are not saved yet." : "Everything is saved.");
    ImGui::Dummy({0.0F, 4.0F});
    if (ImGui::Button(editor_.unsaved() ? "Save, close (Enter)" : "Close (Enter)", {150.0F, 28.0F}))
      save_and_close();
    ImGui::SameLine();
    if (editor_.unsaved() && ImGui::Button("Discard (D)", {110.0F, 28.0F})) finished_ = true;
    if (editor_.unsaved()) ImGui::SameLine();
    if (ImGui::Button("Stay (Esc)", {110.0F, 28.0F})) asks_ = false;
    ImGui::End();
  }

  const LabelSettings& settings_;
  LabelEditor editor_;
  Window window_;
  Window::Texture texture_;
  Window::Texture strip_;
  Capture capture_;
  std::vector<KeyRow> keys_;
  ImageZoom zoom_;
  RgbImage rgb_;
  RgbImage strip_rgb_;
  ImageSize strip_size_;
  std::string message_;
  WallClock::time_point drawn_ = WallClock::now();
  std::optional<std::int64_t> listed_us_;  ///< the row that the list has scrolled to
  bool asks_ = false;
  bool finished_ = false;
};

}  // namespace

void label_recording(const LabelSettings& settings) {
  std::filesystem::path name = std::filesystem::absolute(settings.input.recording).lexically_normal();
  if (!name.has_filename()) name = name.parent_path();
  LabelWindow(settings, name.stem()).run();
}

}  // namespace saccade
