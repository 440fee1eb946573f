#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "core/config.h"
#include "core/flow/plane_fit_flow.h"
#include "core/reserved_vector.h"
#include "core/time_stamp.h"

namespace saccade {

/// What bounds an event's stay in a window.
enum class WindowKind { count, time, lifetime };
constexpr auto words_of(WindowKind) {
  return std::to_array<Word<WindowKind>>(
      {{WindowKind::count, "count"}, {WindowKind::time, "time"}, {WindowKind::lifetime, "lifetime"}});
}

/// Which events a transform is made of.
struct EventWindowConfig {
  /// count: the newest `events`. time: those younger than `duration_us`. lifetime: each stays for as long as
  /// its edge needs to move on by `crossing_px`, within [shortest_us, longest_us] (Mueggler et al., ICRA
  /// 2015, who take 1 px: an edge is as thick as that, whatever its speed; more bridges the pixels whose flow
  /// is missing). An event without flow has no lifetime and does not enter.
  WindowKind kind = WindowKind::count;
  std::int64_t events = 1500;  ///< of any kind: an event leaves when so many newer ones have come
  std::int64_t duration_us = 20'000;
  double crossing_px = 3.0;
  std::int64_t shortest_us = 500;
  std::int64_t longest_us = 300'000;
};

/// The defaults of a kind: by time and by lifetime, `events` bounds memory alone.
[[nodiscard]] EventWindowConfig event_window(WindowKind kind);
/// Keys: kind, events; time: duration_us; lifetime: crossing_px, shortest_us, longest_us.
void describe(FieldVisitor& v, EventWindowConfig& config);

/// What a window stores of an event.
struct WindowEvent {
  std::uint16_t x = 0, y = 0;
  std::int16_t direction = 0;  ///< set and used by the owner of the window
};

/// A sliding window over events. update() returns which events entered and left since the last update().
///
/// An event is inside while fewer than `events` newer ones were pushed and its lifetime has not ended. This depends on
/// the stream and the time only, not on when update() is called. An event that enters and leaves between two updates
/// is never returned and costs almost nothing. Does not allocate after construction.
class EventWindow {
 public:
  /// Throws InputError for a configuration out of range.
  explicit EventWindow(const EventWindowConfig& config);

  [[nodiscard]] bool needs_flow() const { return !in_order_; }
  /// The lifetime of an event with this flow, us; 0: the event does not enter.
  [[nodiscard]] std::int64_t lifetime_us(const std::optional<NormalFlow>& flow) const;
  /// True if an event is outside after `newer` more events at `now_us`, whatever its flow.
  [[nodiscard]] bool outlived(std::int64_t t_us, std::int64_t newer, std::int64_t now_us) const {
    return newer >= config_.events || !is_inside(end_of_stay_us(t_us, longest_us_), now_us);
  }

  /// Adds the next event, not earlier than the last one. An event with a lifetime of 0 never enters, but counts among
  /// the newest `events`.
  void push(std::int64_t t_us, const WindowEvent& event, std::int64_t lifetime_us);

  struct Change {
    bool all_left = false;                 ///< every event that was inside has left; `left` is empty then
    std::span<const WindowEvent> left;     ///< since the last update()
    std::span<const WindowEvent> entered;  ///< since the last update(), and still inside
    [[nodiscard]] bool none() const { return !all_left && left.empty() && entered.empty(); }
  };
  /// Advances the window to `now_us`, which is not earlier than the last update() and any event. The returned spans are
  /// valid until the next update().
  [[nodiscard]] Change update(std::int64_t now_us);

 private:
  static constexpr std::int64_t forever_us = std::numeric_limits<std::int64_t>::max();
  struct Slot {
    std::int64_t until_us;  // inside before this instant
    WindowEvent event;
    bool inside;  // as of the last update
  };
  [[nodiscard]] static std::int64_t end_of_stay_us(std::int64_t t_us, std::int64_t lifetime_us) {
    return lifetime_us == forever_us ? forever_us : saturated_sum(t_us, lifetime_us);
  }
  [[nodiscard]] static bool is_inside(std::int64_t until_us, std::int64_t now_us) {
    return until_us > now_us || until_us == forever_us;
  }
  [[nodiscard]] Slot& slot(std::int64_t number) {
    return ring_[static_cast<std::size_t>(number % static_cast<std::int64_t>(ring_.size()))];
  }
  void let_leave(std::int64_t oldest, std::int64_t now_us);

  EventWindowConfig config_;
  bool in_order_;              // events leave in the order they came: not with lifetimes from flow
  std::int64_t longest_us_;    // no lifetime is longer
  std::vector<Slot> ring_;     // the newest 2 N events: those inside at the last update can still leave
  std::int64_t received_ = 0;  // events so far
  std::int64_t seen_ = 0;      // of them at the last update
  std::int64_t first_ = 0;     // none before this one is inside
  std::int64_t inside_ = 0;    // how many are
  ReservedVector<WindowEvent> left_, entered_;
};

}  // namespace saccade
