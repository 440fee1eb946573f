#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "loop/loop.h"

namespace saccade {

/// A message for each detector and for each gaze controller that ends during a run (Detector::failure()), in the tick in
/// which it does.
class FailureLog final : public LoopObserver {
 public:
  /// `what`: "detector mine" or "gaze controller".
  using Sink = std::function<void(std::int64_t t_us, const std::string& what, const std::string& why)>;

  /// `loop` outlives it.
  FailureLog(const Loop& loop, Sink sink)
      : loop_(loop), sink_(std::move(sink)), ended_(loop.detectors().size()) {}

  void on_tick(const Tick& tick) override {
    const std::span<const LoopDetector> detectors = loop_.detectors();
    for (std::size_t i = 0; i < ended_.size(); ++i) {
      if (ended_[i] || detectors[i].detector->failure().empty()) continue;
      ended_[i] = true;
      sink_(tick.t_us, "detector " + detectors[i].name, std::string(detectors[i].detector->failure()));
    }
    const GazeController* const controller = loop_.controller();
    const bool has_ended = controller != nullptr && !controller->failure().empty();
    if (has_ended && !controller_ended_)
      sink_(tick.t_us, "gaze controller", std::string(controller->failure()));
    controller_ended_ = has_ended;  // the next activation has a controller of its own
  }

 private:
  const Loop& loop_;
  Sink sink_;
  std::vector<bool> ended_;
  bool controller_ended_ = false;
};

}  // namespace saccade
