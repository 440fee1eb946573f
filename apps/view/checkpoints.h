#pragma once

#include <cstdint>
#include <vector>

#include "apps/view/loop_history.h"

namespace saccade {

/// A state of a loop that playback can continue from.
struct Checkpoint {
  Checkpoint(LoopHistory its_history, std::vector<LoopDetector> its_detectors)
      : history(std::move(its_history)), detectors(std::move(its_detectors)) {}
  Checkpoint(Checkpoint&&) = default;
  Checkpoint& operator=(Checkpoint&&) = default;

  LoopHistory history;
  std::vector<LoopDetector> detectors;  ///< copies; empty at the start: then new ones are made
};

/// The checkpoints of a recording, sorted by time; the first is the start. When there are too many, every second one is
/// dropped and the spacing is doubled.
class Checkpoints {
 public:
  static constexpr std::int64_t first_spacing_us = 250'000;

  /// `start`: the history at the start, without ticks.
  explicit Checkpoints(const LoopHistory& start);

  /// Whether the latest checkpoint until now_us is so long ago that it is time for another one.
  [[nodiscard]] bool due(std::int64_t now_us) const;
  /// Adds one at the time of `history`, with copies of the detectors; none where one of them cannot be copied.
  void add(const LoopHistory& history, std::span<const LoopDetector> detectors);
  /// Drops all but the start.
  void clear();

  [[nodiscard]] const Checkpoint& start() const { return checkpoints_.front(); }
  /// The latest checkpoint before t_us, or the start.
  [[nodiscard]] const Checkpoint& latest_before(std::int64_t t_us) const;

  /// How many checkpoints about 256 MB can hold, at least 3 and at most 64.
  [[nodiscard]] static std::size_t limit(ImageSize image, std::size_t detectors);

 private:
  std::vector<Checkpoint> checkpoints_;
  std::int64_t spacing_us_;
};

}  // namespace saccade
