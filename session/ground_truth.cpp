#include "session/ground_truth.h"

#include <limits>

#include "emulator/event_label.h"

namespace saccade {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

GroundTruth::GroundTruth(const SimRobot& robot)
    : GroundTruth(robot.truth(), [&robot] { return robot.delivered_labels(); }) {}

TruthRow truth_row(const SimTruth& truth, const EyeTruth& eye) {
  Circle circle = eye.circle.value_or(Circle{nan, nan, nan});
  if (eye.extent) circle = {eye.extent->centre_px.x(), eye.extent->centre_px.y(), nan};
  return {truth.t_us, circle, eye.visible, truth.ball_m};
}

TargetRow target_row(const SimTruth& truth, const EyeTruth& eye) {
  const Eigen::Vector2d none = Eigen::Vector2d::Constant(nan);
  const VisibleExtent extent = eye.extent.value_or(VisibleExtent{none, none, none});
  return {truth.t_us, extent.centre_px, extent.corner_px, extent.size_px, eye.visible};
}

LabelRow label_row(const Event& event, const EventLabel& label) {
  LabelRow row;
  row.t_us = event.t_us;
  row.x = event.x;
  row.y = event.y;
  row.on = event.on;
  row.cause = event_cause_names.at(static_cast<std::size_t>(label.cause));
  row.object = scene_object_names.at(label.object - 1U);
  return row;
}

}  // namespace saccade
