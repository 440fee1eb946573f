#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "head/head_state.h"

namespace saccade {

/// The last references of the six head joints, one per step.
class ReferenceHistory {
 public:
  static constexpr std::size_t capacity = 512;

  void push(const HeadJointVector& reference_rad) { ring_[count_++ % capacity] = reference_rad; }
  /// The reference `steps` before the newest one (rounded; the oldest known where there are fewer); zero if none was
  /// pushed.
  [[nodiscard]] const HeadJointVector& at(double steps) const {
    const std::size_t known = std::min(count_, capacity);
    if (known == 0) return ring_[0];
    const auto back = std::min(static_cast<std::size_t>(std::lround(steps)), known - 1);
    return ring_[(count_ - 1 - back) % capacity];
  }
  void clear() { count_ = 0; }

 private:
  std::array<HeadJointVector, capacity> ring_ = filled();
  std::size_t count_ = 0;

  static std::array<HeadJointVector, capacity> filled() {
    std::array<HeadJointVector, capacity> ring;
    ring.fill(HeadJointVector::Zero());
    return ring;
  }
};

}  // namespace saccade
