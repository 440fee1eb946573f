#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/config.h"
#include "core/plane_fit_flow.h"

namespace saccade {

/// Which events a transform is made of.
struct EventWindowConfig {
  /// count: the newest `events`. time: those younger than `duration_us`. lifetime: each stays for as long as
  /// its edge needs to move on by `crossing_px`, within [shortest_us, longest_us] (Mueggler et al., ICRA
  /// 2015, who take 1 px: an edge is as thick as that, whatever its speed; more bridges the pixels whose flow
  /// is missing). An event without flow has no lifetime and does not enter.
  std::string kind = "count";
  std::int64_t events = 1500;  ///< of any kind: an event leaves when so many newer ones have come
  std::int64_t duration_us = 20'000;
  double crossing_px = 3.0;
  std::int64_t shortest_us = 500;
  std::int64_t longest_us = 300'000;
};

/// The defaults of a kind: by time and by lifetime, `events` bounds memory alone.
[[nodiscard]] EventWindowConfig event_window(const std::string& kind);
/// Keys: kind, events; time: duration_us; lifetime: crossing_px, shortest_us, longest_us.
void describe(FieldVisitor& v, EventWindowConfig& config);

/// An event as it votes.
struct WindowEvent {
  std::uint16_t x = 0, y = 0;
  std::int16_t direction = 0;  ///< for the voter's own use
};

/// Keeps what a lazy voter needs: the events of the window now, as the difference from those at the last
/// time it asked. An event is inside while fewer than `events` came after it and its lifetime is not over,
/// which depends on the stream and the time alone, not on when anybody asked: events that came and went in
/// between cost next to nothing. Nothing allocates after construction.
class EventWindow {
 public:
  /// Throws InputError for a configuration out of range.
  explicit EventWindow(const EventWindowConfig& config);

  [[nodiscard]] bool needs_flow() const { return config_.kind == "lifetime"; }
  /// How long an event with this flow stays; 0: it does not enter.
  [[nodiscard]] std::int64_t lifetime_us(const std::optional<NormalFlow>& flow) const;
  /// True for an event that has left once `newer` more have come and time is `now_us`, whatever its flow.
  [[nodiscard]] bool outlived(std::int64_t t_us, std::int64_t newer, std::int64_t now_us) const {
    return newer >= config_.events || end_of_stay_us(t_us, longest_us_) <= now_us;
  }

  /// The next event; its time must not be earlier than the last one's. It counts among `events` even where
  /// its lifetime is 0 and it never enters.
  void push(std::int64_t t_us, const WindowEvent& event, std::int64_t lifetime_us);

  struct Change {
    bool all_left = false;              ///< none of those inside before is inside now; then `left` is empty
    std::span<const WindowEvent> left;  ///< since the last update()
    std::span<const WindowEvent> entered;  ///< since the last update(), and still inside
    [[nodiscard]] bool none() const { return !all_left && left.empty() && entered.empty(); }
  };
  /// Brings the window to `now_us`, not earlier than at the last update() nor than any event.
  /// What it returns is valid until the next one.
  [[nodiscard]] Change update(std::int64_t now_us);

 private:
  struct Slot {
    std::int64_t until_us;  // inside before this instant
    WindowEvent event;
    bool inside;  // as of the last update
  };
  [[nodiscard]] static std::int64_t end_of_stay_us(std::int64_t t_us, std::int64_t lifetime_us) {
    constexpr std::int64_t last_us = std::numeric_limits<std::int64_t>::max();
    return t_us > last_us - lifetime_us ? last_us : t_us + lifetime_us;
  }
  [[nodiscard]] Slot& slot(std::int64_t number) {
    return ring_[static_cast<std::size_t>(number % static_cast<std::int64_t>(ring_.size()))];
  }
  void let_leave(std::int64_t oldest, std::int64_t now_us);

  EventWindowConfig config_;
  bool in_order_;              // events leave in the order they came
  std::int64_t longest_us_;    // no lifetime is longer
  std::vector<Slot> ring_;     // the newest 2 N events: those inside at the last update can still leave
  std::int64_t received_ = 0;  // events so far
  std::int64_t seen_ = 0;      // of them at the last update
  std::int64_t first_ = 0;     // none before this one is inside
  std::int64_t inside_ = 0;    // how many are
  std::vector<WindowEvent> left_, entered_;
};

}  // namespace saccade
