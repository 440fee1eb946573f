#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "control/locating_gate.h"

namespace saccade {

/// The gate of the authors' own demo (2016): the median of the detections of the last quarter of a second,
/// and only while they are many and agree. Detections are compared in the current image: those from before the
/// camera turned are moved to where the current image shows them. (The demo did not move them, so for a
/// quarter of a second after a saccade its median lay between two images.)
struct MedianGateConfig {
  double window_s = 0.25;
  std::int64_t min_detections = 81;  ///< in the window ("more than 80")
  double max_spread_px = 20.0;       ///< standard deviation of x and of y over the window stays below
  double max_radius_px = 16.0;       ///< the largest radius of the window is taken, clipped here
  double max_target_x_m = -0.10;     ///< root frame; a target less far in front of the waist is moved there
};

/// Keys: window_s, min_detections, max_spread_px, max_radius_px, max_target_x_m.
void describe(FieldVisitor& v, MedianGateConfig& config);

/// `authors`: the estimates at or above the threshold, except held ones, enter the window; the newest of them
/// gives a target when it lies within one standard deviation of the median, in x and in y.
class MedianGate final : public LocatingGate {
 public:
  /// Throws InputError for a configuration out of range.
  MedianGate(const MedianGateConfig& config, const TargetConfig& target);

  std::optional<Eigen::Vector3d> update(std::int64_t now_us, const Estimate& estimate, double threshold,
                                        const Camera& camera,
                                        const Eigen::Isometry3d& root_from_cam) override;

 private:
  struct Detection {
    std::int64_t t_us = 0;
    Eigen::Vector3d ray = Eigen::Vector3d::Zero();  ///< root frame, through its centre
    double r_px = 0.0;
  };
  static constexpr std::size_t capacity = 2048;  // the longest window at one detection per ms

  [[nodiscard]] const Detection& at(std::size_t i) const { return ring_[(first_ + i) % capacity]; }
  void drop_oldest();
  MedianGateConfig config_;
  std::int64_t window_us_;
  std::array<Detection, capacity> ring_{};
  std::size_t first_ = 0;
  std::size_t size_ = 0;
  std::array<double, capacity> x_px_{}, y_px_{};  // where the image of now shows them
};

}  // namespace saccade
