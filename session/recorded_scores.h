#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "evaluation/scoring/detector_scorer.h"
#include "loop/loop.h"
#include "session/observations.h"

namespace saccade {

/// Records and scores the detections of a recording against given truth, tick by tick. Memory does not grow with the
/// ticks.
class RecordedScores final : public LoopObserver {
 public:
  /// All outlive it; `truth` is sorted by time, `observations` are called before it. `table`: the file of detections; empty:
  /// none is written.
  RecordedScores(const Loop& loop, const Observations& observations, std::span<const TruthRow> truth,
                 Chances chances, const std::filesystem::path& table);

  void on_tick(const Tick& tick) override;
  /// Whether the following ticks are scoring instants (at first they are); events and time count in either case.
  void set_scoring(bool on) { scoring_ = on; }
  /// Truth after t_us does not count: what follows was not processed.
  void leave_out_truth_after(std::int64_t t_us);
  /// The truth that counts.
  [[nodiscard]] std::span<const TruthRow> truth() const { return truth_; }
  /// After the last tick: closes the table. Returns the scores in the order of the loop's detectors.
  [[nodiscard]] std::vector<DetectorScore> finish();

  [[nodiscard]] std::int64_t event_count() const { return event_count_; }
  /// Of the newest event; none before the first.
  [[nodiscard]] std::optional<std::int64_t> last_event_us() const { return last_event_us_; }

 private:
  struct Detector {
    DetectorScorer scorer;
    std::int64_t at_threshold = 0;  ///< observations at or above it
    std::int64_t elapsed_ns = 0;
  };

  /// Rows of truth before t_us, without an observation.
  void pass_truth_before(std::int64_t t_us);

  const Loop& loop_;
  const Observations& observations_;
  std::span<const TruthRow> truth_;
  std::size_t next_truth_ = 0;
  std::vector<Detector> detectors_;
  std::optional<TableWriter<DetectionRow>> table_;
  bool scoring_ = true;
  std::int64_t event_count_ = 0;
  std::optional<std::int64_t> last_event_us_;
};

}  // namespace saccade
