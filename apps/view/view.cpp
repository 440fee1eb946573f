#include "apps/view/view.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <fmt/format.h>
#include <imgui.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <numbers>
#include <opencv2/imgcodecs.hpp>

#include "apps/session/interrupt.h"
#include "apps/view/field_editor.h"
#include "apps/view/layout.h"
#include "apps/view/pixels.h"
#include "apps/view/plot.h"
#include "apps/view/window.h"
#include "evaluation/report/figures.h"
#include "evaluation/report/overlay.h"
#include "evaluation/scoring/statistics.h"

namespace saccade {
namespace {

using WallClock = std::chrono::steady_clock;

constexpr int first_width = 1280;
constexpr int first_height = 720;
constexpr double picture_s = 1.0 / 60.0;     ///< of the window, at most so often
constexpr double scene_s = 1.0 / 15.0;       ///< of the scene while it moves
constexpr double beside_run_s = 1.0 / 12.0;  ///< of the window beside a run
constexpr double scene_beside_run_s = 1.0 / 4.0;
constexpr int video_hz = 25;
constexpr std::int64_t cloud_us = 60'000;

constexpr ImU32 white = IM_COL32(255, 255, 255, 255);
constexpr ImU32 dark = IM_COL32(0, 0, 0, 190);
constexpr ImU32 dim = IM_COL32(150, 150, 156, 255);
constexpr ImU32 target_colour = IM_COL32(0xe6, 0x9f, 0x00, 255);
constexpr ImU32 red = IM_COL32(240, 70, 60, 255);

double seconds(WallClock::time_point from, WallClock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}

/// Of this thread. Pictures are drawn in it alone, so that this is what they cost whatever else runs.
double processor_s() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

ImU32 colour_of(const Rgb& rgb) { return IM_COL32(rgb[0], rgb[1], rgb[2], 255); }

/// The report's colour of a detector, lighter, for a dark ground.
ImU32 detector_colour_on_dark(std::size_t index) {
  const std::string hex = detector_colour(index);
  const auto channel = [&](std::size_t at) {
    const int value = std::stoi(hex.substr(at, 2), nullptr, 16);
    return value + (255 - value) * 3 / 10;
  };
  return IM_COL32(channel(1), channel(3), channel(5), 255);
}

std::string phase_in_words(GazePhase phase) {
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

double* threshold_of(DetectorConfig& config) {
  return std::visit([](auto& detector) { return &detector.threshold; }, config.detector);
}

/// An ImGui window without anything of its own, at a place.
class Panel {
 public:
  Panel(const char* name, const Area& area, bool scrolls = false) {
    ImGui::SetNextWindowPos({area.x, area.y});
    ImGui::SetNextWindowSize({area.width, area.height});
    ImGui::Begin(name, nullptr,
                 ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                     ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoBringToFrontOnFocus |
                     ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoBackground |
                     (scrolls ? 0 : ImGuiWindowFlags_NoScrollbar | ImGuiWindowFlags_NoScrollWithMouse));
  }
  ~Panel() { ImGui::End(); }
  Panel(const Panel&) = delete;
  Panel& operator=(const Panel&) = delete;
};

/// What is between the panels. Their ground is that of the window: each pixel that is drawn twice costs a software
/// renderer as much as one of a picture.
void draw_gaps(const ViewLayout& layout, int width, int height) {
  ImDrawList& draw = *ImGui::GetBackgroundDrawList();
  const auto w = static_cast<float>(width);
  const auto h = static_cast<float>(height);
  const auto fill = [&](float left, float top, float right, float bottom) {
    draw.AddRectFilled({left, top}, {right, bottom}, IM_COL32(17, 17, 19, 255));
  };
  const auto below = [](const Area& area) { return area.y + area.height; };
  const auto beside = [](const Area& area) { return area.x + area.width; };
  fill(0, 0, w, layout.bar.y);
  fill(0, below(layout.bar), w, layout.scene.y);
  fill(0, below(layout.scene), layout.settings.x, layout.plots.y);
  fill(0, below(layout.plots), w, layout.timeline.y);
  fill(0, below(layout.timeline), w, h);
  fill(0, layout.bar.y, layout.bar.x, below(layout.timeline));
  fill(beside(layout.bar), layout.bar.y, w, below(layout.timeline));
  fill(beside(layout.scene), layout.scene.y, layout.eye.x, below(layout.scene));
  fill(beside(layout.eye), layout.eye.y, layout.hough.x, below(layout.eye));
  fill(beside(layout.hough), layout.hough.y, layout.settings.x, below(layout.settings));
  fill(layout.hough.x, below(layout.hough), beside(layout.hough), layout.detectors.y);
}

void caption(const Area& area, const std::string& text) {
  ImGui::GetWindowDrawList()->AddText({area.x + 8.0F, area.y + 4.0F}, ImGui::GetColorU32(ImGuiCol_Text),
                                      text.c_str());
}

/// Words at the right end of a caption, each in its colour, with a mark before it.
class Legend {
 public:
  explicit Legend(const Area& area) : x_(area.x + area.width - 8.0F), y_(area.y + 4.0F) {}
  void add(const char* word, ImU32 colour, char mark) {
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    x_ -= ImGui::CalcTextSize(word).x;
    draw.AddText({x_, y_}, dim, word);
    x_ -= 10.0F;
    const ImVec2 at(x_, y_ + 8.0F);
    if (mark == 'o') draw.AddCircle(at, 4.0F, colour, 12, 1.6F);
    if (mark == 'x')
      draw.AddQuad({at.x - 5, at.y}, {at.x, at.y - 5}, {at.x + 5, at.y}, {at.x, at.y + 5}, colour, 1.6F);
    if (mark == '.') draw.AddRectFilled({at.x - 4, at.y - 4}, {at.x + 4, at.y + 4}, colour);
    x_ -= 14.0F;
  }

 private:
  float x_, y_;
};

void add_picture(const Window::Texture& texture, const Area& at) {
  ImGui::GetWindowDrawList()->AddImage(texture.id(), {at.x, at.y}, {at.x + at.width, at.y + at.height});
}

}  // namespace

struct View::Parts {
  Parts(std::string its_name, std::filesystem::path its_pictures)
      : name(std::move(its_name)),
        pictures(std::move(its_pictures)),
        window("saccade view: " + name, first_width, first_height),
        eye_texture(window, false),
        hough_texture(window, false),
        scene_texture(window, true),
        plots_texture(window, false),
        overview_texture(window, false) {}

  std::string name;
  std::filesystem::path pictures;
  Window window;
  Window::Texture eye_texture, hough_texture, scene_texture, plots_texture, overview_texture;
  ImageSize overview_size;
  std::unique_ptr<SceneRenderer> scene;
  std::vector<std::uint8_t> scene_rgb;
  RgbImage rgb;
  Picture picture;
  bool has_picture = false;

  // What a person set.
  Player* player = nullptr;  // none: a run that goes its own way
  ViewSettings settings;
  FieldEditor editor;
  int speed_exponent = 0;  // of 2; above fastest_exponent as fast as it goes
  int fade_ms = 40;
  bool with_image = true;
  bool with_circles = true;
  SceneView scene_view = profile_view();
  bool help = false;

  // What is done beside showing.
  bool scene_stale = true;
  WallClock::time_point scene_drawn;
  double scene_took_s = 0.0;
  std::optional<std::uint64_t> screenshot_of;  // a picture that knows of this wish
  std::unique_ptr<VideoFile> video;
  WallClock::time_point video_begin;
  std::string note;  // what was written last
  WallClock::time_point noted;
  WallClock::time_point begun = WallClock::now();
  std::vector<double> drawing_s, scene_drawing_s;  // processor time of this thread, of each; scenes apart

  static constexpr int slowest_exponent = -5;
  static constexpr int fastest_exponent = 4;

  /// One picture of the window. `wait_s`: how long to wait for keyboard and mouse.
  void draw(double wait_s, double scene_period_s);
  void take_keys();
  void take_key(const Window::Key& key);
  void bar(const Area& area);
  void scene_panel(const Area& area, double period_s);
  void draw_scene(ImageSize size);
  void eye_panel(const Area& area);
  void hough_panel(const Area& area);
  void detectors_panel(const Area& area);
  void settings_panel(const Area& area);
  void display_settings();
  void plots_panel(const Area& area);
  void timeline_panel(const ViewLayout& layout);
  void help_window();
  void draw_marks(const Area& at);

  void set_speed(int exponent);
  [[nodiscard]] std::string speed_text() const;
  void toggle_play() {
    if (!picture.playing && picture.now_us >= picture.end_us) player->seek(picture.start_us);
    player->play(!picture.playing);
  }
  /// Does what writes a file; where it fails the window tells, and goes on.
  template <class Write>
  void try_to(Write write) {
    try {
      write();
    } catch (const std::exception& error) {
      say(error.what());
    }
  }
  void scale_threshold(double factor);
  void choose_detector(std::size_t index);
  [[nodiscard]] std::size_t colour_index(const std::string& detector) const;
  [[nodiscard]] ImU32 driver_colour() const {
    return picture.driver < picture.seen.size()
               ? detector_colour_on_dark(colour_index(picture.seen[picture.driver].name))
               : white;
  }
  [[nodiscard]] double since_start_s(std::int64_t t_us) const {
    return static_cast<double>(t_us - picture.start_us) * 1e-6;
  }
  [[nodiscard]] std::filesystem::path free_name(const std::string& stem, const char* extension) const;
  void say(const std::string& what) {
    note = what;
    noted = WallClock::now();
  }
  void wish_screenshot() { screenshot_of = player != nullptr ? player->last_wish() : 0; }
  void save_screenshot(const cv::Mat& shown);
  void toggle_video();
  void film(const cv::Mat& shown);
  void tell_rate() const;
};

// ---- keyboard --------------------------------------------------------------------------------------

void View::Parts::take_keys() {
  for (const Window::Key& key : window.keys()) {
    take_key(key);
  }
}

void View::Parts::take_key(const Window::Key& key) {
  const std::int64_t by_us = (key.shift ? 10 : 1) * Play::tick_us;
  if (player != nullptr) {  // these may repeat
    if (key.code == GLFW_KEY_RIGHT) player->step(by_us);
    if (key.code == GLFW_KEY_LEFT) player->step(-by_us);
    if (key.code == GLFW_KEY_UP) set_speed(speed_exponent + 1);
    if (key.code == GLFW_KEY_DOWN) set_speed(speed_exponent - 1);
    if (key.code == GLFW_KEY_LEFT_BRACKET) scale_threshold(1.0 / 1.1);
    if (key.code == GLFW_KEY_RIGHT_BRACKET) scale_threshold(1.1);
  }
  if (key.repeated) return;
  switch (key.code) {
    case GLFW_KEY_Q:
    case GLFW_KEY_ESCAPE:
      window.close();
      break;
    case GLFW_KEY_H:
      help = !help;
      break;
    case GLFW_KEY_S:
      wish_screenshot();
      break;
    case GLFW_KEY_V:
      try_to([&] { toggle_video(); });
      break;
    case GLFW_KEY_I:
      with_image = !with_image;
      break;
    case GLFW_KEY_C:
      with_circles = !with_circles;
      break;
    default:
      break;
  }
  if (player == nullptr) return;
  if (key.code == GLFW_KEY_SPACE) toggle_play();
  if (key.code == GLFW_KEY_HOME) player->seek(picture.start_us);
  const int number = key.code - GLFW_KEY_1;
  if (number >= 0 && number < std::min(9, static_cast<int>(settings.detectors.size())))
    choose_detector(static_cast<std::size_t>(number));
}

void View::Parts::set_speed(int exponent) {
  speed_exponent = std::clamp(exponent, slowest_exponent, fastest_exponent + 1);
  player->set_speed(speed_exponent > fastest_exponent ? Player::fastest : std::exp2(speed_exponent));
}

std::string View::Parts::speed_text() const {
  if (speed_exponent > fastest_exponent) return "max";
  return speed_exponent < 0 ? fmt::format("1/{} x", 1 << -speed_exponent)
                            : fmt::format("{} x", 1 << speed_exponent);
}

void View::Parts::scale_threshold(double factor) {
  DetectorConfig scaled = settings.detectors[settings.driver].config;
  *threshold_of(scaled) *= factor;
  try {
    std::visit([](const auto& config) { check_config("detector", config); }, scaled.detector);
  } catch (const InputError&) {
    return;  // as far as it goes
  }
  settings.detectors[settings.driver].config = scaled;
  player->set(settings);
}

void View::Parts::choose_detector(std::size_t index) {
  settings.driver = index;
  settings.detectors[index].on = true;
  player->set(settings);
}

std::size_t View::Parts::colour_index(const std::string& detector) const {
  for (std::size_t i = 0; i < settings.detectors.size(); ++i) {
    if (settings.detectors[i].name == detector) return i;
  }
  return 0;
}

// ---- the bar ---------------------------------------------------------------------------------------

void View::Parts::bar(const Area& area) {
  const Panel panel("bar", area);
  const auto button = [](const char* text, const char* tip, float width = 0.0F) {
    const bool pressed = ImGui::Button(text, {width, 26.0F});
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%s", tip);
    ImGui::SameLine();
    return pressed;
  };
  if (player != nullptr) {
    if (button(picture.playing ? "Pause" : "Play", "Space", 62.0F)) toggle_play();
    if (button("|<", "To the start: Home")) player->seek(picture.start_us);
    if (button("-10", "10 ms back: Shift \u2190")) player->step(-10 * Play::tick_us);
    if (button("-1", "1 ms back: \u2190")) player->step(-Play::tick_us);
    if (button("+1", "1 ms on: \u2192")) player->step(Play::tick_us);
    if (button("+10", "10 ms on: Shift \u2192")) player->step(10 * Play::tick_us);
    ImGui::SetNextItemWidth(120.0F);
    int exponent = speed_exponent;
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() + 2.0F);
    if (ImGui::SliderInt("##speed", &exponent, slowest_exponent, fastest_exponent + 1, "",
                         ImGuiSliderFlags_NoInput))
      set_speed(exponent);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("Speed: \u2191 and \u2193");
    ImGui::SameLine();
    ImGui::AlignTextToFramePadding();
    ImGui::Text("%s", speed_text().c_str());
    ImGui::SameLine(410.0F);
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() - 2.0F);
  }
  ImGui::AlignTextToFramePadding();
  ImGui::Text("%s", name.c_str());
  ImGui::SameLine(0.0F, 16.0F);
  ImGui::Text("%.3f s", since_start_s(picture.now_us));
  ImGui::SameLine();
  ImGui::TextDisabled("of %.3f s", since_start_s(picture.end_us));
  if (picture.seeking) {
    ImGui::SameLine(0.0F, 16.0F);
    ImGui::TextColored({0.95F, 0.75F, 0.25F, 1.0F}, "going there ...");
  } else if (picture.playing) {
    ImGui::SameLine(0.0F, 16.0F);
    ImGui::TextDisabled("%.2f x real time", picture.speed);
  }
  const std::string phase = phase_in_words(picture.phase);
  if (!phase.empty()) {
    ImGui::SameLine(0.0F, 16.0F);
    ImGui::TextColored(picture.phase == GazePhase::following ? ImVec4(0.45F, 0.85F, 0.5F, 1.0F)
                                                             : ImVec4(0.95F, 0.75F, 0.25F, 1.0F),
                       "%s", phase.c_str());
  }
  ImGui::SameLine(area.width - 224.0F);
  if (button("Screenshot", "S")) wish_screenshot();
  if (video) ImGui::PushStyleColor(ImGuiCol_Button, {0.65F, 0.15F, 0.12F, 1.0F});
  const bool filming = video != nullptr;
  if (button(filming ? "Stop video" : "Video", "V", 80.0F)) try_to([&] { toggle_video(); });
  if (filming) ImGui::PopStyleColor();
  if (button("Keys", "H")) help = !help;
}

// ---- what is seen ----------------------------------------------------------------------------------

void View::Parts::scene_panel(const Area& area, double period_s) {
  const Panel panel("scene", area);
  const bool has_world = picture.model != nullptr && picture.scene != nullptr;
  const Area at = {area.x + 4.0F, area.y + ViewLayout::caption, area.width - 8.0F,
                   area.height - ViewLayout::caption - 4.0F};
  caption(area, has_world ? "Scene" : fmt::format("Events of the last {} ms", cloud_us / 1000));
  Legend legend(area);
  if (has_world) {
    legend.add("target", target_colour, 'x');
    legend.add("gaze", IM_COL32(250, 220, 60, 255), '.');
    legend.add("field of view", IM_COL32(110, 190, 250, 255), '.');
  } else {
    legend.add("OFF", colour_of(off_rgb), '.');
    legend.add("ON", colour_of(on_rgb), '.');
  }
  ImGui::SetCursorScreenPos({at.x, at.y});
  ImGui::InvisibleButton("turn", {at.width, at.height});
  const ImGuiIO& io = ImGui::GetIO();
  if (ImGui::IsItemActive() && (io.MouseDelta.x != 0.0F || io.MouseDelta.y != 0.0F)) {
    scene_view.azimuth_rad -= 0.008 * static_cast<double>(io.MouseDelta.x);
    scene_view.elevation_rad =
        std::clamp(scene_view.elevation_rad - 0.008 * static_cast<double>(io.MouseDelta.y), -1.4, 1.4);
    scene_stale = true;
  }
  if (ImGui::IsItemHovered() && io.MouseWheel != 0.0F) {
    scene_view.distance_m =
        std::clamp(scene_view.distance_m * std::pow(0.9, static_cast<double>(io.MouseWheel)), 0.3, 4.0);
    scene_stale = true;
  }
  const ImageSize size{static_cast<int>(at.width), static_cast<int>(at.height)};
  const bool moves = picture.playing || picture.seeking;
  const WallClock::time_point now = WallClock::now();
  if (scene_stale && (!moves || seconds(scene_drawn, now) >= std::max(period_s, 3.0 * scene_took_s))) {
    const double start_s = processor_s();
    if (has_world) {
      draw_scene(size);
    } else {
      constexpr double from_the_side = 1.1;
      paint_cloud(picture, cloud_us, scene_view.azimuth_rad - profile_view().azimuth_rad + from_the_side,
                  scene_view.elevation_rad - profile_view().elevation_rad + 0.3, size, scene_rgb);
    }
    scene_texture.set(size, scene_rgb);
    scene_drawn = WallClock::now();
    scene_took_s = seconds(now, scene_drawn);
    scene_stale = false;
    scene_drawing_s.push_back(processor_s() - start_s);
  }
  add_picture(scene_texture, at);
}

void View::Parts::draw_scene(ImageSize size) {
  std::vector<SceneMark> marks;
  const auto& root_from_cam = picture.truth ? picture.truth->root_from_cam : std::nullopt;
  if (root_from_cam) {
    const Camera& camera = picture.camera;
    const Eigen::Vector3d eye = root_from_cam->translation();
    const Eigen::Vector3d axis = root_from_cam->linear().col(2);
    const double reach_m =
        picture.truth->target_m ? std::max(0.2, (*picture.truth->target_m - eye).dot(axis)) : 0.6;
    marks.push_back({eye, eye + reach_m * axis, 0.0016, {1.0F, 0.7F, 0.03F, 1.0F}});
    const double w = camera.size.width - 1.0;
    const double h = camera.size.height - 1.0;
    std::vector<Eigen::Vector3d> corners;
    for (const auto& [u, v] : {std::pair{0.0, 0.0}, {w, 0.0}, {w, h}, {0.0, h}})
      corners.emplace_back(*root_from_cam * (0.14 * camera.ray(u, v)));
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (!corners[i].allFinite()) continue;
      const std::array<float, 4> blue = {0.15F, 0.5F, 0.95F, 1.0F};
      marks.push_back({eye, corners[i], 0.001, blue});
      if (corners[(i + 1) % 4].allFinite()) marks.push_back({corners[i], corners[(i + 1) % 4], 0.001, blue});
    }
    if (picture.truth->target_m) {
      for (int axis_of = 0; axis_of < 3; ++axis_of) {
        const Eigen::Vector3d arm = 0.02 * Eigen::Vector3d::Unit(axis_of);
        marks.push_back({*picture.truth->target_m - arm,
                         *picture.truth->target_m + arm,
                         0.0025,
                         {0.79F, 0.35F, 0.0F, 1.0F}});
      }
    }
  }
  window.publish();
  if (!scene || scene->image_size() != size)
    scene = std::make_unique<SceneRenderer>(*picture.model, window, size);
  scene_rgb.resize(3 * static_cast<std::size_t>(size.pixels()));
  scene->render(*picture.scene, scene_view, scene_rgb, marks);
}

/// Circles, target and crosshair over an eye's picture.
void View::Parts::draw_marks(const Area& at) {
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.PushClipRect({at.x, at.y}, {at.x + at.width, at.y + at.height}, true);
  const float scale = at.width / static_cast<float>(picture.camera.size.width);
  const auto place = [&](double x_px, double y_px) {
    return ImVec2(at.x + scale * static_cast<float>(x_px + 0.5),
                  at.y + scale * static_cast<float>(y_px + 0.5));
  };
  const auto circle = [&](const Circle& c, ImU32 colour, float width) {
    draw.AddCircle(place(c.x_px, c.y_px), scale * static_cast<float>(c.r_px), colour, 64, width);
  };
  if (picture.truth && picture.truth->circle) {
    circle(*picture.truth->circle, dark, 4.0F);
    circle(*picture.truth->circle, white, 1.6F);
  }
  for (const Seen& seen : picture.seen) {
    if (!with_circles || !seen.tick.observed || seen.tick.estimate.score < seen.threshold) continue;
    const bool driver = &seen == picture.seen.data() + picture.driver;
    circle(seen.tick.estimate.circle, detector_colour_on_dark(colour_index(seen.name)), driver ? 2.6F : 1.4F);
  }
  if (picture.truth && picture.truth->target_px) {
    const ImVec2 c = place(picture.truth->target_px->x(), picture.truth->target_px->y());
    for (const auto& [colour, width] : {std::pair{dark, 4.0F}, {target_colour, 2.0F}})
      draw.AddQuad({c.x - 7, c.y}, {c.x, c.y - 7}, {c.x + 7, c.y}, {c.x, c.y + 7}, colour, width);
  }
  if (picture.truth && picture.truth->root_from_cam) {
    const ImVec2 c = place(picture.camera.cx_px, picture.camera.cy_px);
    for (const auto& [colour, width] : {std::pair{dark, 3.0F}, {IM_COL32(250, 220, 60, 255), 1.2F}}) {
      draw.AddLine({c.x - 6, c.y}, {c.x + 6, c.y}, colour, width);
      draw.AddLine({c.x, c.y - 6}, {c.x, c.y + 6}, colour, width);
    }
  }
  draw.PopClipRect();
}

void View::Parts::eye_panel(const Area& area) {
  const Panel panel("eye", area);
  caption(area, fmt::format("Eye, events of {} ms", fade_ms));
  Legend legend(area);
  if (picture.truth && picture.truth->target_px) legend.add("target", target_colour, 'x');
  if (picture.truth && picture.truth->circle) legend.add("truth", white, 'o');
  legend.add("OFF", colour_of(off_rgb), '.');
  legend.add("ON", colour_of(on_rgb), '.');
  const Area at = ViewLayout::fit(area, picture.camera.size);
  add_picture(eye_texture, at);
  draw_marks(at);
}

void View::Parts::hough_panel(const Area& area) {
  const Panel panel("hough", area);
  const std::string of = picture.driver < picture.seen.size() ? picture.seen[picture.driver].name : "";
  caption(area, fmt::format("Hough space, {}", of));
  const Area at = ViewLayout::fit(area, picture.camera.size);
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  if (picture.hough.empty()) {
    draw.AddText({at.x + 12.0F, at.y + 0.45F * at.height}, dim, "This detector has none.");
    return;
  }
  add_picture(hough_texture, at);
  const std::size_t best =
      static_cast<std::size_t>(std::ranges::max_element(picture.hough) - picture.hough.begin());
  const float scale = at.width / static_cast<float>(picture.camera.size.width);
  const auto width = static_cast<std::size_t>(picture.camera.size.width);
  const ImVec2 peak(at.x + scale * (static_cast<float>(best % width) + 0.5F),
                    at.y + scale * (static_cast<float>(best / width) + 0.5F));
  if (picture.hough[best] > 0.0F) draw.AddCircle(peak, 9.0F, IM_COL32(120, 220, 255, 255), 24, 1.4F);
  const std::string text = fmt::format("strongest {:.3g}", picture.hough[best]);
  draw.AddRectFilled({at.x, at.y + at.height - 19.0F},
                     {at.x + ImGui::CalcTextSize(text.c_str()).x + 12.0F, at.y + at.height}, dark);
  draw.AddText({at.x + 6.0F, at.y + at.height - 18.0F}, dim, text.c_str());
}

void View::Parts::detectors_panel(const Area& area) {
  const Panel panel("detectors", area, true);
  ImGui::TextUnformatted("Detectors");
  ImGui::SameLine(area.width - 8.0F - ImGui::CalcTextSize("score").x);
  ImGui::TextDisabled("score");
  for (std::size_t i = 0; i < settings.detectors.size(); ++i) {
    ViewSettings::NamedDetector& named = settings.detectors[i];
    ImGui::PushID(static_cast<int>(i));
    const ImVec2 row = ImGui::GetCursorScreenPos();
    ImDrawList& draw = *ImGui::GetWindowDrawList();
    const ImU32 colour = detector_colour_on_dark(i);
    if (player != nullptr) {
      bool on = named.on;
      if (ImGui::Checkbox("##on", &on) && i != settings.driver) {
        named.on = on;
        player->set(settings);
      }
      if (ImGui::IsItemHovered())
        ImGui::SetTooltip(i == settings.driver ? "This one is looked at" : "Whether it runs");
      ImGui::SameLine();
    }
    const float left = ImGui::GetCursorScreenPos().x;
    draw.AddRectFilled({left, row.y + 5.0F}, {left + 10.0F, row.y + 15.0F}, colour);
    ImGui::SetCursorScreenPos({left + 16.0F, row.y});
    ImGui::AlignTextToFramePadding();
    if (i == settings.driver) {
      ImGui::TextUnformatted(named.name.c_str());
    } else {
      ImGui::TextDisabled("%s", named.name.c_str());
    }
    if (player != nullptr && ImGui::IsItemClicked()) choose_detector(i);
    const auto seen = std::ranges::find(picture.seen, named.name, &Seen::name);
    if (seen != picture.seen.end() && seen->tick.observed) {
      const bool accepted = seen->tick.estimate.score >= seen->threshold;
      const std::string text =
          fmt::format("{:.2f}{}", seen->tick.estimate.score, seen->tick.estimate.held ? " held" : "");
      ImGui::SameLine(area.width - 8.0F - ImGui::CalcTextSize(text.c_str()).x);
      ImGui::AlignTextToFramePadding();
      accepted ? ImGui::TextUnformatted(text.c_str()) : ImGui::TextDisabled("%s", text.c_str());
    }
    ImGui::PopID();
  }
}

// ---- settings --------------------------------------------------------------------------------------

void View::Parts::display_settings() {
  ImGui::TextUnformatted("Picture");
  ImGui::Separator();
  const auto label = [](const char* text) {
    ImGui::AlignTextToFramePadding();
    ImGui::TextUnformatted(text);
    ImGui::SameLine(124.0F);
    ImGui::SetNextItemWidth(-1.0F);
  };
  label("events");
  ImGui::SliderInt("##fade", &fade_ms, 1, static_cast<int>(Picture::events_us / 1000), "%d ms",
                   ImGuiSliderFlags_Logarithmic);
  if (!picture.grey.empty()) {
    label("eye's image");
    ImGui::Checkbox("##image", &with_image);
  }
  label("circles");
  ImGui::Checkbox("##circles", &with_circles);
}

void View::Parts::settings_panel(const Area& area) {
  const Panel panel("settings", area, true);
  if (player == nullptr) {
    ImGui::TextWrapped("A run is shown as it goes. It does not notice: close the window, and it goes on.");
    ImGui::Dummy({0.0F, 6.0F});
    display_settings();
    return;
  }
  bool changed = false;
  ImGui::TextUnformatted(settings.controller ? "Detector that drives the gaze" : "Detector");
  ImGui::Separator();
  ImGui::SetNextItemWidth(-1.0F);
  if (ImGui::BeginCombo("##detector", settings.detectors[settings.driver].name.c_str(),
                        ImGuiComboFlags_HeightLarge)) {
    for (std::size_t i = 0; i < settings.detectors.size(); ++i) {
      if (ImGui::Selectable(settings.detectors[i].name.c_str(), i == settings.driver)) choose_detector(i);
    }
    ImGui::Separator();
    for (const std::string& preset : detector_presets()) {
      if (std::ranges::find(settings.detectors, preset, &ViewSettings::NamedDetector::name) !=
          settings.detectors.end())
        continue;
      if (!ImGui::Selectable(("add " + preset).c_str())) continue;
      settings.detectors.push_back({preset, detector_preset(preset), true});
      choose_detector(settings.detectors.size() - 1);
    }
    ImGui::EndCombo();
  }
  ViewSettings::NamedDetector& driver = settings.detectors[settings.driver];
  ImGui::PushStyleVar(ImGuiStyleVar_IndentSpacing, 8.0F);
  changed = editor.edit(driver.name, driver.config, {"preset"}) || changed;
  if (settings.controller) {
    ImGui::Dummy({0.0F, 4.0F});
    ImGui::TextUnformatted("Gaze");
    ImGui::Separator();
    changed = editor.edit("controller", *settings.controller, {"limits", "script"}) || changed;
    if (settings.gate) changed = editor.edit("gate", *settings.gate) || changed;
  }
  ImGui::PopStyleVar();
  ImGui::Dummy({0.0F, 4.0F});
  display_settings();
  if (!picture.problem.empty()) {
    ImGui::Dummy({0.0F, 4.0F});
    ImGui::PushStyleColor(ImGuiCol_Text, {1.0F, 0.5F, 0.42F, 1.0F});
    ImGui::TextWrapped("Not taken: %s", picture.problem.c_str());
    ImGui::PopStyleColor();
  }
  if (changed) player->set(settings);
}

// ---- over time -------------------------------------------------------------------------------------

void View::Parts::plots_panel(const Area& area) {
  const Panel panel("plots", area);
  using enum PlotCurve::Style;
  const ImU32 found = driver_colour();
  const bool truth =
      std::ranges::any_of(picture.samples, [](const PlotSample& s) { return std::isfinite(s.truth_px[0]); });
  const bool gaze = std::ranges::any_of(picture.samples,
                                        [](const PlotSample& s) { return std::isfinite(s.gaze_error_deg); });
  const bool head = !picture.samples.empty() && std::isfinite(picture.samples.back().joints_deg[0]);
  std::vector<Plot> plots;
  for (const int axis : {0, 1}) {
    const auto i = static_cast<std::size_t>(axis);
    Plot plot;
    plot.title = axis == 0 ? "x, px" : "y, px";
    plot.high = axis == 0 ? picture.camera.size.width : picture.camera.size.height;
    plot.fixed = true;
    plot.downward = axis == 1;
    if (truth)
      plot.curves.push_back({"truth", white, line, [i](const PlotSample& s) { return s.truth_px[i]; }});
    plot.curves.push_back({"found", found, dots, [i](const PlotSample& s) { return s.found_px[i]; }});
    plots.push_back(std::move(plot));
  }
  Plot score;
  score.title = "score";
  score.curves = {{"threshold", red, line, [](const PlotSample& s) { return s.threshold; }},
                  {"", found, dots, [](const PlotSample& s) { return s.score; }}};
  score.high = 0.1;
  plots.push_back(std::move(score));
  Plot rate;
  rate.title = "events, 1000/s";
  rate.high = 10.0;
  rate.curves = {{"", IM_COL32(190, 190, 196, 255), mean, [](const PlotSample& s) { return s.events; }}};
  plots.push_back(std::move(rate));
  if (gaze) {
    Plot error;
    error.title = "gaze error, deg";
    error.high = 4.0;
    error.curves = {
        {"", IM_COL32(250, 220, 60, 255), line, [](const PlotSample& s) { return s.gaze_error_deg; }},
        {"2", dim, line, [](const PlotSample&) { return 2.0F; }}};
    plots.push_back(std::move(error));
  }
  if (head) {
    Plot joints;
    joints.title = "joints, deg";
    joints.low = -10.0;
    joints.high = 10.0;
    const std::array<std::pair<const char*, ImU32>, 6> shown = {{{"pitch", IM_COL32(230, 120, 110, 255)},
                                                                 {"", IM_COL32(200, 130, 200, 255)},
                                                                 {"yaw", IM_COL32(230, 190, 90, 255)},
                                                                 {"tilt", IM_COL32(110, 200, 130, 255)},
                                                                 {"pan", IM_COL32(100, 180, 250, 255)},
                                                                 {"", IM_COL32(150, 150, 230, 255)}}};
    for (std::size_t j = 0; j < shown.size(); ++j) {
      const std::size_t joint = torso_joint_count + j;
      joints.curves.push_back({shown[j].first, shown[j].second, line,
                               [joint](const PlotSample& s) { return s.joints_deg[joint]; }});
    }
    plots.push_back(std::move(joints));
  }
  // Words over the curves.
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  draw.ChannelsSplit(2);
  draw.ChannelsSetCurrent(1);
  const ImageSize size{static_cast<int>(area.width) - 8, static_cast<int>(area.height) - 8};
  const Area inside = {area.x + 4.0F, area.y + 4.0F, static_cast<float>(size.width),
                       static_cast<float>(size.height)};
  cv::Mat canvas(size.height, size.width, CV_8UC3, cv::Scalar(32, 32, 34));
  const auto count = static_cast<float>(plots.size());
  const float gap = 10.0F;
  const float width = (inside.width - 8.0F - gap * (count - 1.0F)) / count;
  for (std::size_t i = 0; i < plots.size(); ++i) {
    const float x = inside.x + 4.0F + static_cast<float>(i) * (width + gap);
    draw_plot(plots[i], {x, inside.y, width, inside.height}, picture, canvas, inside);
  }
  plots_texture.set(size, std::span(canvas.data, canvas.total() * 3));
  draw.ChannelsSetCurrent(0);
  add_picture(plots_texture, inside);
  draw.ChannelsMerge();
}

void View::Parts::timeline_panel(const ViewLayout& layout) {
  const Panel panel("timeline", layout.timeline);
  const Area strip = layout.time_strip();
  ImDrawList& draw = *ImGui::GetWindowDrawList();
  const double span_us = std::max(1.0, static_cast<double>(picture.end_us - picture.start_us));
  const auto x_of = [&](std::int64_t t_us) {
    return strip.x + strip.width * static_cast<float>(static_cast<double>(t_us - picture.start_us) / span_us);
  };
  const float bottom = strip.y + strip.height;
  draw.AddRectFilled({strip.x, strip.y}, {strip.x + strip.width, bottom}, IM_COL32(22, 22, 24, 255), 3.0F);
  const float now_x = x_of(picture.now_us);
  if (player == nullptr || player->overview().empty()) {
    draw.AddRectFilled({strip.x, strip.y}, {now_x, bottom}, IM_COL32(46, 66, 88, 255), 3.0F);
  } else {
    const ImageSize size{static_cast<int>(strip.width), static_cast<int>(strip.height)};
    if (size != overview_size) {
      paint_overview(player->overview(), size, rgb);
      overview_texture.set(size, rgb);
      overview_size = size;
    }
    add_picture(overview_texture, strip);
    draw.AddRectFilled({strip.x, strip.y}, {now_x, bottom}, IM_COL32(70, 130, 200, 80));
  }
  if (player != nullptr) {
    ImGui::SetCursorScreenPos({strip.x, strip.y - 4.0F});
    ImGui::InvisibleButton("time", {strip.width, strip.height + 8.0F});
    const float share = std::clamp((ImGui::GetIO().MousePos.x - strip.x) / strip.width, 0.0F, 1.0F);
    const std::int64_t at_us = picture.start_us + std::llround(static_cast<double>(share) * span_us);
    const bool moved = ImGui::GetIO().MouseDelta.x != 0.0F || ImGui::IsItemActivated();
    if (ImGui::IsItemActive() && moved) player->seek(at_us);
    if (ImGui::IsItemHovered()) ImGui::SetTooltip("%.3f s", since_start_s(at_us));
  }
  draw.AddRectFilled({now_x - 1.0F, strip.y - 3.0F}, {now_x + 1.0F, bottom + 3.0F}, white);
  const float text_y = bottom + 2.0F;
  draw.AddText({strip.x, text_y}, dim, "0 s");
  const std::string end = fmt::format("{:.3f} s", since_start_s(picture.end_us));
  draw.AddText({strip.x + strip.width - ImGui::CalcTextSize(end.c_str()).x, text_y}, dim, end.c_str());
  std::string text = player != nullptr
                         ? "drag to scrub   Space play   \u2190 \u2192 step   \u2191 \u2193 speed   "
                           "[ ] threshold   S screenshot   V video   H keys   Q quit"
                         : "S screenshot   V video   H keys   Q close the window, the run goes on";
  if (!note.empty() && seconds(noted, WallClock::now()) < 4.0) text = note;
  const float text_width = ImGui::CalcTextSize(text.c_str()).x;
  draw.AddText({strip.x + 0.5F * (strip.width - text_width), text_y}, dim, text.c_str());
}

void View::Parts::help_window() {
  if (!help) return;
  ImGui::SetNextWindowPos(
      {0.5F * static_cast<float>(window.width()), 0.45F * static_cast<float>(window.height())}, 0,
      {0.5F, 0.5F});
  ImGui::Begin("Keys", &help,
               ImGuiWindowFlags_AlwaysAutoResize | ImGuiWindowFlags_NoCollapse | ImGuiWindowFlags_NoNav);
  const auto row = [](const char* key, const char* meaning) {
    ImGui::TextColored({0.5F, 0.74F, 0.95F, 1.0F}, "%s", key);
    ImGui::SameLine(110.0F);
    ImGui::TextUnformatted(meaning);
  };
  if (player != nullptr) {
    row("Space", "play, pause");
    row("\u2190 \u2192", "1 ms back, on; with Shift 10 ms");
    row("Home", "to the start");
    row("\u2191 \u2193", "faster, slower");
    row("[ ]", "threshold of the detector down, up");
    row("1 to 9", "which detector is looked at and drives");
  }
  row("I", "the eye's image under its events");
  row("C", "circles of the detectors");
  row("S", "screenshot (PNG)");
  row("V", "start and stop a video (MP4)");
  row("H", "this list");
  row("Q, Esc", player != nullptr ? "quit" : "close the window; the run goes on");
  ImGui::Separator();
  ImGui::TextUnformatted("Drag in the scene to turn it, wheel to come closer.");
  ImGui::TextUnformatted("Ctrl-click on a slider to type a number.");
  ImGui::End();
}

// ---- screenshots and videos ------------------------------------------------------------------------

std::filesystem::path View::Parts::free_name(const std::string& stem, const char* extension) const {
  std::filesystem::create_directories(pictures);
  std::filesystem::path path = pictures / (stem + extension);
  for (int i = 2; std::filesystem::exists(path); ++i)
    path = pictures / fmt::format("{}_{}{}", stem, i, extension);
  return path;
}

void View::Parts::save_screenshot(const cv::Mat& shown) {
  std::vector<unsigned char> png;
  cv::imencode(".png", shown, png);
  const auto path =
      free_name(fmt::format("{}_{:06}ms", name, (picture.now_us - picture.start_us) / 1000), ".png");
  OutputFile file(path);
  file.write(std::as_bytes(std::span(png)));
  file.commit();
  say("written: " + path.string());
}

void View::Parts::toggle_video() {
  if (const std::unique_ptr<VideoFile> done = std::move(video)) {
    if (done->pictures() > 0) done->commit();
    say("written: " + done->path().string());
    return;
  }
  // H.264 wants even sides.
  video = std::make_unique<VideoFile>(free_name(name, ".mp4"),
                                      ImageSize{window.width() / 2 * 2, window.height() / 2 * 2}, video_hz);
  video_begin = WallClock::now();
}

void View::Parts::film(const cv::Mat& shown) {
  if (!video) return;
  const ImageSize size = video->size();
  if (shown.cols < size.width || shown.rows < size.height) return toggle_video();  // made smaller meanwhile
  const auto due = std::llround(seconds(video_begin, WallClock::now()) * video_hz);
  const cv::Mat part = shown({0, 0, size.width, size.height}).clone();
  while (video->pictures() <= due) video->add(part);
}

void View::Parts::tell_rate() const {
  if (drawing_s.empty()) return;
  const auto median_ms = [](std::vector<double> values_s) {
    if (values_s.empty()) return 0.0;
    std::ranges::nth_element(values_s, values_s.begin() + static_cast<std::ptrdiff_t>(values_s.size() / 2));
    return 1e3 * values_s[values_s.size() / 2];
  };
  const double whole_s = seconds(begun, WallClock::now());
  fmt::print(
      "{} pictures in {:.1f} s, {:.1f} a second; processor time of one {:.1f} ms, of a scene {:.1f} ms\n",
      drawing_s.size(), whole_s, static_cast<double>(drawing_s.size()) / whole_s, median_ms(drawing_s),
      median_ms(scene_drawing_s));
}

// ---- all together ----------------------------------------------------------------------------------

void View::Parts::draw(double wait_s, double scene_period_s) {
  window.begin(wait_s);
  const double start_s = processor_s();
  const std::size_t scenes = scene_drawing_s.size();
  const ViewLayout layout(window.width(), window.height());
  take_keys();
  draw_gaps(layout, window.width(), window.height());
  paint_eye(picture, fade_ms * 1000, with_image, rgb);
  eye_texture.set(picture.camera.size, rgb);
  if (!picture.hough.empty()) {
    paint_hough(picture, rgb);
    hough_texture.set(picture.camera.size, rgb);
  }
  bar(layout.bar);
  scene_panel(layout.scene, scene_period_s);
  eye_panel(layout.eye);
  hough_panel(layout.hough);
  detectors_panel(layout.detectors);
  settings_panel(layout.settings);
  plots_panel(layout.plots);
  timeline_panel(layout);
  help_window();

  const bool shoot = screenshot_of && !scene_stale && !picture.seeking &&
                     (player == nullptr || picture.handled >= *screenshot_of);
  cv::Mat shown;
  window.end(shoot || video ? &shown : nullptr);
  if (shoot) {
    screenshot_of.reset();
    try_to([&] { save_screenshot(shown); });
  }
  if (video) try_to([&] { film(shown); });
  drawing_s.push_back(processor_s() - start_s);
  if (scene_drawing_s.size() > scenes) drawing_s.back() -= scene_drawing_s.back();
}

View::View(std::string name, std::filesystem::path pictures)
    : parts_(std::make_unique<Parts>(std::move(name), std::move(pictures))) {}
View::~View() = default;

void View::show(Player& player) {
  Parts& parts = *parts_;
  parts.player = &player;
  parts.settings = player.settings();
  parts.begun = WallClock::now();
  WallClock::time_point next = WallClock::now();
  WallClock::time_point active = WallClock::now();
  while (!parts.window.closed() && !interrupted()) {
    const bool taken = player.take(parts.picture);
    parts.has_picture = parts.has_picture || taken;
    if (taken) parts.scene_stale = true;
    const WallClock::time_point now = WallClock::now();
    const ImGuiIO& io = ImGui::GetIO();
    if (taken || io.MouseDelta.x != 0.0F || io.MouseDelta.y != 0.0F || ImGui::IsAnyItemActive()) active = now;
    if (!parts.has_picture) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      continue;
    }
    // While nothing happens a few pictures a second will do.
    const double period_s = seconds(active, now) < 0.3 || parts.video ? picture_s : 0.05;
    const double wait_s = std::max(0.0, seconds(now, next));
    parts.draw(wait_s, scene_s);
    next = std::max(
        next + std::chrono::duration_cast<WallClock::duration>(std::chrono::duration<double>(period_s)),
        WallClock::now());
  }
  if (parts.video) parts.try_to([&] { parts.toggle_video(); });
  parts.tell_rate();
}

// ---- beside a run ----------------------------------------------------------------------------------

View::Feed::Feed(const Scenario& scenario)
    : camera_(scenario.sim.camera),
      driver_(scenario.gaze.detector),
      watcher_(scenario.sim.camera, Eye::left, 0, std::llround(scenario.run.duration_s * 1e6)) {}

void View::Feed::see(const Tick& tick, const SimRobot& robot, const Loop& loop) {
  if (closed_.load(std::memory_order_relaxed)) return;
  std::size_t driver = 0;
  for (std::size_t i = 0; i < loop.detectors().size(); ++i) {
    if (loop.detectors()[i].name == driver_) driver = i;
  }
  watcher_.see(tick, shown_truth(robot, camera_, tick), loop, driver);
  if (!mailbox_.wanted()) return;
  Picture& picture = mailbox_.spare();
  watcher_.fill(picture, loop);
  fill_from(robot, picture);
  picture.playing = true;
  mailbox_.send();
}

void View::Feed::close() {
  const std::lock_guard lock(drawing_);
  closed_ = true;
}

int View::show_run(const Scenario& scenario, const std::function<int(Feed&)>& run) {
  Feed feed(scenario);
  std::future<int> result = std::async(std::launch::async, [&] {
    struct Closing {
      Feed& feed;
      ~Closing() { feed.close(); }
    } closing{feed};
    return run(feed);
  });
  {
    Parts& parts = *parts_;
    parts.settings = view_settings(scenario.detectors, scenario.gaze.detector);
    parts.begun = WallClock::now();
    WallClock::time_point speed_at = parts.begun;
    std::int64_t speed_from_us = 0;
    double speed = 0.0;
    while (!parts.window.closed() && !feed.closed_) {
      const WallClock::time_point start = WallClock::now();
      {
        const std::lock_guard lock(feed.drawing_);
        if (feed.closed_) break;
        const bool taken = feed.mailbox_.take(parts.picture);
        parts.has_picture = parts.has_picture || taken;
        if (taken) parts.scene_stale = true;
        if (seconds(speed_at, start) > 0.5) {
          speed = static_cast<double>(parts.picture.now_us - speed_from_us) * 1e-6 / seconds(speed_at, start);
          speed_at = start;
          speed_from_us = parts.picture.now_us;
        }
        parts.picture.speed = speed;
        if (parts.has_picture) parts.draw(0.0, scene_beside_run_s);
      }
      const double used_s = seconds(start, WallClock::now());
      std::this_thread::sleep_for(
          std::chrono::duration<double>(std::max(beside_run_s - used_s, 2.0 * used_s)));
    }
    if (parts.video) parts.try_to([&] { parts.toggle_video(); });
    parts.tell_rate();
    feed.mailbox_.decline();
    parts_.reset();  // the window is gone while the run goes on
  }
  return result.get();
}

}  // namespace saccade
