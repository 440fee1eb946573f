#include "session/observations.h"

#include "session/frame_camera.h"

namespace saccade {

Observations::Observations(const Loop& loop, const GroundTruth& truth, const FrameCamera* frames,
                           const LatencyConfig& latency)
    : truth_(truth),
      frames_(frames),
      instants_(loop.detectors().size() + 2, processing_us(latency)),
      newest_(loop.detectors().size() + 2, NewestEstimate(latency.transport_us())) {}

void Observations::on_tick(const Tick& tick) {
  const std::int64_t events_until_us = truth_.state.events_until_us;
  instants_.push(tick.t_us);
  const auto add = [&](std::size_t detector, const DetectorTick& result) {
    instants_.set(detector, result);
    newest_[detector].update(tick.t_us, result, events_until_us);
  };
  for (std::size_t i = 0; i < tick.detectors.size(); ++i) add(i, tick.detectors[i]);
  if (tick.right) add(right_eye(), *tick.right);
  if (frames_ != nullptr) {
    instants_.set(frame_camera(), frames_->detection());
    newest_[frame_camera()].update(tick.t_us, frames_->ready_us(), frames_->detection());
  }
  complete(events_until_us);
}

void Observations::finish() { complete(InstantQueue::all_us); }

void Observations::complete(std::int64_t until_us) {
  count_ = 0;
  instants_.pop(until_us, [this](const InstantQueue::Instant& instant) {
    if (count_ == completed_.size()) completed_.emplace_back();
    completed_[count_++] = instant;
  });
}

}  // namespace saccade
