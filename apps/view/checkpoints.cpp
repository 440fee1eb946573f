#include "apps/view/checkpoints.h"

#include <algorithm>

#include "apps/view/detector_change.h"

namespace saccade {
namespace {

constexpr std::int64_t memory_bytes = 256 << 20;
constexpr std::int64_t bytes_per_pixel = 90;  ///< of a detector, about

}  // namespace

Checkpoints::Checkpoints(const LoopHistory& start) : spacing_us_(first_spacing_us) {
  checkpoints_.emplace_back(start, std::vector<LoopDetector>{});
}

bool Checkpoints::due(std::int64_t now_us) const {
  return now_us >= latest_before(now_us + 1).history.now_us() + spacing_us_;
}

void Checkpoints::add(const LoopHistory& history, std::span<const LoopDetector> detectors) {
  std::vector<LoopDetector> copied = copies(detectors);
  if (copied.size() < detectors.size()) return;
  const auto later = std::ranges::find_if(checkpoints_, [&](const Checkpoint& checkpoint) {
    return checkpoint.history.now_us() > history.now_us();
  });
  checkpoints_.emplace(later, history, std::move(copied));
  const ImageSize image = history.image_size();
  if (checkpoints_.size() <= limit(image, detectors.size())) return;
  std::vector<Checkpoint> fewer;
  for (std::size_t i = 0; i < checkpoints_.size(); i += 2) fewer.push_back(std::move(checkpoints_[i]));
  checkpoints_ = std::move(fewer);
  spacing_us_ *= 2;
}

void Checkpoints::clear() { checkpoints_.erase(checkpoints_.begin() + 1, checkpoints_.end()); }

const Checkpoint& Checkpoints::latest_before(std::int64_t t_us) const {
  const auto last =
      std::find_if(checkpoints_.rbegin(), checkpoints_.rend(),
                   [&](const Checkpoint& checkpoint) { return checkpoint.history.now_us() < t_us; });
  return last != checkpoints_.rend() ? *last : start();
}

std::size_t Checkpoints::limit(ImageSize image, std::size_t detectors) {
  const std::int64_t bytes =
      static_cast<std::int64_t>(image.pixels()) * bytes_per_pixel * static_cast<std::int64_t>(detectors);
  return static_cast<std::size_t>(
      std::clamp<std::int64_t>(memory_bytes / std::max<std::int64_t>(bytes, 1), 3, 64));
}

}  // namespace saccade
