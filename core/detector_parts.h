#pragma once

#include <array>
#include <limits>
#include <vector>

#include "core/config.h"
#include "core/detector.h"

namespace saccade {

/// Describes the key radius_px of a detector: smallest and largest radius, whole pixels in [1, 255].
void describe_radius_px(FieldVisitor& v, std::array<double, 2>& radius_px);

/// Accepts the events that a detector can use and counts the others: events outside the image, and events earlier than
/// the newest accepted one. Equal time stamps are accepted.
class EventSieve {
 public:
  explicit EventSieve(ImageSize size) : size_(size) {}

  [[nodiscard]] bool accept(const Event& event) {
    if (is_outside(event)) {
      ++rejected_.outside_image;
      return false;
    }
    if (event.t_us < newest_us_) {
      ++rejected_.back_in_time;
      return false;
    }
    newest_us_ = event.t_us;
    return true;
  }

  /// What accept() would accept of a batch. Does not change the counts.
  struct Preview {
    std::int64_t count = 0;
    std::int64_t newest_us = 0;  ///< newest accepted time stamp, earlier batches included
  };
  [[nodiscard]] Preview preview(std::span<const Event> events) const {
    Preview seen{0, newest_us_};
    for (const Event& event : events) {
      if (is_outside(event) || event.t_us < seen.newest_us) continue;
      seen.newest_us = event.t_us;
      ++seen.count;
    }
    return seen;
  }

  [[nodiscard]] bool is_outside(const Event& e) const { return e.x >= size_.width || e.y >= size_.height; }
  [[nodiscard]] const RejectedEvents& rejected() const { return rejected_; }

 private:
  ImageSize size_;
  std::int64_t newest_us_ = std::numeric_limits<std::int64_t>::min();
  RejectedEvents rejected_;
};

}  // namespace saccade
