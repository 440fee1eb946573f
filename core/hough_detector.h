#pragma once

#include <cstdint>
#include <vector>

#include "core/detector.h"
#include "core/hough_transform.h"
#include "core/plane_fit_flow.h"

namespace saccade {

/// The paper's two detectors: the full and the directed Hough transform over the last N events.
struct HoughDetectorConfig {
  bool directed = true;
  std::vector<double> radius_px = {10, 35};  ///< smallest and largest radius, whole numbers
  std::int64_t window_events = 1500;
  double arc_deg = 10.0;    ///< half-width of an arc of directed votes
  PlaneFitFlowConfig flow;  ///< directed only
  double threshold = 0.0;   ///< response (votes per ring pixel) taken for the ball
};

/// Keys: radius_px, window.events, threshold; directed also: arc_deg, flow.
void describe(FieldVisitor& v, HoughDetectorConfig& config);

/// Every event enters the window; the oldest leaves when it is full. An event without flow enters the window
/// of the directed detector as well, and does not vote. The estimate is the true maximum of the response over
/// the window at the asked instant, exactly as if every event had been voted when it came: votes are cast
/// when an estimate is asked for, so that events that came and went in between cost next to nothing.
class HoughDetector final : public Detector {
 public:
  /// Throws InputError for a configuration out of range.
  HoughDetector(const HoughDetectorConfig& config, ImageSize size);

  void process(std::span<const Event> events, const CameraMotion* motion) override;
  void advance_to(std::int64_t, const CameraMotion*) override {}
  [[nodiscard]] Estimate estimate() override;
  [[nodiscard]] double threshold() const override { return config_.threshold; }
  [[nodiscard]] RejectedEvents rejected() const override { return rejected_; }

  /// The accumulator as of the last estimate().
  [[nodiscard]] const HoughTransform& transform() const { return transform_; }

 private:
  struct Entry {
    std::uint16_t x, y;
    std::int16_t direction;  // of the flow; -1: full ring; -2: no vote
  };
  [[nodiscard]] std::int64_t count_acceptable(std::span<const Event> events) const;
  template <int sign>
  void vote(const Entry& entry);
  [[nodiscard]] Entry& entry(std::int64_t number) {
    return ring_[static_cast<std::size_t>(number % static_cast<std::int64_t>(ring_.size()))];
  }

  HoughDetectorConfig config_;
  ImageSize size_;
  PlaneFitFlow flow_;
  HoughTransform transform_;
  std::vector<Entry> ring_;       // the newest 2 N events: those voted last time can still be taken out
  std::int64_t received_ = 0;     // events accepted so far
  std::int64_t voted_until_ = 0;  // the accumulator holds events [voted_until_ - N, voted_until_)
  std::int64_t newest_us_;
  RejectedEvents rejected_;
  Estimate estimate_;
};

}  // namespace saccade
