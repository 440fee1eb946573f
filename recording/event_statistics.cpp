#include "recording/event_statistics.h"

#include <algorithm>

#include "recording/saturating.h"

namespace saccade::inline v0_1 {

double EventStatistics::duration_s() const {
  return 1e-6 * static_cast<double>(saturated_difference(newest_us, oldest_us));
}

std::optional<double> EventStatistics::mean_rate_hz() const {
  if (newest_us == oldest_us) return std::nullopt;
  return static_cast<double>(count) / duration_s();
}

void EventCounter::add(std::span<const Event> events) {
  const auto camera_of = [](const Event& event) -> std::size_t { return event.camera == 1 ? 1 : 0; };
  const auto every = [](const Event&) { return true; };
  if (!both_ && !events.empty()) {
    if (cameras_[only_].statistics.count == 0) only_ = camera_of(events.front());
    both_ = !std::ranges::all_of(events, [&](const Event& event) { return camera_of(event) == only_; });
    if (both_) all_ = cameras_[only_];
  }
  if (!both_) return add(cameras_[only_], events, every);
  add(all_, events, every);
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera)
    add(cameras_[camera], events, [&](const Event& event) { return camera_of(event) == camera; });
}

template <class Takes>
void EventCounter::add(Stream& stream, std::span<const Event> events, const Takes& takes) const {
  constexpr std::int64_t short_us = 1'000, long_us = 100'000;
  // Local copies stay in registers.
  Stream counted = stream;
  EventStatistics& s = counted.statistics;
  const bool is_sized = image_size_.has_value();
  const ImageSize size = image_size_.value_or(ImageSize{});
  const std::int64_t gap_us = gap_us_;
  for (const Event& event : events) {
    if (!takes(event)) continue;
    if (s.count == 0) {
      s.first_us = s.oldest_us = s.newest_us = event.t_us;
      counted.short_bin.begin_us = counted.long_bin.begin_us = event.t_us;
    }
    ++s.count;
    s.on += event.on ? 1 : 0;
    s.reach = {std::max(s.reach.width, event.x + 1), std::max(s.reach.height, event.y + 1)};
    s.outside_image += is_sized && !size.contains(event.x, event.y) ? 1 : 0;

    const std::int64_t step_us = saturated_difference(event.t_us, s.newest_us);
    if (step_us < 0) {
      ++s.back_in_time;
      s.longest_step_back_us =
          std::max(s.longest_step_back_us, saturated_difference(s.newest_us, event.t_us));
      s.oldest_us = std::min(s.oldest_us, event.t_us);
    }
    if (step_us > s.longest_gap_us) {
      s.longest_gap_us = step_us;
      s.longest_gap_at_us = s.newest_us;
    }
    s.gaps += step_us > gap_us ? 1 : 0;
    s.newest_us = std::max(s.newest_us, event.t_us);

    const auto count_in = [&](Bin& bin, std::int64_t bin_us, std::int64_t& most) {
      const std::int64_t since_us = saturated_difference(event.t_us, bin.begin_us);
      if (since_us >= bin_us) {
        bin.begin_us += since_us - since_us % bin_us;
        bin.count = 0;
      }
      most = std::max(most, ++bin.count);
    };
    count_in(counted.short_bin, short_us, s.most_in_1ms);
    count_in(counted.long_bin, long_us, s.most_in_100ms);
  }
  stream = counted;
}

}  // namespace saccade::inline v0_1
