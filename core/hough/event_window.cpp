#include "core/hough/event_window.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace saccade {
namespace {

/// The longest lifetime; the largest number where time does not matter.
std::int64_t longest_us_of(const EventWindowConfig& config) {
  if (config.kind == WindowKind::count) return std::numeric_limits<std::int64_t>::max();
  return config.kind == WindowKind::time ? config.duration_us : config.longest_us;
}

}  // namespace

EventWindowConfig event_window(WindowKind kind) {
  EventWindowConfig config;
  config.kind = kind;
  if (kind != WindowKind::count) config.events = 20'000;
  return config;
}

void describe(FieldVisitor& v, EventWindowConfig& config) {
  const WindowKind kind = config.kind;
  v.choice("kind", config.kind, "bound of the time that an event stays in the window");
  if (config.kind != kind) config = event_window(config.kind);
  v.integer("events", config.events, {1, 60000}, "largest number of events in the window");
  if (config.kind == WindowKind::time) {
    v.integer("duration_us", config.duration_us, {1, 10'000'000}, "age up to which events are in the window");
  }
  if (config.kind == WindowKind::lifetime) {
    v.real("crossing_px", config.crossing_px, {0.1, 20.0}, "an event stays while its edge moves by this");
    v.integer("shortest_us", config.shortest_us, {1, 10'000'000}, "no event with flow stays shorter");
    v.integer("longest_us", config.longest_us, {1, 10'000'000}, "no event stays longer");
    v.require(config.shortest_us <= config.longest_us, "longest_us", std::to_string(config.longest_us),
              "at least shortest_us");
  }
}

EventWindow::EventWindow(const EventWindowConfig& config)
    : config_(config), in_order_(config.kind != WindowKind::lifetime), longest_us_(longest_us_of(config)) {
  check_config("window", config);
  const auto n = static_cast<std::size_t>(config.events);
  ring_.resize(2 * n);
  left_.reserve(n);
  entered_.reserve(n);
}

std::int64_t EventWindow::lifetime_us(const std::optional<NormalFlow>& flow) const {
  if (!needs_flow()) return longest_us_;
  if (!flow) return 0;
  const double crossing_us = config_.crossing_px * std::hypot(flow->dt_dx_us_px, flow->dt_dy_us_px);
  return std::llround(std::clamp(crossing_us, static_cast<double>(config_.shortest_us),
                                 static_cast<double>(config_.longest_us)));
}

void EventWindow::push(std::int64_t t_us, const WindowEvent& event, std::int64_t lifetime_us) {
  slot(received_++) = {end_of_stay_us(t_us, lifetime_us), event, false};
}

void EventWindow::let_leave(std::int64_t oldest, std::int64_t now_us) {
  bool stays = false;
  for (std::int64_t i = first_; i < seen_ && !(stays && in_order_); ++i) {
    Slot& s = slot(i);
    if (!s.inside) continue;
    if (i >= oldest && is_inside(s.until_us, now_us)) {
      if (!stays) first_ = i;
      stays = true;
      continue;
    }
    s.inside = false;
    --inside_;
    left_.push_back(s.event);
  }
}

EventWindow::Change EventWindow::update(std::int64_t now_us) {
  left_.clear();
  entered_.clear();
  const std::int64_t oldest = std::max<std::int64_t>(0, received_ - config_.events);
  const bool were_inside = inside_ > 0;
  if (oldest < seen_) {
    let_leave(oldest, now_us);
  } else {
    inside_ = 0;  // their slots may have been taken by newer events
  }
  const bool all_left = were_inside && inside_ == 0;
  if (all_left) left_.clear();
  if (inside_ == 0) first_ = std::max(oldest, seen_);
  for (std::int64_t i = std::max(oldest, seen_); i < received_; ++i) {
    Slot& s = slot(i);
    if (!is_inside(s.until_us, now_us)) continue;
    s.inside = true;
    ++inside_;
    entered_.push_back(s.event);
  }
  seen_ = received_;
  return {all_left, left_, entered_};
}

}  // namespace saccade
