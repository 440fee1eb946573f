#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "config/scenario.h"
#include "evaluation/scoring/metrics.h"
#include "loop/loop.h"

namespace saccade {

/// Measures detectors by the time for which they have the processor. Other than the wall clock it does not count the time
/// in which other programs run. A detector in a program of its own is measured by the wall clock, its answers included.
class ProcessorTimes {
 public:
  /// Wraps the detectors of a scenario that run in this process. They must not outlive this object.
  void measure(const Scenario& scenario, std::vector<LoopDetector>& detectors);
  /// Replaces `us_per_event` of the measured detectors.
  void replace_costs(Metrics& metrics) const;

 private:
  struct Time {
    std::string detector;
    std::int64_t ns = 0;
  };
  std::vector<std::unique_ptr<Time>> times_;
};

}  // namespace saccade
