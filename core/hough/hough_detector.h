#pragma once

#include <cstdint>
#include <vector>

#include "core/detector_parts.h"
#include "core/detector_views.h"
#include "core/flow/plane_fit_flow.h"
#include "core/hough/event_window.h"
#include "core/hough/hough_transform.h"

namespace saccade {

/// A circular Hough transform, full or directed (the paper's two), over a window of events of any kind.
struct HoughDetectorConfig {
  bool directed = true;
  /// Looks for one radius, the middle of radius_px (rounded up), as a tracker of known particles does.
  bool single_radius = false;
  std::array<double, 2> radius_px = {10, 35};  ///< smallest and largest radius, whole numbers
  EventWindowConfig window;
  HoughTransform::Normalisation normalisation = HoughTransform::Normalisation::ring;
  double arc_deg = 10.0;    ///< half-width of an arc of directed votes
  PlaneFitFlowConfig flow;  ///< directed, or window by lifetime
  double threshold = 0.3;   ///< response (votes per ring pixel) taken for the ball
};

/// Keys: radius_px, window, normalisation, threshold; directed also: arc_deg; directed or with a window by lifetime: flow.
void describe(FieldVisitor& v, HoughDetectorConfig& config);
/// The events that the response is made of: "1500 events", "20 ms" or "lifetime".
[[nodiscard]] std::string window_text(const HoughDetectorConfig& config);

/// The detectors of the paper: a full or a directed circular Hough transform over a window of events.
///
/// Every event enters the window. In the directed detector an event without flow occupies a place and does not vote.
/// estimate() returns the exact maximum of the response over the events in the window at that instant; it is not valid
/// if no event votes. Votes are added and removed in estimate() only, so an event that enters and leaves between two
/// calls costs almost nothing.
class HoughDetector final : public Detector, public DetectorViews {
 public:
  /// Throws InputError for a configuration out of range.
  HoughDetector(const HoughDetectorConfig& config, ImageSize size);

  void process(std::span<const Event> events, const CameraMotion* motion) override;
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override;
  [[nodiscard]] Estimate estimate() override;
  [[nodiscard]] double threshold() const override { return config_.threshold; }
  [[nodiscard]] RejectedEvents rejected() const override { return sieve_.rejected(); }
  [[nodiscard]] bool hough_space(std::span<float> response) const override;
  [[nodiscard]] std::unique_ptr<Detector> copy() const override {
    return std::make_unique<HoughDetector>(*this);
  }

  /// The accumulator at the last estimate().
  [[nodiscard]] const HoughTransform& transform() const { return transform_; }

 private:
  HoughDetectorConfig config_;
  bool with_flow_;
  EventSieve sieve_;
  PlaneFitFlow flow_;
  EventWindow window_;
  HoughTransform transform_;
  std::int64_t now_us_;  // the newest of all events and advances
  Estimate estimate_;
};

}  // namespace saccade
