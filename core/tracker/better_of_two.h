#pragma once

#include <memory>
#include <utility>

#include "core/detector_views.h"

namespace saccade {

/// Two detectors that see the same events, such as one for small and one for large balls. The estimate is that of the higher
/// score, so both need scores of one scale; threshold and rejected events are those of the first.
class BetterOfTwo final : public Detector, public DetectorViews {
 public:
  BetterOfTwo(std::unique_ptr<Detector> first, std::unique_ptr<Detector> second)
      : first_(std::move(first)), second_(std::move(second)) {}

  void process(std::span<const Event> events, const CameraMotion* motion) override {
    first_->process(events, motion);
    second_->process(events, motion);
  }
  void advance_to(std::int64_t now_us, const CameraMotion* motion) override {
    first_->advance_to(now_us, motion);
    second_->advance_to(now_us, motion);
  }
  [[nodiscard]] Estimate estimate() override {
    const Estimate first = first_->estimate();
    const Estimate second = second_->estimate();
    if (!first.valid || !second.valid) return first.valid ? first : second;
    return first.score >= second.score ? first : second;
  }
  void work_ahead() override {
    first_->work_ahead();
    second_->work_ahead();
  }
  void leave_out_work_before(std::int64_t t_us) override {
    first_->leave_out_work_before(t_us);
    second_->leave_out_work_before(t_us);
  }
  [[nodiscard]] double threshold() const override { return first_->threshold(); }
  [[nodiscard]] RejectedEvents rejected() const override { return first_->rejected(); }
  /// nullptr unless both can be copied.
  [[nodiscard]] std::unique_ptr<Detector> copy() const override {
    std::unique_ptr<Detector> first = copy_of(*first_), second = copy_of(*second_);
    if (first == nullptr || second == nullptr) return nullptr;
    return std::make_unique<BetterOfTwo>(std::move(first), std::move(second));
  }

 private:
  std::unique_ptr<Detector> first_, second_;
};

}  // namespace saccade
