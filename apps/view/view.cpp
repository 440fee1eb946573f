#include "apps/view/view.h"

#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <functional>
#include <future>
#include <thread>
#include <utility>

#include "apps/view/action_handler.h"
#include "apps/view/capture.h"
#include "apps/view/key_bindings.h"
#include "apps/view/panel.h"
#include "apps/view/panels.h"
#include "apps/view/scene_panel.h"
#include "apps/view/settings_panel.h"
#include "session/interrupt.h"

namespace saccade {
namespace {

constexpr int first_width = 1280;
constexpr int first_height = 720;
// At least so long between two drawings, s:
constexpr double window_period_s = 1.0 / 60.0;
constexpr double still_period_s = 0.05;  ///< while nothing changes
constexpr double scene_period_s = 1.0 / 15.0;
constexpr double window_beside_run_s = 1.0 / 12.0;
constexpr double scene_beside_run_s = 1.0 / 4.0;

double median_ms(std::vector<double> values_s) {
  if (values_s.empty()) return 0.0;
  std::ranges::nth_element(values_s, values_s.begin() + static_cast<std::ptrdiff_t>(values_s.size() / 2));
  return 1e3 * values_s[values_s.size() / 2];
}

/// Closes a feed when the run ends, however it ends.
class FeedCloser {
 public:
  explicit FeedCloser(RunFeed& feed) : feed_(feed) {}
  ~FeedCloser() { feed_.close(); }
  FeedCloser(const FeedCloser&) = delete;
  FeedCloser& operator=(const FeedCloser&) = delete;

 private:
  RunFeed& feed_;
};

}  // namespace

struct View::Parts {
  Parts(const std::string& name, std::filesystem::path pictures, DetectorRegistry detectors)
      : window("saccade view: " + name, first_width, first_height),
        scene(window),
        eye(window),
        hough(window),
        settings(std::move(detectors)),
        plots(window),
        timeline(window),
        capture(name, std::move(pictures)) {
    state.name = name;
  }

  /// Draws the window. `wait_s`: for how long to wait for keyboard and mouse before.
  void draw(double wait_s, double min_scene_period_s);
  /// Draws the window as long as there is no snapshot.
  void draw_waiting(double wait_s);
  void take_keys();
  void apply_actions();
  void set_snapshot_taken() {
    has_snapshot = true;
    scene.invalidate();
  }
  void finish();

  Window window;
  ScenePanel scene;
  EyePanel eye;
  HoughPanel hough;
  SettingsPanel settings;
  PlotsPanel plots;
  TimelinePanel timeline;
  Capture capture;
  ViewState state;
  Snapshot snapshot;
  std::function<std::string(const ViewSettings&)> yaml_of;  ///< View::set_save()
  std::string yaml_suffix;
  bool has_snapshot = false;
  PlayerThread* player = nullptr;  ///< null beside a run
  WallClock::time_point begin = WallClock::now();
  std::vector<double> drawing_s;  ///< processor time of each drawing, without the scene
};

void View::Parts::take_keys() {
  for (const Window::Key& key : window.keys()) {
    if (const auto action = action_of_key(key.code, key.shift, key.repeated, state.with_playback))
      state.actions.push_back(*action);
  }
}

void View::Parts::apply_actions() {
  for (const Action& action : std::exchange(state.actions, {})) {
    if (apply_action(action, snapshot, state, player)) continue;
    if (action.type == Action::Type::close) window.close();
    if (action.type == Action::Type::take_screenshot)
      capture.request_screenshot(player != nullptr ? player->last_request() : 0);
    if (action.type == Action::Type::save_settings && yaml_of && has_snapshot)
      capture.save_yaml(yaml_suffix, yaml_of(state.settings));
    if (action.type == Action::Type::toggle_video && has_snapshot)
      capture.toggle_video({window.width(), window.height()});
  }
}

void View::Parts::draw_waiting(double wait_s) {
  window.begin(wait_s);
  take_keys();
  apply_actions();
  const std::string text = "Loading " + state.name + " ...";
  const ImVec2 size = ImGui::CalcTextSize(text.c_str());
  ImGui::GetBackgroundDrawList()->AddText({0.5F * (static_cast<float>(window.width()) - size.x),
                                           0.5F * (static_cast<float>(window.height()) - size.y)},
                                          ImGui::GetColorU32(ImGuiCol_Text), text.c_str());
  draw_help(window.width(), window.height(), state);
  draw_question(window.width(), window.height(), state);
  window.end(nullptr);
}

void View::Parts::draw(double wait_s, double min_scene_period_s) {
  window.begin(wait_s);
  const double start_s = processor_s();
  const std::size_t scenes = scene.drawing_s().size();
  const ViewLayout layout(window.width(), window.height());
  take_keys();
  apply_actions();
  state.filming = capture.filming();
  state.message = capture.message();
  draw_gaps(layout, window.width(), window.height());
  draw_bar_panel(layout.bar, snapshot, state);
  scene.draw(layout.scene, snapshot, state, min_scene_period_s);
  eye.draw(layout.eye, snapshot, state);
  hough.draw(layout.hough, snapshot);
  draw_detectors_panel(layout.detectors, snapshot, state);
  settings.draw(layout.settings, snapshot, state);
  plots.draw(layout.plots, snapshot);
  timeline.draw(layout, snapshot, state);
  draw_help(window.width(), window.height(), state);
  draw_question(window.width(), window.height(), state);
  apply_actions();

  cv::Mat shown;
  const bool grab = capture.needs_image(snapshot, !scene.stale());
  window.end(grab ? &shown : nullptr);
  if (grab) capture.add(shown, snapshot, !scene.stale());
  drawing_s.push_back(processor_s() - start_s);
  if (scene.drawing_s().size() > scenes) drawing_s.back() -= scene.drawing_s().back();
}

void View::Parts::finish() {
  capture.finish();
  window.hide();
  if (drawing_s.empty()) return;
  const double whole_s = seconds_between(begin, WallClock::now());
  fmt::print(
      "drew the window {} times in {:.1f} s ({:.1f} Hz), median processor time {:.1f} ms; the scene {:.1f} "
      "ms\n",
      drawing_s.size(), whole_s, static_cast<double>(drawing_s.size()) / whole_s, median_ms(drawing_s),
      median_ms(scene.drawing_s()));
}

View::View(std::string name, std::filesystem::path pictures, DetectorRegistry detectors)
    : parts_(std::make_unique<Parts>(std::move(name), std::move(pictures), std::move(detectors))) {}
View::~View() = default;

void View::set_save(std::function<std::string(const ViewSettings&)> yaml, std::string suffix) {
  parts_->yaml_of = std::move(yaml);
  parts_->yaml_suffix = std::move(suffix);
  parts_->state.can_save = true;
}

void View::show(PlayerThread& player) {
  Parts& parts = *parts_;
  parts.player = &player;
  parts.state.with_playback = true;
  bool ready = false;
  WallClock::time_point next = WallClock::now();
  WallClock::time_point active = WallClock::now();
  while (!parts.window.closed() && !interrupted()) {
    if (!ready && player.ready()) {
      ready = true;
      parts.state.settings = player.settings();
      parts.state.event_counts = player.event_counts();
      parts.begin = WallClock::now();
    }
    const bool taken = player.take(parts.snapshot);
    if (taken) parts.set_snapshot_taken();
    if (auto kept = player.take_kept_settings()) parts.state.settings = std::move(*kept);
    if (!parts.has_snapshot) {
      parts.draw_waiting(ready ? 0.002 : still_period_s);
      continue;
    }
    const WallClock::time_point now = WallClock::now();
    const ImGuiIO& io = ImGui::GetIO();
    if (taken || io.MouseDelta.x != 0.0F || io.MouseDelta.y != 0.0F || ImGui::IsAnyItemActive()) active = now;
    const bool still = seconds_between(active, now) >= 0.3 && !parts.capture.filming();
    const double period_s = still ? still_period_s : window_period_s;
    parts.draw(std::max(0.0, seconds_between(now, next)), scene_period_s);
    next = std::max(
        next + std::chrono::duration_cast<WallClock::duration>(std::chrono::duration<double>(period_s)),
        WallClock::now());
  }
  parts.finish();
  parts.player = nullptr;
}

int View::show_run(const Scenario& scenario, const std::function<int(RunFeed&)>& run) {
  RunFeed feed(scenario);
  std::future<int> result = std::async(std::launch::async, [&] {
    const FeedCloser closer(feed);
    return run(feed);
  });
  {
    Parts& parts = *parts_;
    parts.state.settings = view_settings(scenario.detectors, scenario.gaze.detector);
    parts.begin = WallClock::now();
    WallClock::time_point speed_since = parts.begin;
    std::int64_t speed_since_us = 0;
    double speed = 0.0;
    while (!parts.window.closed() && !feed.closed()) {
      const WallClock::time_point start = WallClock::now();
      if (feed.channel().take(parts.snapshot)) parts.set_snapshot_taken();
      if (const double span_s = seconds_between(speed_since, start); span_s > 0.5) {
        speed = static_cast<double>(parts.snapshot.now_us - speed_since_us) * 1e-6 / span_s;
        speed_since = start;
        speed_since_us = parts.snapshot.now_us;
      }
      parts.snapshot.speed = speed;
      if (parts.has_snapshot) {
        parts.draw(0.0, scene_beside_run_s);
      } else {
        parts.draw_waiting(0.0);
      }
      const double used_s = seconds_between(start, WallClock::now());
      std::this_thread::sleep_for(
          std::chrono::duration<double>(std::max(window_beside_run_s - used_s, 2.0 * used_s)));
    }
    feed.channel().stop();
    parts.finish();
    parts_.reset();
  }
  return result.get();
}

}  // namespace saccade
