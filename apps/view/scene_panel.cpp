#include "apps/view/scene_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "apps/view/colours.h"
#include "apps/view/panel.h"

namespace saccade {
namespace {

constexpr std::int64_t cloud_us = 60'000;

/// Linear, as the renderer takes it.
std::array<float, 4> glow(const Colour& colour) {
  const auto linear = [](std::uint8_t value) { return std::pow(static_cast<float>(value) / 255.0F, 2.2F); };
  return {linear(colour.red), linear(colour.green), linear(colour.blue), 1.0F};
}

/// Optical axis, field of view and gaze target.
std::vector<SceneMark> marks_of(const Snapshot& snapshot) {
  std::vector<SceneMark> marks;
  if (!snapshot.truth || !snapshot.truth->root_from_cam) return marks;
  const SnapshotTruth& truth = *snapshot.truth;
  const Camera& camera = snapshot.camera;
  const Eigen::Vector3d eye = truth.root_from_cam->translation();
  const Eigen::Vector3d axis = truth.root_from_cam->linear().col(2);
  const double reach_m = truth.target_m ? std::max(0.2, (*truth.target_m - eye).dot(axis)) : 0.6;
  marks.push_back({eye, eye + reach_m * axis, 0.0016, glow(gaze_colour)});
  const double w = camera.size.width - 1.0;
  const double h = camera.size.height - 1.0;
  std::vector<Eigen::Vector3d> corners;
  for (const auto& [u, v] : {std::pair{0.0, 0.0}, {w, 0.0}, {w, h}, {0.0, h}})
    corners.emplace_back(*truth.root_from_cam * (0.14 * camera.ray(u, v)));
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!corners[i].allFinite()) continue;
    const std::array<float, 4> blue = {0.15F, 0.5F, 0.95F, 1.0F};
    marks.push_back({eye, corners[i], 0.001, blue});
    if (corners[(i + 1) % 4].allFinite()) marks.push_back({corners[i], corners[(i + 1) % 4], 0.001, blue});
  }
  if (!truth.target_m) return marks;
  for (int axis_of = 0; axis_of < 3; ++axis_of) {
    const Eigen::Vector3d arm = 0.02 * Eigen::Vector3d::Unit(axis_of);
    marks.push_back({*truth.target_m - arm, *truth.target_m + arm, 0.0025, glow(gaze_target_colour)});
  }
  return marks;
}

}  // namespace

double processor_s() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void ScenePanel::draw(const Area& area, const Snapshot& snapshot, ViewState& state, double min_period_s) {
  const Panel panel("scene", area);
  const bool has_world = snapshot.model != nullptr && snapshot.scene != nullptr;
  const Area at = {area.x + 4.0F, area.y + ViewLayout::caption, area.width - 8.0F,
                   area.height - ViewLayout::caption - 4.0F};
  draw_caption(area, has_world ? "Scene" : fmt::format("Events of the last {} ms", cloud_us / 1000));
  Legend legend(area);
  if (has_world) {
    legend.add("target", colours::target, Legend::Mark::diamond);
    legend.add("axis", colours::gaze, Legend::Mark::square);
    legend.add("field of view", colours::field_of_view, Legend::Mark::square);
  } else {
    legend.add("OFF", colours::off, Legend::Mark::square);
    legend.add("ON", colours::on, Legend::Mark::square);
  }
  turn(at, state);
  const ImageSize size{static_cast<int>(at.width), static_cast<int>(at.height)};
  const bool moves = snapshot.playing || snapshot.seeking;
  const WallClock::time_point now = WallClock::now();
  if (stale_ && (!moves || seconds_between(drawn_, now) >= std::max(min_period_s, 3.0 * took_s_))) {
    const double start_s = processor_s();
    if (has_world) {
      draw_scene(snapshot, state.scene_view, size);
    } else {
      constexpr double from_the_side_rad = 1.1;
      paint_event_cloud(snapshot, cloud_us,
                        state.scene_view.azimuth_rad - profile_view().azimuth_rad + from_the_side_rad,
                        state.scene_view.elevation_rad - profile_view().elevation_rad + 0.3, size, rgb_);
    }
    texture_.set(size, rgb_);
    drawn_ = WallClock::now();
    took_s_ = seconds_between(now, drawn_);
    stale_ = false;
    drawing_s_.push_back(processor_s() - start_s);
  }
  draw_texture(texture_, at);
}

/// Drag and wheel.
void ScenePanel::turn(const Area& at, ViewState& state) {
  ImGui::SetCursorScreenPos({at.x, at.y});
  ImGui::InvisibleButton("turn", {at.width, at.height});
  const ImGuiIO& io = ImGui::GetIO();
  SceneView& view = state.scene_view;
  if (ImGui::IsItemActive() && (io.MouseDelta.x != 0.0F || io.MouseDelta.y != 0.0F)) {
    view.azimuth_rad -= 0.008 * static_cast<double>(io.MouseDelta.x);
    view.elevation_rad =
        std::clamp(view.elevation_rad - 0.008 * static_cast<double>(io.MouseDelta.y), -1.4, 1.4);
    stale_ = true;
  }
  if (ImGui::IsItemHovered() && io.MouseWheel != 0.0F) {
    view.distance_m =
        std::clamp(view.distance_m * std::pow(0.9, static_cast<double>(io.MouseWheel)), 0.3, 4.0);
    stale_ = true;
  }
}

void ScenePanel::draw_scene(const Snapshot& snapshot, const SceneView& view, ImageSize size) {
  window_.publish();
  if (!renderer_ || renderer_->image_size() != size || model_ != snapshot.model) {
    renderer_.reset();
    model_ = snapshot.model;
    renderer_ = std::make_unique<SceneRenderer>(*model_, window_, size);
  }
  rgb_.resize(3 * static_cast<std::size_t>(size.pixels()));
  renderer_->render(*snapshot.scene, view, rgb_, marks_of(snapshot));
}

}  // namespace saccade
