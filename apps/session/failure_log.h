#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "loop/loop.h"

namespace saccade {

/// A message for each detector that ends during a run (Detector::failure()), in the tick in which it does.
class FailureLog final : public LoopObserver {
 public:
  using Sink = std::function<void(std::int64_t t_us, const std::string& text)>;

  /// `loop` outlives it.
  FailureLog(const Loop& loop, Sink sink)
      : loop_(loop), sink_(std::move(sink)), ended_(loop.detectors().size()) {}

  void on_tick(const Tick& tick) override {
    const std::span<const LoopDetector> detectors = loop_.detectors();
    for (std::size_t i = 0; i < ended_.size(); ++i) {
      if (ended_[i] || detectors[i].detector->failure().empty()) continue;
      ended_[i] = true;
      sink_(tick.t_us,
            "detector " + detectors[i].name + ": " + std::string(detectors[i].detector->failure()));
    }
  }

 private:
  const Loop& loop_;
  Sink sink_;
  std::vector<bool> ended_;
};

}  // namespace saccade
