#include "core/hough/event_window.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/random.h"
#include "tests/core/allocation_counter.h"

namespace saccade {
namespace {

using testing::HasSubstr;

/// Follows the changes of a window as a voter does.
class Follower {
 public:
  explicit Follower(const EventWindowConfig& config) : window_(config) {}

  EventWindow& window() { return window_; }
  /// The events inside now, by the number that the test gave them in x.
  const std::multiset<int>& inside(std::int64_t now_us) {
    const EventWindow::Change change = window_.update(now_us);
    EXPECT_FALSE(change.all_left && !change.left.empty());
    if (change.all_left) {
      EXPECT_FALSE(inside_.empty());
      inside_.clear();
    }
    for (const WindowEvent& e : change.left) {
      const auto it = inside_.find(e.x);
      if (it == inside_.end()) ADD_FAILURE() << "event " << e.x << " left without having entered";
      if (it != inside_.end()) inside_.erase(it);
    }
    for (const WindowEvent& e : change.entered) inside_.insert(e.x);
    EXPECT_EQ(change.none(), !change.all_left && change.left.empty() && change.entered.empty());
    return inside_;
  }

 private:
  EventWindow window_;
  std::multiset<int> inside_;
};

TEST(EventWindow, KeepsTheNewestEventsAtAnyTimeStamp) {
  constexpr std::int64_t earliest = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t latest = std::numeric_limits<std::int64_t>::max();
  EventWindowConfig config;
  config.events = 2;
  Follower follower(config);
  EventWindow& window = follower.window();
  const std::int64_t lifetime_us = window.lifetime_us({});
  window.push(earliest, {1, 0, 0}, lifetime_us);
  window.push(earliest + 1, {2, 0, 0}, lifetime_us);
  EXPECT_THAT(follower.inside(earliest + 1), testing::ElementsAre(1, 2));
  EXPECT_THAT(follower.inside(0), testing::ElementsAre(1, 2));
  window.push(latest, {3, 0, 0}, lifetime_us);
  EXPECT_THAT(follower.inside(latest), testing::ElementsAre(2, 3));
  EXPECT_FALSE(window.outlived(earliest, 1, latest));
  EXPECT_TRUE(window.outlived(earliest, 2, latest));
}

TEST(EventWindow, ContainsTheNewestEventsWithinTheirLifetimeAtEveryUpdate) {
  for (const WindowKind kind : {WindowKind::count, WindowKind::time, WindowKind::lifetime}) {
    for (const std::int64_t most : {1, 5, 100}) {
      EventWindowConfig config = event_window(kind);
      config.events = most;
      config.duration_us = 60;
      config.shortest_us = 10;
      config.longest_us = 200;
      config.crossing_px = 2.0;
      for (const std::uint64_t seldom : {1, 3, 40, 300}) {
        SCOPED_TRACE(std::string(word_of(kind)) + ", " + std::to_string(most) + " events, asked every " +
                     std::to_string(seldom));
        const RandomStream random(seldom, std::string(word_of(kind)));
        Follower follower(config);
        std::vector<std::pair<std::int64_t, double>> sent;  // t_us, lifetime_us
        std::int64_t t_us = 0;
        std::int64_t now_us = 0;
        for (std::uint64_t i = 0; i < 900; ++i) {
          t_us += static_cast<std::int64_t>(random.bits(0, i) % 5);
          std::optional<NormalFlow> flow;
          double lifetime_us = kind == WindowKind::count ? 1e18 : 60.0;
          const auto steepness = static_cast<double>(i % 40);
          if (random.bits(1, i) % 4 != 0) flow = NormalFlow{-3.0 * steepness, 4.0 * steepness};
          if (kind == WindowKind::lifetime) {
            lifetime_us = flow ? std::clamp(10.0 * steepness, 10.0, 200.0) : 0.0;
          }
          EventWindow& window = follower.window();
          window.push(t_us, {static_cast<std::uint16_t>(i), 0, 0}, window.lifetime_us(flow));
          sent.emplace_back(t_us, lifetime_us);
          now_us = std::max(now_us, t_us);
          if (random.bits(2, i) % seldom != 0) continue;
          now_us += static_cast<std::int64_t>(random.bits(3, i) % 12);  // ahead of late events
          std::multiset<int> expected;
          for (std::size_t k = 0; k < sent.size(); ++k) {
            const bool newest = std::ssize(sent) - static_cast<std::int64_t>(k) <= most;
            const bool alive = static_cast<double>(now_us - sent[k].first) < sent[k].second;
            if (newest && alive) expected.insert(static_cast<int>(k));
          }
          ASSERT_EQ(follower.inside(now_us), expected);
        }
      }
    }
  }
}

TEST(EventWindow, PredictsWhichEventsWillBeOutsideWhateverTheirFlow) {
  EventWindowConfig config = event_window(WindowKind::lifetime);
  config.events = 10;
  config.longest_us = 5'000;
  const EventWindow lifetime(config);
  EXPECT_FALSE(lifetime.outlived(1'000, 9, 5'999));
  EXPECT_TRUE(lifetime.outlived(1'000, 10, 1'000));
  EXPECT_TRUE(lifetime.outlived(1'000, 0, 6'000));
  const EventWindow count(event_window(WindowKind::count));
  EXPECT_FALSE(count.outlived(0, 1'499, 1'000'000'000'000));
  EXPECT_TRUE(count.outlived(0, 1'500, 0));
}

TEST(EventWindow, DoesNotAllocate) {
  for (const WindowKind kind : {WindowKind::count, WindowKind::time, WindowKind::lifetime}) {
    EventWindowConfig config = event_window(kind);
    config.events = 200;
    EventWindow window(config);
    std::size_t changes = 0;
    const std::int64_t before = allocation_count();
    for (int i = 0; i < 5'000; ++i) {
      window.push(i * 10, {}, window.lifetime_us(NormalFlow{i % 100 * 10.0, 0.0}));
      if (i % 7 != 0) continue;
      const auto change = window.update(i * 10);
      changes += change.left.size() + change.entered.size();
    }
    EXPECT_EQ(allocation_count() - before, 0) << word_of(kind);
    EXPECT_GT(changes, 5'000U);
  }
}

TEST(EventWindow, NamesTheKeysOfABadConfiguration) {
  const auto message = [](auto change) -> std::string {
    EventWindowConfig config;
    change(config);
    try {
      EventWindow window(config);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(message([](auto& c) { c.kind = static_cast<WindowKind>(7); }),
              HasSubstr("window.kind: found nothing"));
  EXPECT_THAT(message([](auto& c) { c.events = 0; }), HasSubstr("window.events: found 0"));
  EXPECT_EQ(message([](auto& c) { c.duration_us = -1; }), "accepted");  // a window by count has no duration
  EXPECT_THAT(message([](auto& c) {
                c.kind = WindowKind::time;
                c.duration_us = 0;
              }),
              HasSubstr("window.duration_us: found 0"));
  EXPECT_THAT(message([](auto& c) {
                c.kind = WindowKind::lifetime;
                c.shortest_us = 400'000;
              }),
              HasSubstr("window.longest_us: found 300000, expected at least shortest_us"));
}

}  // namespace
}  // namespace saccade
