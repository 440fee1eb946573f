#pragma once

#include <cstdint>
#include <vector>

#include "core/detector_parts.h"
#include "core/detector_views.h"

namespace saccade {

/// Multi-kernel tracker (Lagorce et al., TNNLS 26(8), 2015) with rings as the kernels.
struct MultiKernelConfig {
  std::array<double, 2> radius_px = {10, 35};  ///< smallest and largest radius
  double radius_step_px = 2.0;                 ///< from one kernel of a tracker to the next
  double ring_px = 3.0;                        ///< half-width of a ring
  double spacing_px = 25.0;                    ///< between the homes of trackers, on a grid over the image
  double pull = 0.05;                          ///< part of its distance to the ring that an event moves it by
  double decay_us = 20'000;                    ///< time constant of activity
  double threshold = 10.0;                     ///< activity taken for the ball
};

/// Keys: radius_px, radius_step_px, ring_px, spacing_px, pull, decay_us, threshold.
void describe(FieldVisitor& v, MultiKernelConfig& config);

/// The multi-kernel tracker of Lagorce et al. 2015 with ring-shaped kernels.
///
/// Trackers start at fixed positions on a grid. Each has one kernel per radius: a positive ring with negative flanks, of
/// zero mean and unit energy. Every event adds the value of the kernel at its place to the activity of the kernel;
/// activity decays with time. An event moves one tracker towards its ring: the most active of those whose best ring is
/// near. A tracker returns to its grid position if its activity is too low or a more active tracker is close. The
/// estimate is the most active kernel.
class MultiKernelDetector final : public Detector, public DetectorViews {
 public:
  /// Throws InputError for a configuration out of range.
  MultiKernelDetector(const MultiKernelConfig& config, ImageSize size);

  void process(std::span<const Event> events, const CameraMotion* motion) override;
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override;
  [[nodiscard]] Estimate estimate() override;
  [[nodiscard]] double threshold() const override { return config_.threshold; }
  [[nodiscard]] RejectedEvents rejected() const override { return sieve_.rejected(); }
  [[nodiscard]] std::unique_ptr<Detector> copy() const override {
    return std::make_unique<MultiKernelDetector>(*this);
  }

 private:
  struct Tracker {
    double home_x_px = 0.0, home_y_px = 0.0;
    double x_px = 0.0, y_px = 0.0;
    double most = 0.0;  // activity of the most active kernel
  };
  [[nodiscard]] std::span<double> activity(std::size_t tracker) {
    return std::span(activity_).subspan(tracker * radii_px_.size(), radii_px_.size());
  }
  [[nodiscard]] double best_radius_px(std::size_t tracker);
  static void return_to_grid(Tracker& tracker);
  void excite(std::size_t tracker, const Event& event, double fading);
  [[nodiscard]] double response(std::size_t tracker, const Event& event);
  void move(std::size_t tracker, double response, const Event& event);

  MultiKernelConfig config_;
  EventSieve sieve_;
  std::vector<double> radii_px_;
  double kernels_per_px_ = 0.0;
  std::size_t values_per_kernel_ = 0;
  std::vector<double> values_;  // of the kernel of each radius, in steps of 1/8 px from it
  double reach_px_ = 0.0;       // from a ring, beyond which its kernel has no value
  std::vector<Tracker> trackers_;
  std::vector<double> activity_;  // of the kernels of each tracker, as of last_us_
  std::int64_t last_us_, now_us_;
};

}  // namespace saccade
