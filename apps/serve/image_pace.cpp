#include "apps/serve/image_pace.h"

#include <fmt/format.h>

#include <algorithm>

namespace saccade::inline v0_1 {

std::int64_t ImagePace::next(std::int64_t late_us) {
  ++ticks_;
  const std::int64_t interval_us = std::max(usual_us_, std::min(late_us, longest_us));
  if (late_us <= usual_late_us || interval_us == usual_us_) return usual_us_;
  ++slowed_;
  slowed_sum_us_ += interval_us;
  slowed_most_us_ = std::max(slowed_most_us_, interval_us);
  return interval_us;
}

double ImagePace::slowed_share() const {
  return ticks_ == 0 ? 0.0 : static_cast<double>(slowed_) / static_cast<double>(ticks_);
}

double ImagePace::slowed_interval_ms() const {
  if (slowed_ == 0) return usual_interval_ms();
  return 1e-3 * static_cast<double>(slowed_sum_us_) / static_cast<double>(slowed_);
}

double ImagePace::longest_interval_ms() const {
  return 1e-3 * static_cast<double>(std::max(usual_us_, slowed_most_us_));
}

std::string ImagePace::summary() const {
  if (slowed_ == 0) return fmt::format("images {:g} ms apart", usual_interval_ms());
  return fmt::format("images {:.1f} ms apart instead of {:g} in {:.1f} % of the time", slowed_interval_ms(),
                     usual_interval_ms(), 100.0 * slowed_share());
}

}  // namespace saccade::inline v0_1
