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
  /// `robot` outlives it. Images arrive and are processed with the latency; one that arrives while the detector is busy is
  /// not processed.
  FrameCamera(const FrameDetectorConfig& config, const SimConfig& sim, const LatencyConfig& latency,
              SimRobot& robot);

  void on_tick(const Tick& tick) override;
  /// The ball in the image that ended in this tick; none without an image or a ball.
  [[nodiscard]] const std::optional<Estimate>& detection() const { return detection_; }
  /// When the result of the image that ended in this tick is ready; none without an image, or if it is not processed.
  [[nodiscard]] const std::optional<std::int64_t>& ready_us() const { return ready_us_; }
  /// Time that the detector took for the image of this tick.
  [[nodiscard]] std::int64_t find_ns() const { return find_ns_; }
  [[nodiscard]] double threshold() const { return detector_.threshold(); }
  /// Wall-clock time spent here, s.
  [[nodiscard]] double wall_s() const { return wall_s_; }

 private:
  /// When the result of an image that ended at t_us is ready; none if the detector is busy.
  [[nodiscard]] std::optional<std::int64_t> process(std::int64_t t_us);

  FrameDetector detector_;
  Shutter shutter_;
  SimRobot& robot_;
  std::optional<Estimate> detection_;
  LatencyConfig latency_;
  std::optional<std::int64_t> ready_us_;
  std::int64_t free_us_ = 0;  // with a latency the detector is busy until then
  std::int64_t find_ns_ = 0;
  double wall_s_ = 0.0;
};

}  // namespace saccade
