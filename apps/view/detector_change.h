#pragma once

#include <span>
#include <vector>

#include "apps/view/loop_history.h"
#include "apps/view/view_settings.h"

namespace saccade {

/// Copies in the same state; empty where one of the detectors cannot be copied. Allocates: not for the tick.
[[nodiscard]] std::vector<LoopDetector> copies(std::span<const LoopDetector> detectors);

/// The detectors after a change of settings, and their outputs at the newest tick.
struct ChangedDetectors {
  std::vector<LoopDetector> detectors;
  std::vector<DetectorOutput> outputs;
};

/// The detectors that `settings` enable. Those with the configuration that they have in `before` are copies of the
/// loop's where they can be copied; the others are new and have processed the inputs of `history`, seen through `camera` in `eye`.
/// Throws InputError for a configuration out of range.
[[nodiscard]] ChangedDetectors change_detectors(const ViewSettings& settings, const ViewSettings& before,
                                                const Loop& loop, const LoopHistory& history,
                                                const MountedCamera& camera, Eye eye);

}  // namespace saccade
