#include "robot/event_timeline.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/error.h"
#include "core/units.h"

namespace saccade {

EventTimeline::EventTimeline(const EventTimelineConfig& config)
    : config_(config), counter_(config.stamp_bits) {
  SACCADE_CHECK(config_.longest_spread_us > 0 && config_.image_size.pixels() > 0);
}

void EventTimeline::add(const EventPacket& packet, std::optional<std::int64_t> sent_us,
                        std::int64_t arrival_us, std::vector<Event>& events) {
  const std::size_t first = events.size();
  if (has_stamps(config_.format)) {
    if (!packet.events.empty()) add_stamped(packet, arrival_us, events);
  } else {
    add_spread(packet, sent_us ? sender_.to_local(*sent_us, arrival_us) : arrival_us, events);
  }
  const auto added = events.begin() + static_cast<std::ptrdiff_t>(first);
  std::stable_sort(added, events.end(), [](const Event& a, const Event& b) { return a.t_us < b.t_us; });
  const auto kept = std::remove_if(added, events.end(), [&](Event& event) { return !forward_.admit(event); });
  dropped_ += events.end() - kept;
  events.erase(kept, events.end());
}

void EventTimeline::restart() {
  sender_.restart();
  counter_ = StampCounter(config_.stamp_bits);
  last_arrival_us_.reset();
}

void EventTimeline::take(const WireEvent& wire, std::int64_t t_us, std::vector<Event>& events) {
  std::optional<Event> event = decode_address(wire.address, config_.codec);
  if (event && config_.swap_xy) std::swap(event->x, event->y);
  if (event) {
    if (config_.swap_polarity) event->on = !event->on;
    ++view_.events;
    view_.on += event->on;
    view_.max_x = std::max<int>(view_.max_x, event->x);
    view_.max_y = std::max<int>(view_.max_y, event->y);
  }
  if (!event || !config_.image_size.contains(event->x, event->y)) {
    view_.outside += event ? 1 : 0;
    ++dropped_;
    return;
  }
  if (config_.flip_x) event->x = static_cast<std::uint16_t>(config_.image_size.width - 1 - event->x);
  if (config_.flip_y) event->y = static_cast<std::uint16_t>(config_.image_size.height - 1 - event->y);
  if (config_.camera) event->camera = *config_.camera;
  event->t_us = t_us;
  events.push_back(*event);
}

void EventTimeline::add_spread(const EventPacket& packet, std::int64_t end_us, std::vector<Event>& events) {
  const std::int64_t span_us = std::min(packet.duration_us, config_.longest_spread_us);
  const auto count = static_cast<std::int64_t>(packet.events.size());
  for (std::int64_t i = 0; i < count; ++i) {
    take(packet.events[static_cast<std::size_t>(i)], end_us - span_us * (count - 1 - i) / count, events);
  }
}

void EventTimeline::add_stamped(const EventPacket& packet, std::int64_t arrival_us,
                                std::vector<Event>& events) {
  const std::int64_t ns = tick_ns(config_.codec);
  const std::int64_t elapsed_us = arrival_us - last_arrival_us_.value_or(arrival_us);
  last_arrival_us_ = arrival_us;
  const std::size_t first = events.size();
  std::int64_t ticks = counter_.begin(packet.events.front().stamp, elapsed_us * 1000 / ns);
  std::int64_t newest_us = INT64_MIN;
  for (const WireEvent& wire : packet.events) {
    ticks = counter_.next(wire.stamp);
    const std::int64_t t_us = us_from_ticks(ticks, ns);
    newest_us = std::max(newest_us, t_us);
    take(wire, t_us, events);
  }
  const std::int64_t shift_us = sender_.to_local(newest_us, arrival_us) - newest_us;
  for (std::size_t i = first; i < events.size(); ++i) events[i].t_us += shift_us;
}

std::string CameraView::problem(ImageSize configured) const {
  constexpr std::int64_t enough_events = 1000;
  constexpr double most_outside = 0.02;  // a few words are garbled
  constexpr double least_polarity = 0.02;
  if (events < enough_events) return {};
  const auto share = [&](std::int64_t count) {
    return static_cast<double>(count) / static_cast<double>(events);
  };
  const auto percent = [&](std::int64_t count) {
    return std::to_string(std::lround(100.0 * share(count))) + " %";
  };
  if (share(outside) > most_outside) {
    return percent(outside) + " of the events lie outside " + in_words(configured) + " (largest x " +
           std::to_string(max_x) + ", y " + std::to_string(max_y) + "): another camera, codec or swap_xy";
  }
  if (2 * (max_x + 1) <= configured.width && 2 * (max_y + 1) <= configured.height) {
    return "the events fill " + in_words({max_x + 1, max_y + 1}) + " of " + in_words(configured) +
           ": another camera or codec";
  }
  if (share(on) < least_polarity || share(on) > 1.0 - least_polarity)
    return percent(on) + " of the events are ON: another codec";
  return {};
}

}  // namespace saccade
