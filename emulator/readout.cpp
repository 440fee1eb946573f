#include "emulator/readout.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace saccade {
namespace {

constexpr std::int64_t no_event_us = std::numeric_limits<std::int64_t>::min();

std::int64_t tick_at_or_after(std::int64_t t_us, std::int64_t tick_us) {
  const std::int64_t into = ((t_us % tick_us) + tick_us) % tick_us;
  return into == 0 ? t_us : t_us + tick_us - into;
}

/// Puts the events of one microsecond into a random order, that of random numbers of each pixel and `time`: an event more or
/// less leaves the order of the others.
void shuffle(std::vector<PixelEvent>& events, const RandomStream& random, std::uint64_t time) {
  std::stable_sort(events.begin(), events.end(), [&](const PixelEvent& a, const PixelEvent& b) {
    return random.bits(a.pixel, time) < random.bits(b.pixel, time);
  });
}

/// Erases the first `gone` elements when they are the larger part.
template <class T>
void erase_gone(std::vector<T>& queue, std::size_t& gone) {
  if (gone < 1024 || 2 * gone < queue.size()) return;
  queue.erase(queue.begin(), queue.begin() + static_cast<std::ptrdiff_t>(gone));
  gone = 0;
}

}  // namespace

Readout::Readout(const EmulatorConfig& config, std::size_t pixels, std::uint64_t seed)
    : config_(config),
      random_(seed, "readout"),
      service_us_(config.readout_rate_hz > 0.0 ? 1e6 / config.readout_rate_hz : 0.0),
      transparent_(config.latency_us == 0 && service_us_ == 0.0 && config.timestamp_resolution_us == 1),
      busy_since_us_(no_event_us) {
  const auto tick_us = static_cast<double>(config.timestamp_resolution_us);
  const bool apart = service_us_ == 0.0 ? tick_us == 1.0 : service_us_ >= tick_us;
  if (!apart) last_stamp_us_.assign(pixels, no_event_us);
}

void Readout::process(std::span<const PixelEvent> requests, std::int64_t t_us,
                      std::vector<PixelEvent>& events) {
  if (transparent_) {
    events.insert(events.end(), requests.begin(), requests.end());
    return;
  }
  if (!origin_us_ && !requests.empty()) origin_us_ = requests.front().t_us;
  std::size_t fetched = 0;  // requests whose pixels' last stamps are on their way from memory
  for (std::size_t first = 0; first < requests.size();) {
    const std::int64_t request_us = requests[first].t_us;
    std::size_t end = first + 1;
    while (end < requests.size() && requests[end].t_us == request_us) ++end;
#if defined(__GNUC__)
    constexpr std::size_t ahead = 32;
    for (; !last_stamp_us_.empty() && fetched < std::min(end + ahead, requests.size()); ++fetched)
      __builtin_prefetch(&last_stamp_us_[requests[fetched].pixel], 1);
#endif
    std::span<const PixelEvent> group = requests.subspan(first, end - first);
    first = end;
    if (group.size() > 1 && service_us_ > 0.0) {
      advance_bus(request_us + config_.latency_us);
      if (order_matters(group.size())) {
        shuffled_.assign(group.begin(), group.end());
        shuffle(shuffled_, random_, static_cast<std::uint64_t>(request_us - *origin_us_));
        group = shuffled_;
      }
    }
    for (const PixelEvent& request : group) stamp(request);
  }
  const auto begin = stamped_.begin() + static_cast<std::ptrdiff_t>(released_);
  const auto end = std::upper_bound(begin, stamped_.end(), t_us,
                                    [](std::int64_t t, const PixelEvent& e) { return t < e.t_us; });
  release(static_cast<std::size_t>(end - begin), events);
}

void Readout::finish(std::vector<PixelEvent>& events) { release(stamped_.size() - released_, events); }

void Readout::release(std::size_t count, std::vector<PixelEvent>& events) {
  const auto begin = stamped_.begin() + static_cast<std::ptrdiff_t>(released_);
  events.insert(events.end(), begin, begin + static_cast<std::ptrdiff_t>(count));
  released_ += count;
  erase_gone(stamped_, released_);
}

void Readout::advance_bus(std::int64_t t_us) {
  while (departed_ < departures_us_.size() && departures_us_[departed_] <= t_us) ++departed_;
  if (in_queue() > 0) return;
  busy_since_us_ = t_us;
  busy_events_ = 0;
}

std::int64_t Readout::transmitted_us(std::int64_t count) const {
  // Rounding errors do not cost a microsecond. 2^60 us is later than any image.
  const double worked_us =
      std::min(std::ceil(static_cast<double>(busy_events_ + count) * service_us_ - 1e-6), 0x1p60);
  return busy_since_us_ + static_cast<std::int64_t>(worked_us);
}

bool Readout::order_matters(std::size_t count) const {
  const auto n = static_cast<std::int64_t>(count);
  if (config_.readout_queue_events > 0 && in_queue() + n > config_.readout_queue_events) return true;
  const std::int64_t tick_us = config_.timestamp_resolution_us;
  return tick_at_or_after(transmitted_us(1), tick_us) != tick_at_or_after(transmitted_us(n), tick_us);
}

std::optional<std::int64_t> Readout::serve(std::int64_t t_us) {
  if (service_us_ == 0.0) return t_us;
  advance_bus(t_us);
  if (config_.readout_queue_events > 0 && in_queue() >= config_.readout_queue_events) return std::nullopt;
  const std::int64_t end_us = transmitted_us(1);
  ++busy_events_;
  return end_us;
}

void Readout::stamp(PixelEvent request) {
  const std::optional<std::int64_t> served_us = serve(request.t_us + config_.latency_us);
  if (!served_us) {
    ++dropped_;
    return;
  }
  request.t_us = tick_at_or_after(*served_us, config_.timestamp_resolution_us);
  std::int64_t departure_us = *served_us;
  if (!last_stamp_us_.empty()) {
    std::int64_t& last_us = last_stamp_us_[request.pixel];
    if (request.t_us <= last_us) {
      request.t_us = departure_us = last_us + config_.timestamp_resolution_us;
      busy_since_us_ = departure_us;
      busy_events_ = 0;
    }
    last_us = request.t_us;
  }
  if (service_us_ > 0.0) {
    departures_us_.push_back(departure_us);
    erase_gone(departures_us_, departed_);
  }
  auto place = stamped_.end();
  const auto waiting = stamped_.begin() + static_cast<std::ptrdiff_t>(released_);
  if (waiting != stamped_.end() && stamped_.back().t_us > request.t_us) {  // one moved on by a tick
    place = std::upper_bound(waiting, stamped_.end(), request.t_us,
                             [](std::int64_t t, const PixelEvent& e) { return t < e.t_us; });
  }
  stamped_.insert(place, request);
}

}  // namespace saccade
