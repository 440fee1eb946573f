#include "apps/serve/image_pace.h"

#include <fmt/format.h>

#include <algorithm>

namespace saccade {

std::int64_t ImagePace::next(std::int64_t late_us, std::int64_t image_us) {
  if (image_us != image_us_) {
    if (held_) {
      ++held_images_;
      held_sum_us_ += image_us - image_us_;
      held_most_us_ = std::max(held_most_us_, image_us - image_us_);
    }
    held_ = false;
    image_us_ = image_us;
  }
  ++ticks_;
  if (late_us <= usual_late_us || usual_us_ >= longest_us) return usual_us_;
  ++held_ticks_;
  held_ = true;
  return longest_us;
}

double ImagePace::held_share() const {
  return ticks_ == 0 ? 0.0 : static_cast<double>(held_ticks_) / static_cast<double>(ticks_);
}

double ImagePace::held_interval_ms() const {
  if (held_images_ == 0) return usual_interval_ms();
  return 1e-3 * static_cast<double>(held_sum_us_) / static_cast<double>(held_images_);
}

double ImagePace::longest_interval_ms() const {
  return 1e-3 * static_cast<double>(std::max(usual_us_, held_most_us_));
}

std::string ImagePace::summary() const {
  std::string text = fmt::format("images at least {:g} ms apart", usual_interval_ms());
  if (held_images_ > 0) {
    text += fmt::format("; held back in {:.1f} % of the time, then {:.1f} ms apart", 100.0 * held_share(),
                        held_interval_ms());
  }
  return text;
}

}  // namespace saccade
