#include "core/tracker/decimated_detector.h"

#include <array>
#include <cstddef>

namespace saccade {
namespace {

ImageSize decimated(ImageSize size, int step) {
  const int first = step / 2;
  return {(size.width - first + step - 1) / step, (size.height - first + step - 1) / step};
}

}  // namespace

Camera decimated(const Camera& camera, int step) {
  Camera result = camera;
  result.size = decimated(camera.size, step);
  result.fx_px /= step;
  result.fy_px /= step;
  const int first = step / 2;
  result.cx_px = (camera.cx_px - first) / step;
  result.cy_px = (camera.cy_px - first) / step;
  return result;
}

DecimatedDetector::DecimatedDetector(std::unique_ptr<Detector> detector, ImageSize size, int step)
    : detector_(std::move(detector)), sieve_(size), size_(size), step_(step) {}

void DecimatedDetector::process(std::span<const Event> events, const CameraMotion* motion) {
  std::array<Event, 256> kept;
  std::size_t count = 0;
  const int first = step_ / 2;
  for (const Event& event : events) {
    if (!sieve_.accept(event) || event.x % step_ != first || event.y % step_ != first) continue;
    kept[count] = event;
    kept[count].x = static_cast<std::uint16_t>(event.x / step_);
    kept[count].y = static_cast<std::uint16_t>(event.y / step_);
    if (++count < kept.size()) continue;
    detector_->process(kept, motion);
    count = 0;
  }
  detector_->process(std::span(kept).first(count), motion);
}

void DecimatedDetector::advance_to(std::int64_t now_us, const CameraMotion* motion) {
  detector_->advance_to(now_us, motion);
}

Estimate DecimatedDetector::estimate() {
  Estimate estimate = detector_->estimate();
  const int first = step_ / 2;
  estimate.circle.x_px = estimate.circle.x_px * step_ + first;
  estimate.circle.y_px = estimate.circle.y_px * step_ + first;
  estimate.circle.r_px *= step_;
  estimate.covariance_px2 *= step_ * step_;
  return estimate;
}

std::unique_ptr<Detector> DecimatedDetector::copy() const {
  std::unique_ptr<Detector> copied = copy_of(*detector_);
  if (copied == nullptr) return nullptr;
  auto result = std::make_unique<DecimatedDetector>(std::move(copied), size_, step_);
  result->sieve_ = sieve_;
  return result;
}

}  // namespace saccade
