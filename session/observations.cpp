#include "session/observations.h"

#include "session/frame_camera.h"

namespace saccade {

Observations::Observations(const Loop& loop) {
  for (const LoopDetector& detector : loop.detectors()) names_.push_back(detector.name);
  names_.emplace_back();  // the right eye's are in a table of their own
  names_.emplace_back(frame_detector_name);
}

Observations::Observations(const Loop& loop, const GroundTruth& truth, const FrameCamera* frames,
                           const LatencyConfig& latency)
    : Observations(loop) {
  event_time_.emplace(
      EventTime{truth, frames, ReorderBuffer(names_.size(), processing_us(latency)),
                std::vector<NewestEstimate>(names_.size(), NewestEstimate(latency.transport_us()))});
}

void Observations::on_tick(const Tick& tick) {
  if (event_time_) {
    add_to_event_time(tick);
  } else {
    add_instant(tick);
  }
}

void Observations::add_instant(const Tick& tick) {
  count_ = 0;
  ObservedInstant& instant = next_completed();
  instant.t_us = tick.t_us;
  instant.observations.assign(names_.size(), std::nullopt);
  const auto add = [&](std::size_t detector, const DetectorTick& result) {
    if (result.observed) instant.observations[detector] = result.estimate;
  };
  for (std::size_t i = 0; i < tick.detectors.size(); ++i) add(i, tick.detectors[i]);
  if (tick.right) add(right_eye(), *tick.right);
}

void Observations::add_to_event_time(const Tick& tick) {
  EventTime& to = *event_time_;
  const std::int64_t events_until_us = to.truth.state.events_until_us;
  to.instants.push(tick.t_us);
  const auto add = [&](std::size_t detector, const DetectorTick& result) {
    to.instants.set(detector, result);
    to.newest[detector].update(tick.t_us, result, events_until_us);
  };
  for (std::size_t i = 0; i < tick.detectors.size(); ++i) add(i, tick.detectors[i]);
  if (tick.right) add(right_eye(), *tick.right);
  if (to.frames != nullptr) {
    to.instants.set(frame_camera(), to.frames->detection());
    to.newest[frame_camera()].update(tick.t_us, to.frames->ready_us(), to.frames->detection());
  }
  complete(events_until_us);
}

void Observations::finish() {
  count_ = 0;
  if (event_time_) complete(ReorderBuffer::all_us);
}

void Observations::complete(std::int64_t until_us) {
  count_ = 0;
  event_time_->instants.pop(until_us, [this](const ObservedInstant& instant) { next_completed() = instant; });
}

ObservedInstant& Observations::next_completed() {
  if (count_ == completed_.size()) completed_.emplace_back();
  return completed_[count_++];
}

void Observations::write_completed(TableWriter<DetectionRow>& table) const {
  for (const ObservedInstant& instant : completed()) {
    for (std::size_t i = 0; i < names_.size(); ++i) {
      const auto& seen = instant.observations[i];
      if (seen && i != right_eye()) table.write(detection_row(instant.t_us, names_[i], *seen));
    }
  }
}

}  // namespace saccade
