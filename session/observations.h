#pragma once

#include <span>
#include <vector>

#include "loop/loop.h"
#include "session/ground_truth.h"
#include "session/instant_queue.h"
#include "session/newest_estimate.h"

namespace saccade {

class FrameCamera;

/// What the detectors of a simulated run observe (docs/scoring.md): by event time, an instant when all of its events have been
/// delivered, and the newest estimate that is ready at each tick. Made once; tables, scores and others read it. Detectors are
/// numbered: the loop's in their order, then the right eye's, then the frame camera's.
class Observations final : public LoopObserver {
 public:
  /// All outlive it. `frames` is called before it and may be null.
  Observations(const Loop& loop, const GroundTruth& truth, const FrameCamera* frames,
               const LatencyConfig& latency);

  [[nodiscard]] std::size_t right_eye() const { return newest_.size() - 2; }
  [[nodiscard]] std::size_t frame_camera() const { return newest_.size() - 1; }

  /// Before the observers that read it.
  void on_tick(const Tick& tick) override;
  /// After the last tick: completes the instants that still wait for events.
  void finish();

  /// The instants that the last call of on_tick() or finish() completed, in the order of time.
  [[nodiscard]] std::span<const InstantQueue::Instant> completed() const {
    return {completed_.data(), count_};
  }
  /// A detector's newest estimate that is ready; none: it observes nothing now.
  [[nodiscard]] const std::optional<NewestEstimate::Ready>& newest(std::size_t detector) const {
    return newest_[detector].ready();
  }

 private:
  void complete(std::int64_t until_us);

  const GroundTruth& truth_;
  const FrameCamera* frames_;
  InstantQueue instants_;
  std::vector<NewestEstimate> newest_;
  std::vector<InstantQueue::Instant> completed_;  // the first count_ of them
  std::size_t count_ = 0;
};

}  // namespace saccade
