#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "evaluation/scoring/observation.h"
#include "loop/loop.h"
#include "recording/run_files.h"

namespace saccade {

/// A detector's newest estimate that is ready, tick by tick (`streaming` in docs/scoring.md). An estimate stays the newest
/// one until the next result is ready, and while events may still be on their way.
class NewestEstimate {
 public:
  struct Ready {
    Estimate estimate;
    std::int64_t about_us = 0;  ///< the instant that the estimate is about
    std::int64_t ready_us = 0;
  };

  /// `transport_us`: delay of the events, of the scenario's latency.
  explicit NewestEstimate(std::int64_t transport_us = 0) : transport_us_(transport_us) {
    results_.reserve(128);
  }

  /// After a tick. `events_until_us`: the simulator has made every event up to this time.
  void update(std::int64_t t_us, const DetectorTick& result, std::int64_t events_until_us) {
    for (const LateEstimate& late : result.late) add({late.estimate, late.t_us, late.ready_us});
    if (result.observed) {
      const bool late = !result.on_time && !result.late.empty();
      add({result.estimate, late ? result.late.back().t_us : t_us, ready_us(t_us, result)});
    } else if (!result.busy && events_until_us >= t_us - transport_us_) {
      results_.push_back({std::nullopt, ready_us(t_us, result)});
    }
    take_ready(t_us);
  }
  /// A detector of images. `image_ready_us`: when the result of the image of this tick is ready; none without one.
  void update(std::int64_t t_us, const std::optional<std::int64_t>& image_ready_us,
              const std::optional<Estimate>& found) {
    if (image_ready_us && found) add({*found, t_us, *image_ready_us});
    if (image_ready_us && !found) results_.push_back({std::nullopt, *image_ready_us});
    take_ready(t_us);
  }
  /// None: nothing is observed now.
  [[nodiscard]] const std::optional<Ready>& ready() const { return ready_; }

 private:
  struct Result {
    std::optional<Ready> estimate;  ///< none: nothing observed
    std::int64_t ready_us = 0;
  };

  /// A tick that is made without a loop has no time of its own in its result.
  static std::int64_t ready_us(std::int64_t t_us, const DetectorTick& result) {
    return result.ready_us > t_us ? result.ready_us : t_us;
  }
  void add(const Ready& estimate) { results_.push_back({estimate, estimate.ready_us}); }
  void take_ready(std::int64_t t_us) {
    auto next = results_.begin();
    for (; next != results_.end() && next->ready_us <= t_us; ++next) ready_ = next->estimate;
    results_.erase(results_.begin(), next);
  }

  std::int64_t transport_us_;
  std::vector<Result> results_;  // not ready yet, by time
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
