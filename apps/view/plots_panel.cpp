#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core.hpp>
#include <utility>

#include "apps/view/colours.h"
#include "apps/view/panel.h"
#include "apps/view/panels.h"
#include "apps/view/plot.h"

namespace saccade {
namespace {

using enum PlotCurve::Style;

Plot position_plot(std::size_t axis, const Snapshot& snapshot, ImU32 detected, bool truth) {
  Plot plot;
  plot.title = axis == 0 ? "x, px" : "y, px";
  plot.high = axis == 0 ? snapshot.camera.size.width : snapshot.camera.size.height;
  plot.fixed = true;
  plot.downward = axis == 1;
  if (truth)
    plot.curves.push_back(
        {"truth", colours::truth, line, [axis](const PlotSample& s) { return s.truth_px[axis]; }});
  plot.curves.push_back(
      {"detected", detected, dots, [axis](const PlotSample& s) { return s.detected_px[axis]; }});
  return plot;
}

Plot score_plot(ImU32 detected, const std::string& detector) {
  Plot plot;
  plot.title = "score";
  plot.high = 0.1;
  plot.curves = {{"threshold", colours::threshold, line, [](const PlotSample& s) { return s.threshold; }},
                 {detector, detected, dots, [](const PlotSample& s) { return s.score; }}};
  return plot;
}

Plot event_rate_plot() {
  Plot plot;
  plot.title = "events, 1000/s";
  plot.high = 10.0;
  plot.curves = {{"mean", IM_COL32(190, 190, 196, 255), mean, [](const PlotSample& s) { return s.events; }}};
  return plot;
}

Plot gaze_error_plot() {
  Plot plot;
  plot.title = "gaze error, deg";
  plot.high = 4.0;
  plot.curves = {{"error", colours::gaze, line, [](const PlotSample& s) { return s.gaze_error_deg; }},
                 {"on target", colours::dim, line, [](const PlotSample&) { return 2.0F; }}};
  return plot;
}

/// The label of a joint in the plot: short for the iCub's.
std::string label_of(const std::string& joint) {
  if (joint == "eyes_version") return "pan";
  for (const std::string_view part : {"neck_", "eyes_"}) {
    if (joint.starts_with(part)) return joint.substr(part.size());
  }
  return joint;
}

Plot joints_plot(const std::vector<std::string>& names) {
  Plot plot;
  plot.title = "joints, deg";
  plot.low = -10.0;
  plot.high = 10.0;
  constexpr std::array<ImU32, 6> colours_of_joints = {
      IM_COL32(230, 120, 110, 255), IM_COL32(200, 130, 200, 255), IM_COL32(230, 190, 90, 255),
      IM_COL32(110, 200, 130, 255), IM_COL32(100, 180, 250, 255), IM_COL32(150, 150, 230, 255)};
  for (std::size_t j = 0; j < std::min(names.size(), static_cast<std::size_t>(gaze_slots)); ++j) {
    plot.curves.push_back({label_of(names[j]), colours_of_joints[j % colours_of_joints.size()], line,
                           [j](const PlotSample& s) { return s.joints_deg[j]; }});
  }
  return plot;
}

/// The plots that have values.
std::vector<Plot> plots_of(const Snapshot& snapshot) {
  const auto has = [&](const auto& value) {
    return std::ranges::any_of(snapshot.samples,
                               [&](const PlotSample& s) { return std::isfinite(value(s)); });
  };
  const bool truth = has([](const PlotSample& s) { return s.truth_px[0]; });
  const DetectorOutput* const selected = snapshot.selected_output();
  const ImU32 detected = selected != nullptr ? colours::detector(selected->name) : colours::white;
  std::vector<Plot> plots;
  for (const std::size_t axis : {0U, 1U}) plots.push_back(position_plot(axis, snapshot, detected, truth));
  plots.push_back(score_plot(detected, selected != nullptr ? selected->name : std::string()));
  plots.push_back(event_rate_plot());
  if (has([](const PlotSample& s) { return s.gaze_error_deg; })) plots.push_back(gaze_error_plot());
  if (!snapshot.joint_names.empty()) plots.push_back(joints_plot(snapshot.joint_names));
  return plots;
}

}  // namespace

void PlotsPanel::draw(const Area& area, const Snapshot& snapshot) {
  const Panel panel("plots", area);
  const std::vector<Plot> plots = plots_of(snapshot);
  // Text over the curves.
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
    draw_plot(plots[i], {x, inside.y, width, inside.height}, snapshot, canvas, inside);
  }
  texture_.set(size, std::span(canvas.data, canvas.total() * 3));
  draw.ChannelsSetCurrent(0);
  draw_texture(texture_, inside);
  draw.ChannelsMerge();
}

}  // namespace saccade
