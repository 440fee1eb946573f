#pragma once

#include <cstdint>

#include "core/detector_parts.h"
#include "core/detector_views.h"
#include "core/reserved_vector.h"

namespace saccade {

/// Cluster tracker (Delbruck and Lang, Frontiers in Neuroscience 7:223, 2013), which the robot goalie follows
/// its balls with.
struct ClusterConfig {
  std::array<double, 2> radius_px = {10, 35};  ///< smallest and largest size of a cluster
  std::int64_t clusters = 20;                  ///< most at a time
  double mixing = 0.01;                        ///< weight of an event against all those before it
  double surround = 2.0;                       ///< reach of a cluster in its own radii
  double decay_us = 10'000;                    ///< time constant of its support
  double threshold = 150.0;                    ///< support, in events, taken for the ball
};

/// Keys: radius_px, clusters, mixing, surround, decay_us, threshold.
void describe(FieldVisitor& v, ClusterConfig& config);

/// The cluster tracker of Delbruck and Lang 2013, without the velocity prediction of the original.
///
/// An event is assigned to the nearest cluster within reach. It moves the centre of the cluster towards itself and the
/// radius towards the mean distance of the events (which lie on the outline), and adds 1 to its support. An event
/// without a cluster in reach starts a new one. Support decays with time; a cluster with less than half an event is
/// removed. Overlapping clusters are merged. The estimate is the cluster with the most support.
class ClusterDetector final : public Detector, public DetectorViews {
 public:
  /// Throws InputError for a configuration out of range.
  ClusterDetector(const ClusterConfig& config, ImageSize size);

  void process(std::span<const Event> events, const CameraMotion* motion) override;
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override;
  [[nodiscard]] Estimate estimate() override;
  [[nodiscard]] double threshold() const override { return config_.threshold; }
  [[nodiscard]] RejectedEvents rejected() const override { return sieve_.rejected(); }
  [[nodiscard]] std::unique_ptr<Detector> copy() const override {
    return std::make_unique<ClusterDetector>(*this);
  }

 private:
  struct Cluster {
    Circle circle;
    double support = 0.0;  // at last_us
    std::int64_t last_us = 0;
    double end_us = 0.0;  // when its support falls below the least
  };
  [[nodiscard]] double support(const Cluster& cluster, std::int64_t now_us) const;
  void add_support(Cluster& cluster, double more, std::int64_t now_us) const;
  void remove(std::size_t index);
  void take(const Event& event);
  void seed(const Event& event);
  void merge(std::size_t index);

  ClusterConfig config_;
  EventSieve sieve_;
  ReservedVector<Cluster> clusters_;
  std::int64_t now_us_;
};

}  // namespace saccade
