#include "apps/view/loop_history.h"

#include <algorithm>
#include <iterator>

#include "core/units.h"

#include "core/detector_views.h"

namespace saccade {
namespace {

std::array<float, 2> centre_of(const Circle& circle) {
  return {static_cast<float>(circle.x_px), static_cast<float>(circle.y_px)};
}

}  // namespace

LoopHistory::LoopHistory(const Camera& camera, Eye eye, std::int64_t start_us, std::int64_t end_us)
    : camera_(camera),
      eye_(static_cast<std::uint8_t>(eye)),
      start_us_(start_us),
      now_us_(start_us),
      end_us_(end_us) {}

void LoopHistory::record(const Tick& tick, const SnapshotTruth& truth, const Loop& loop,
                         std::size_t selected) {
  now_us_ = tick.t_us;
  truth_ = truth;
  phase_ = tick.phase;
  selected_ = selected;
  auto input = std::make_shared<DetectorInput>(DetectorInput{tick.t_us, {}, tick.head});
  std::ranges::copy_if(tick.events, std::back_inserter(input->events),
                       [&](const Event& event) { return event.camera == eye_; });
  outputs_.clear();
  for (std::size_t i = 0; i < tick.detectors.size(); ++i) {
    const LoopDetector& detector = loop.detectors()[i];
    outputs_.push_back({detector.name, tick.detectors[i], detector.detector->threshold()});
  }

  PlotSample sample;
  sample.t_us = tick.t_us;
  sample.events = static_cast<float>(input->events.size());
  if (truth.circle) sample.truth_px = centre_of(*truth.circle);
  if (selected < outputs_.size()) {
    const DetectorOutput& output = outputs_[selected];
    sample.threshold = static_cast<float>(output.threshold);
    if (output.tick.observed) {
      sample.score = static_cast<float>(output.tick.estimate.score);
      if (output.tick.at_threshold) sample.detected_px = centre_of(output.tick.estimate.circle);
    }
  }
  sample.gaze_error_deg = truth.gaze_error_deg;
  if (tick.head) {
    for (std::size_t j = 0; j < sample.joints_deg.size(); ++j) {
      sample.joints_deg[j] = static_cast<float>(
          deg_per_rad * tick.head->position_rad[torso_slots + static_cast<Eigen::Index>(j)]);
    }
  }
  samples_.push_back(sample);
  inputs_.push_back(std::move(input));
  while (samples_.front().t_us <= now_us_ - Snapshot::plot_us) samples_.pop_front();
  while (inputs_.front()->t_us <= now_us_ - Snapshot::events_us) inputs_.pop_front();
}

void LoopHistory::replace_outputs(std::vector<DetectorOutput> outputs, std::size_t selected) {
  outputs_ = std::move(outputs);
  selected_ = selected;
}

void LoopHistory::fill(Snapshot& snapshot, const Loop& loop) const {
  snapshot.start_us = start_us_;
  snapshot.now_us = now_us_;
  snapshot.end_us = end_us_;
  snapshot.camera = camera_;
  snapshot.events.clear();
  for (const auto& input : inputs_)
    snapshot.events.insert(snapshot.events.end(), input->events.begin(), input->events.end());
  snapshot.outputs = outputs_;
  for (DetectorOutput& output : snapshot.outputs) {
    const auto detector = std::ranges::find(loop.detectors(), output.name, &LoopDetector::name);
    if (detector != loop.detectors().end()) output.failure = detector->detector->failure();
  }
  snapshot.selected = selected_;
  snapshot.truth = truth_;
  snapshot.phase = phase_;
  snapshot.samples.assign(samples_.begin(), samples_.end());
  snapshot.joint_names.clear();
  if (!samples_.empty() && std::isfinite(samples_.back().joints_deg[0])) {
    for (int slot = torso_slots; slot < torso_slots + loop.head()->gaze_joints(); ++slot)
      snapshot.joint_names.emplace_back(loop.head()->name_of(slot));
  }
  snapshot.hough.resize(static_cast<std::size_t>(camera_.size.pixels()));
  if (selected_ >= loop.detectors().size() ||
      !hough_space_of(*loop.detectors()[selected_].detector, snapshot.hough))
    snapshot.hough.clear();
}

}  // namespace saccade
