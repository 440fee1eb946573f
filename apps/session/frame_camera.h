#pragma once

#include <optional>

#include "evaluation/frame_camera/frame_detector.h"
#include "loop/loop.h"
#include "sim/sim_robot.h"

namespace saccade {

/// The conventional camera of a simulated run, in the place of the left eye, and its ball detector (`frame_30hz`): an
/// observer that exposes images and detects the ball in each. It compares; nothing else in the run depends on it.
class FrameCamera final : public LoopObserver {
 public:
  /// `camera`: the left eye's. `robot` outlives it.
  FrameCamera(const FrameDetectorConfig& config, const SimConfig& sim, SimRobot& robot);

  void on_tick(const Tick& tick) override;
  /// The ball in the image that ended in this tick; none without an image or a ball.
  [[nodiscard]] const std::optional<Estimate>& detection() const { return detection_; }
  /// Whether an image ended in this tick.
  [[nodiscard]] bool exposed() const { return exposed_; }
  [[nodiscard]] double threshold() const { return detector_.threshold(); }
  /// Wall-clock time spent here, s.
  [[nodiscard]] double wall_s() const { return wall_s_; }

 private:
  FrameDetector detector_;
  Shutter shutter_;
  SimRobot& robot_;
  std::optional<Estimate> detection_;
  bool exposed_ = false;
  double wall_s_ = 0.0;
};

}  // namespace saccade
