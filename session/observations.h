#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "loop/loop.h"
#include "recording/run_files.h"
#include "session/ground_truth.h"
#include "session/newest_estimate.h"
#include "session/reorder_buffer.h"

namespace saccade {

class FrameCamera;

/// What the detectors of a loop observe (docs/scoring.md). Made once per run: tables, scores, streaming, the record of a
/// robot's run and Python read it. Detectors are numbered: the loop's in their order, then the right eye's, then the frame
/// camera's.
class Observations final : public LoopObserver {
 public:
  /// Each tick is an instant, with the estimates at its end: for recordings and robots. `loop` outlives it.
  explicit Observations(const Loop& loop);
  /// Instants of event time, completed when all of their events have been delivered, and the newest estimate that is ready
  /// at each tick: for simulated runs. All outlive it. `frames` is called before it and may be null.
  Observations(const Loop& loop, const GroundTruth& truth, const FrameCamera* frames,
               const LatencyConfig& latency);

  [[nodiscard]] std::size_t right_eye() const { return names_.size() - 2; }
  [[nodiscard]] std::size_t frame_camera() const { return names_.size() - 1; }

  /// Before the observers that read it.
  void on_tick(const Tick& tick) override;
  /// After the last tick: completes the instants that still wait for events.
  void finish();

  /// The instants that the last call of on_tick() or finish() completed, in the order of time.
  [[nodiscard]] std::span<const ObservedInstant> completed() const { return {completed_.data(), count_}; }
  /// Writes their rows of detections.csv, those of all detectors but the right eye's.
  void write_completed(TableWriter<DetectionRow>& table) const;
  /// A detector's newest estimate that is ready; none: it observes nothing now. Only of a simulated run.
  [[nodiscard]] const std::optional<NewestEstimate::Ready>& newest(std::size_t detector) const {
    return event_time_->newest[detector].ready();
  }

 private:
  struct EventTime {
    const GroundTruth& truth;
    const FrameCamera* frames;
    ReorderBuffer instants;
    std::vector<NewestEstimate> newest;
  };

  void add_instant(const Tick& tick);
  void add_to_event_time(const Tick& tick);
  void complete(std::int64_t until_us);
  ObservedInstant& next_completed();

  std::vector<std::string> names_;  // by number
  std::optional<EventTime> event_time_;
  std::vector<ObservedInstant> completed_;  // the first count_ of them
  std::size_t count_ = 0;
};

}  // namespace saccade
