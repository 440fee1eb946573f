#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "apps/view/snapshot.h"

namespace saccade {

/// The last seconds of a loop: inputs and outputs of the detectors and the samples of the plots. Its memory is bounded;
/// a copy is cheap, since copies share the inputs.
class LoopHistory {
 public:
  /// `eye`: the eye that the detectors see through. Times in us, in the clock of the events.
  LoopHistory(const Camera& camera, Eye eye, std::int64_t start_us, std::int64_t end_us);

  /// The same without ticks, before the first tick after t_us. Only for a history that has none.
  void begin_at(std::int64_t t_us) { now_us_ = t_us; }
  /// Adds a tick. `selected` is an index of the loop's detectors.
  void record(const Tick& tick, const SnapshotTruth& truth, const Loop& loop, std::size_t selected);
  /// Replaces the outputs of the newest tick, after the detectors have been changed.
  void replace_outputs(std::vector<DetectorOutput> outputs, std::size_t selected);
  /// Fills all of a snapshot but grey, model, scene, playing, seeking, speed, request and problem.
  void fill(Snapshot& snapshot, const Loop& loop) const;

  /// The input of the detectors in one tick.
  struct DetectorInput {
    std::int64_t t_us = 0;
    std::vector<Event> events;
    std::optional<HeadState> head;
  };
  using DetectorInputs = std::deque<std::shared_ptr<const DetectorInput>>;
  /// The inputs of the last Snapshot::events_us.
  [[nodiscard]] const DetectorInputs& inputs() const { return inputs_; }
  [[nodiscard]] std::span<const DetectorOutput> outputs() const { return outputs_; }
  [[nodiscard]] ImageSize image_size() const { return camera_.size; }
  [[nodiscard]] std::int64_t now_us() const { return now_us_; }
  [[nodiscard]] std::int64_t start_us() const { return start_us_; }
  [[nodiscard]] std::int64_t end_us() const { return end_us_; }

 private:
  Camera camera_;
  std::uint8_t eye_;
  std::int64_t start_us_, now_us_, end_us_;
  DetectorInputs inputs_;
  std::deque<PlotSample> samples_;
  std::vector<DetectorOutput> outputs_;
  std::size_t selected_ = 0;
  SnapshotTruth truth_;
  GazePhase phase_ = GazePhase::none;
};

}  // namespace saccade
