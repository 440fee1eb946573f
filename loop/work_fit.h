#pragma once

#include <cstdint>
#include <vector>

#include "loop/latency.h"
#include "loop/loop.h"

namespace saccade {

/// Processing of one detector in one tick.
struct WorkSample {
  std::int64_t calls = 0;
  std::int64_t events = 0;
  double elapsed_us = 0.0;
};

/// The non-negative processing times that fit the samples best (least squares). The half percent of the samples with the
/// largest remainders is left out: another process had the processor then. Zero without samples.
[[nodiscard]] WorkTime fit_work(std::vector<WorkSample> samples);

/// Collects the processing times of a run, and fits a LatencyConfig of the kind `model` to them: its detectors and
/// controller_us (the median step).
class LatencyFit final : public LoopObserver {
 public:
  /// `loop` outlives it and has no latency.
  explicit LatencyFit(const Loop& loop) : loop_(loop), samples_(loop.detectors().size()) {}

  void on_tick(const Tick& tick) override;
  [[nodiscard]] LatencyConfig latency() const;
  [[nodiscard]] const std::vector<WorkSample>& samples(std::size_t detector) const {
    return samples_[detector];
  }

 private:
  const Loop& loop_;
  std::vector<std::vector<WorkSample>> samples_;
  std::vector<double> steps_us_;
};

}  // namespace saccade
