#pragma once

#include <cstdint>
#include <optional>

#include "evaluation/scoring/observation.h"
#include "loop/loop.h"
#include "recording/run_files.h"

namespace saccade {

/// A detector's newest estimate that is ready, tick by tick (`streaming` in docs/scoring.md). An estimate is ready in the
/// tick that made it, and it stays the newest one while events may still be on their way.
class NewestEstimate {
 public:
  struct Ready {
    Estimate estimate;
    std::int64_t about_us = 0;  ///< the instant that the estimate is about
    std::int64_t ready_us = 0;
  };

  /// After a tick. `events_until_us`: every event up to this time has been delivered.
  void update(std::int64_t t_us, const DetectorTick& result, std::int64_t events_until_us) {
    if (result.observed) {
      const bool late = !result.on_time && !result.late.empty();
      ready_ = {result.estimate, late ? result.late.back().t_us : t_us, t_us};
    } else if (events_until_us >= t_us) {
      ready_.reset();
    }
  }
  /// A detector of images: a new image replaces what was found in the last one.
  void update(std::int64_t t_us, bool image, const std::optional<Estimate>& found) {
    if (!image) return;
    ready_.reset();
    if (found) ready_ = {*found, t_us, t_us};
  }
  /// None: nothing is observed now.
  [[nodiscard]] const std::optional<Ready>& ready() const { return ready_; }

 private:
  std::optional<Ready> ready_;
};

[[nodiscard]] inline Observation observation_of(const Estimate& estimate) {
  return {estimate.circle, estimate.score, estimate.covariance_px2};
}

/// A row of detections.csv.
[[nodiscard]] inline DetectionRow detection_row(std::int64_t t_us, const std::string& detector,
                                                const Estimate& estimate) {
  return {t_us, detector, estimate.circle, estimate.score, estimate.held, estimate.covariance_px2};
}

}  // namespace saccade
