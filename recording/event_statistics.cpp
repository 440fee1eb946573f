#include "recording/event_statistics.h"

#include <algorithm>

#include "core/time_stamp.h"

namespace saccade {

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
  if (!both_) {
    if (!add_in_order(cameras_[only_], events)) add(cameras_[only_], events, every);
    return;
  }
  add(all_, events, every);
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera)
    add(cameras_[camera], events, [&](const Event& event) { return camera_of(event) == camera; });
}

/// What add() does, for events in order of time, as those of most recordings are: a few passes that a compiler turns into
/// vector instructions. False, and nothing done, for other events and for times whose differences do not fit.
bool EventCounter::add_in_order(Stream& stream, std::span<const Event> events) const {
  constexpr std::int64_t short_us = 1'000, long_us = 100'000, far_us = std::int64_t{1} << 62;
  if (events.empty()) return true;
  const std::int64_t first_us = events.front().t_us, last_us = events.back().t_us;
  const bool is_first = stream.statistics.count == 0;
  std::int64_t newest_us = is_first ? first_us : stream.statistics.newest_us;
  const std::int64_t oldest_us =
      is_first ? first_us : std::min(stream.short_bin.begin_us, stream.long_bin.begin_us);
  if (oldest_us <= -far_us || std::max(first_us, last_us) >= far_us || newest_us > first_us) return false;
  bool in_order = true;
  std::int64_t longest_us = first_us - newest_us;
  for (std::size_t i = 1; i < events.size(); ++i) {
    const auto step_us = static_cast<std::int64_t>(static_cast<std::uint64_t>(events[i].t_us) -
                                                   static_cast<std::uint64_t>(events[i - 1].t_us));
    in_order &= events[i].t_us >= events[i - 1].t_us;
    longest_us = std::max(longest_us, step_us);
  }
  if (!in_order) return false;

  EventStatistics& s = stream.statistics;
  if (is_first) {
    s.first_us = s.oldest_us = s.newest_us = first_us;
    stream.short_bin.begin_us = stream.long_bin.begin_us = first_us;
  }
  s.count += static_cast<std::int64_t>(events.size());
  std::uint32_t on = 0;
  std::uint16_t x = 0, y = 0;
  for (const Event& event : events) {
    on += event.on ? 1 : 0;
    x = std::max(x, event.x);
    y = std::max(y, event.y);
  }
  s.on += on;
  s.reach = {std::max(s.reach.width, x + 1), std::max(s.reach.height, y + 1)};
  if (image_size_ && !image_size_->contains(x, y)) {
    s.outside_image += std::ranges::count_if(
        events, [&](const Event& event) { return !image_size_->contains(event.x, event.y); });
  }
  if (longest_us > s.longest_gap_us || longest_us > gap_us_) {
    for (const Event& event : events) {
      const std::int64_t step_us = event.t_us - newest_us;
      if (step_us > s.longest_gap_us) {
        s.longest_gap_us = step_us;
        s.longest_gap_at_us = newest_us;
      }
      s.gaps += step_us > gap_us_ ? 1 : 0;
      newest_us = event.t_us;
    }
  }
  s.newest_us = last_us;

  const auto count_in = [&](Bin& bin, std::int64_t bin_us, std::int64_t& most) {
    for (auto from = events.begin(); from != events.end();) {
      const std::int64_t since_us = from->t_us - bin.begin_us;
      if (since_us >= bin_us) {
        bin.begin_us += since_us - since_us % bin_us;
        bin.count = 0;
      }
      const auto to = std::partition_point(
          from, events.end(), [&](const Event& event) { return event.t_us < bin.begin_us + bin_us; });
      bin.count += to - from;
      most = std::max(most, bin.count);
      from = to;
    }
  };
  count_in(stream.short_bin, short_us, s.most_in_1ms);
  count_in(stream.long_bin, long_us, s.most_in_100ms);
  return true;
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

}  // namespace saccade
