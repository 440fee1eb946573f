#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/config.h"
#include "core/detector.h"
#include "core/detector_parts.h"

namespace example {

/// The centroid of the newest events. The keys of this struct are in describe().
struct CentroidConfig {
  std::int64_t events = 300;  ///< number of events that the estimate is made of
  double threshold = 0.6;     ///< score at and above which the circle is taken for the ball
};

void describe(saccade::FieldVisitor& v, CentroidConfig& config);
/// The events that the estimate is made of, for reports: "300 events".
std::string window_text(const CentroidConfig& config);

/// A ball alone in the image: its outline makes all events. The centre is their mean position, the radius their mean
/// distance from it, the score 1 - (standard deviation of the distance) / radius, and at least 0.
class CentroidDetector final : public saccade::Detector {
 public:
  /// Throws InputError for a configuration out of range.
  CentroidDetector(const CentroidConfig& config, saccade::ImageSize size);

  void process(std::span<const saccade::Event> events, const saccade::CameraMotion* motion) override;
  void advance_to(std::int64_t, const saccade::CameraMotion*) override {}
  saccade::Estimate estimate() override;
  double threshold() const override { return config_.threshold; }
  saccade::RejectedEvents rejected() const override { return sieve_.rejected(); }

 private:
  struct Position {
    double x_px, y_px;
  };

  CentroidConfig config_;
  saccade::EventSieve sieve_;  // leaves out events outside the image or back in time, and counts them
  std::vector<Position> newest_;
  std::size_t count_ = 0;  // events so far
};

}  // namespace example
