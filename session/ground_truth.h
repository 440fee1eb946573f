#pragma once

#include <functional>
#include <span>

#include "core/event.h"
#include "recording/run_files.h"
#include "sim/sim_robot.h"

namespace saccade {

/// The simulator's ground truth as recorders and scores read it after each tick.
struct GroundTruth {
  /// Of `robot`, which outlives it.
  explicit GroundTruth(const SimRobot& robot);
  GroundTruth(const SimTruth& of_state, std::function<std::span<const EventLabel>()> of_labels)
      : state(of_state), labels(std::move(of_labels)) {}

  const SimTruth& state;                                ///< at the newest tick
  std::function<std::span<const EventLabel>()> labels;  ///< of the tick's events, in their order
};

/// The target in an eye's image as a row of truth.csv; one that is no sphere has a centre and no radius (NaN).
[[nodiscard]] TruthRow truth_row(const SimTruth& truth, const EyeTruth& eye);
/// A target that is no sphere as a row of target.csv.
[[nodiscard]] TargetRow target_row(const SimTruth& truth, const EyeTruth& eye);
/// An event's label as a row of labels.csv.
[[nodiscard]] LabelRow label_row(const Event& event, const EventLabel& label);

}  // namespace saccade
