#pragma once

#include <memory>
#include <span>

#include "core/detector.h"

namespace saccade {

/// What a window and a report need of a detector beyond its estimates. A detector may implement it beside Detector;
/// without it the window shows no Hough space and plays a recording again from its start to go back in time. No function
/// is for the tick: all may allocate.
class DetectorViews {
 public:
  virtual ~DetectorViews() = default;

  /// Writes the largest response over all radii at each pixel as of the last estimate(), row by row. `response` has one
  /// element per pixel. Returns false, and writes nothing, for a detector without a Hough space.
  [[nodiscard]] virtual bool hough_space(std::span<float> /*response*/) const { return false; }
  /// A detector in the same state: both give the same estimates from the same input.
  [[nodiscard]] virtual std::unique_ptr<Detector> copy() const = 0;
};

/// DetectorViews::hough_space; false as well for a detector without DetectorViews.
[[nodiscard]] inline bool hough_space_of(const Detector& detector, std::span<float> response) {
  const auto* const views = dynamic_cast<const DetectorViews*>(&detector);
  return views != nullptr && views->hough_space(response);
}

[[nodiscard]] inline bool can_be_copied(const Detector& detector) {
  return dynamic_cast<const DetectorViews*>(&detector) != nullptr;
}

/// DetectorViews::copy; nullptr for a detector without DetectorViews.
[[nodiscard]] inline std::unique_ptr<Detector> copy_of(const Detector& detector) {
  const auto* const views = dynamic_cast<const DetectorViews*>(&detector);
  return views != nullptr ? views->copy() : nullptr;
}

}  // namespace saccade
