#include "recording/event_statistics.h"

#include <algorithm>

#include "recording/saturating.h"

namespace saccade {

double EventStatistics::duration_s() const {
  return 1e-6 * static_cast<double>(saturated_difference(newest_us, oldest_us));
}

std::optional<double> EventStatistics::mean_rate_hz() const {
  if (newest_us == oldest_us) return std::nullopt;
  return static_cast<double>(count) / duration_s();
}

void EventCounter::add(std::span<const Event> events) {
  for (const Event& event : events) {
    add(all_, event);
    add(cameras_[event.camera == 1 ? 1 : 0], event);
  }
}

void EventCounter::add(Stream& stream, const Event& event) const {
  constexpr std::int64_t short_us = 1'000, long_us = 100'000;
  EventStatistics& s = stream.statistics;
  if (s.count == 0) {
    s.first_us = s.oldest_us = s.newest_us = event.t_us;
    stream.short_bin.begin_us = stream.long_bin.begin_us = event.t_us;
  }
  ++s.count;
  s.on += event.on ? 1 : 0;
  s.reach = {std::max(s.reach.width, event.x + 1), std::max(s.reach.height, event.y + 1)};
  s.outside_image += image_size_ && !image_size_->contains(event.x, event.y) ? 1 : 0;

  const std::int64_t step_us = saturated_difference(event.t_us, s.newest_us);
  if (step_us < 0) {
    ++s.back_in_time;
    s.longest_step_back_us = std::max(s.longest_step_back_us, saturated_difference(s.newest_us, event.t_us));
    s.oldest_us = std::min(s.oldest_us, event.t_us);
  }
  if (step_us > s.longest_gap_us) {
    s.longest_gap_us = step_us;
    s.longest_gap_at_us = s.newest_us;
  }
  s.gaps += step_us > gap_us_ ? 1 : 0;
  s.newest_us = std::max(s.newest_us, event.t_us);

  const auto count_in = [&](Bin& bin, std::int64_t bin_us, std::int64_t& most) {
    const std::int64_t since_us = saturated_difference(event.t_us, bin.begin_us);
    if (since_us >= bin_us) {
      bin.begin_us += since_us - since_us % bin_us;
      bin.count = 0;
    }
    most = std::max(most, ++bin.count);
  };
  count_in(stream.short_bin, short_us, s.most_in_1ms);
  count_in(stream.long_bin, long_us, s.most_in_100ms);
}

}  // namespace saccade
