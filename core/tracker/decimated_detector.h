#pragma once

#include <memory>
#include <span>

#include "core/detector_parts.h"
#include "core/detector_views.h"

namespace saccade {

/// The camera of every `step`-th pixel of each row and column, the first one at step / 2.
[[nodiscard]] Camera decimated(const Camera& camera, int step);

/// Runs a detector on the events of every `step`-th pixel of each row and column. These are the events of a camera with
/// fewer and equally small pixels, for which an image of a large ball looks like that of a smaller one. Times and motions
/// stay as they are; circles and covariances of the estimate are in pixels of the whole image.
class DecimatedDetector final : public Detector, public DetectorViews {
 public:
  /// `detector`: for the camera decimated(camera, step). `step`: at least 2. `size`: of the whole image.
  DecimatedDetector(std::unique_ptr<Detector> detector, ImageSize size, int step);

  void process(std::span<const Event> events, const CameraMotion* motion) override;
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override;
  [[nodiscard]] Estimate estimate() override;
  void work_ahead() override { detector_->work_ahead(); }
  void leave_out_work_before(std::int64_t t_us) override { detector_->leave_out_work_before(t_us); }
  [[nodiscard]] double threshold() const override { return detector_->threshold(); }
  [[nodiscard]] RejectedEvents rejected() const override { return sieve_.rejected(); }
  /// Every pixel has the response of the nearest one that is used.
  /// nullptr for a detector that cannot be copied.
  [[nodiscard]] std::unique_ptr<Detector> copy() const override;

 private:
  std::unique_ptr<Detector> detector_;
  EventSieve sieve_;
  ImageSize size_;
  int step_;
};

}  // namespace saccade
