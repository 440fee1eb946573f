#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "config/scenario.h"
#include "evaluation/scoring/clutter.h"
#include "evaluation/scoring/detector_scorer.h"
#include "evaluation/scoring/eye_movement_score.h"
#include "evaluation/scoring/gaze_scorer.h"
#include "evaluation/scoring/metrics.h"
#include "loop/loop.h"
#include "session/ground_truth.h"
#include "session/observations.h"

namespace saccade {

class FrameCamera;

/// Scores detectors and gaze of a simulated run against ground truth, tick by tick, in bounded memory. Detectors are
/// scored by event time, an instant when all of its events have been delivered, and with the newest estimate that is ready
/// (`streaming`).
class RunScores final : public LoopObserver {
 public:
  /// `limits`: of the head. All others outlive it; `observations` are called before it. `frames` may be null.
  RunScores(const Scenario& scenario, const GroundTruth& truth, const JointLimits& limits, const Loop& loop,
            const Observations& observations, const FrameCamera* frames);

  void on_tick(const Tick& tick) override;
  /// The angle between the left eye's axis and the ball at the newest tick.
  [[nodiscard]] double fixation_error_rad() const { return gaze_.fixation_error_rad(); }
  /// Everything in metrics.json that follows from the ticks; after the observations have finished.
  [[nodiscard]] Metrics metrics();

 private:
  struct Detector {
    Detector(std::string its_name, double its_threshold, std::size_t its_number)
        : name(std::move(its_name)),
          number(its_number),
          scorer(name, its_threshold, Chances::simulated),
          streaming(its_threshold) {}

    std::string name;
    std::size_t number;  // in the observations
    DetectorScorer scorer;
    StreamingScorer streaming;
    ChanceClutter clutter;
    std::int64_t elapsed_ns = 0;
    std::int64_t work_us = 0;  // these two with a latency
    std::int64_t events_left_out = 0;
  };
  struct RightEye {
    explicit RightEye(const GazeScoringConfig& scoring) : gaze(scoring) {}

    GazeScorer gaze;
    std::optional<Detector> detector;
    std::int64_t event_count = 0;
  };

  /// What an instant is scored with.
  struct Context {
    TruthRow truth;
    TruthRow right_truth;
    std::optional<std::int64_t> held_since_us;  // by the gaze
    double clutter_share = 0.0;                 // in the window of clutter_
  };

  /// Returns whether the detector found the ball; none where the instant is no chance.
  std::optional<bool> score(Detector& detector, const TruthRow& truth, const std::optional<Estimate>& seen,
                            double clutter_share);
  void score_completed();
  static void count_work(Detector& detector, std::int64_t t_us, const DetectorTick& result);
  [[nodiscard]] LatencyMetrics latency_metrics() const;
  void score_newest(Detector& detector, const TruthRow& truth) const;
  void count_labels(std::span<const Event> events);
  void look_at_right_eye(const Tick& tick);
  void add_eye_movement(std::int64_t t_us);
  [[nodiscard]] DetectorScore finished(const Detector& detector, std::int64_t events,
                                       const saccade::Detector* in_loop) const;
  [[nodiscard]] GazeMetrics gaze_metrics() const;
  [[nodiscard]] RightEyeMetrics right_eye_metrics() const;

  const Scenario& scenario_;
  const GroundTruth& truth_;
  JointLimits limits_;
  const Loop& loop_;
  const Observations& observations_;
  std::vector<Detector> detectors_;  // in the order of the loop's
  std::optional<Detector> frame_detector_;
  std::optional<std::size_t> driver_;  // index of the one that drives the gaze
  GazeScorer gaze_;
  std::optional<EyeMovementScorer> eye_movements_;
  std::optional<JointVector> first_rad_;  // joints at the first tick
  FollowingRate following_;
  ClutterCounter clutter_;
  std::deque<Context> contexts_;  // of the instants that are not complete
  std::optional<RightEye> right_eye_;
  std::int64_t event_count_ = 0;  // of both eyes
  std::int64_t now_us_ = 0;
};

}  // namespace saccade
