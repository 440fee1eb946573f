#pragma once

#include <cstddef>
#include <cstdint>
#include <initializer_list>

namespace saccade {

/// Continues counters of few bits over their wraps, in the counter's own unit: from the last `silence` of the range to
/// its first, and back over a wrap for a value that comes up to `lateness` late. Only jumps of more than `silence` are
/// looked at; any other one is delivered as it is, as is a first value near the range's end.
class WrappingTime {
 public:
  struct Range {
    std::int64_t first = 0;   ///< the lowest value that the counter has
    std::int64_t length = 0;  ///< how many values it has
  };
  /// One range, or two where writers differ, the longer one first.
  WrappingTime(std::initializer_list<Range> ranges, std::int64_t silence, std::int64_t lateness)
      : silence_(silence), lateness_(lateness) {
    for (const Range range : ranges) ranges_[range_count_++] = range;
  }

  [[nodiscard]] std::int64_t extend(std::int64_t value) {
    if (!started_) last_ = value;
    started_ = true;
    const std::int64_t step = value - last_;
    if (step < -silence_ || step > silence_) jump(value);
    last_ = value;
    return offset_ + value;
  }

 private:
  void jump(std::int64_t value) {
    for (std::size_t i = 0; i < range_count_; ++i) {
      const auto [first, length] = ranges_[i];
      const std::int64_t end = first + length;
      if (last_ >= end - silence_ && value >= first && value < first + silence_) {
        offset_ += length;
        return;
      }
      if (value >= end - lateness_ && last_ >= first && last_ < first + lateness_ && offset_ >= length) {
        offset_ -= length;
        return;
      }
    }
  }

  Range ranges_[2];
  std::size_t range_count_ = 0;
  std::int64_t silence_;
  std::int64_t lateness_;
  bool started_ = false;
  std::int64_t last_ = 0;
  std::int64_t offset_ = 0;
};

}  // namespace saccade
