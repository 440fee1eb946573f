#include "recording/event_statistics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "core/random.h"

namespace saccade {
namespace {

EventStatistics statistics_of(const std::vector<Event>& events, std::optional<ImageSize> size = std::nullopt,
                              std::int64_t gap_us = 100'000) {
  EventCounter counter(size, gap_us);
  counter.add(std::span(events).first(events.size() / 2));
  counter.add(std::span(events).subspan(events.size() / 2));
  return counter.all();
}

TEST(EventStatistics, CountEventsTimesAndGaps) {
  const EventStatistics s = statistics_of({{1000, 3, 4, true, 0},
                                           {1500, 9, 0, false, 0},
                                           {1400, 1, 7, true, 0},
                                           {900, 0, 0, false, 0},
                                           {3'001'000, 2, 2, true, 0}},
                                          ImageSize{9, 8});
  EXPECT_EQ(s.count, 5);
  EXPECT_EQ(s.on, 3);
  EXPECT_EQ(s.first_us, 1000);
  EXPECT_EQ(s.oldest_us, 900);
  EXPECT_EQ(s.newest_us, 3'001'000);
  EXPECT_DOUBLE_EQ(s.duration_s(), 3.0001);
  EXPECT_DOUBLE_EQ(s.mean_rate_hz().value(), 5 / 3.0001);
  EXPECT_EQ(s.reach, (ImageSize{10, 8}));
  EXPECT_EQ(s.outside_image, 1);
  EXPECT_EQ(s.back_in_time, 2);
  EXPECT_EQ(s.longest_step_back_us, 600);
  EXPECT_EQ(s.longest_gap_us, 2'999'500) << "from the newest event, not from the last one";
  EXPECT_EQ(s.longest_gap_at_us, 1500);
  EXPECT_EQ(s.gaps, 1);
}

TEST(EventStatistics, BinsBeginAtTheFirstEventAndEmptyOnesAreSkipped) {
  std::vector<Event> events;
  const auto burst = [&](std::int64_t first_us, int count, std::int64_t step_us) {
    for (int i = 0; i < count; ++i) events.push_back({first_us + i * step_us, 0, 0, true, 0});
  };
  burst(500, 10, 50);              // bin of 1 ms [500, 1500)
  burst(1500, 30, 10);             // the next one
  burst(700'500, 25, 40);          // one bin of 1 ms, exactly
  burst(1'000'000'000, 40, 2000);  // one bin of 100 ms after a long silence
  const EventStatistics s = statistics_of(events);
  EXPECT_EQ(s.most_in_1ms, 30);
  EXPECT_EQ(s.most_in_100ms, 40);
  EXPECT_EQ(s.gaps, 2);
}

// Events in order of one camera are counted in a faster way than those of two.
TEST(EventStatistics, OfOneCameraDoNotDependOnTheOther) {
  const auto figures = [](const EventStatistics& s) {
    return std::tuple(s.count, s.on, s.first_us, s.oldest_us, s.newest_us, s.reach.width, s.reach.height,
                      s.outside_image, s.back_in_time, s.longest_step_back_us, s.longest_gap_us,
                      s.longest_gap_at_us, s.gaps, s.most_in_1ms, s.most_in_100ms);
  };
  for (std::uint64_t trial = 0; trial < 200; ++trial) {
    const RandomStream random(trial, "statistics");
    std::vector<Event> events;
    std::int64_t t_us = trial % 2 == 0 ? 0 : -5'000'000;
    for (std::uint64_t i = 0; i < 3'000; ++i) {
      const double pause = random.uniform(0.0, 1.0, 0, i);
      t_us += pause < 0.99 ? std::llround(300.0 * pause * pause * pause)
                           : std::llround(4e5 * random.uniform(0.0, 1.0, 1, i));
      if (trial % 5 == 4 && i % 700 == 699) t_us -= 50;  // not in order
      events.push_back({t_us, static_cast<std::uint16_t>(random.uniform(0.0, 70.0, 2, i)),
                        static_cast<std::uint16_t>(random.uniform(0.0, 50.0, 3, i)),
                        random.uniform(0.0, 1.0, 4, i) < 0.5, 0});
    }
    EventCounter alone(ImageSize{64, 48}, 100'000), beside(ImageSize{64, 48}, 100'000);
    beside.add(std::vector<Event>{{t_us, 1, 1, true, 1}});
    for (std::size_t begin = 0; begin < events.size();) {
      const auto block = std::span(events).subspan(
          begin,
          std::min(events.size() - begin, static_cast<std::size_t>(random.uniform(1.0, 900.0, 5, begin))));
      alone.add(block);
      beside.add(block);
      begin += block.size();
    }
    EXPECT_EQ(figures(alone.all()), figures(beside.camera(0))) << trial;
  }
}

TEST(EventStatistics, AreKeptForEachCamera) {
  EventCounter counter(std::nullopt, 1000);
  counter.add(std::vector<Event>{{10, 1, 1, true, 0}, {20, 1, 1, false, 1}, {30, 1, 1, true, 1}});
  EXPECT_EQ(counter.all().count, 3);
  EXPECT_EQ(counter.camera(0).count, 1);
  EXPECT_EQ(counter.camera(1).count, 2);
  EXPECT_EQ(counter.camera(1).first_us, 20);
  EXPECT_EQ(counter.camera(1).longest_gap_us, 10);
  EXPECT_EQ(counter.camera(0).mean_rate_hz(), std::nullopt);
}

TEST(EventStatistics, DifferencesOfExtremeTimesAreLimitedToTheRangeOfInt64) {
  constexpr std::int64_t least = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t largest = std::numeric_limits<std::int64_t>::max();
  EventCounter counter(std::nullopt, 1000);
  counter.add(std::vector<Event>{{least, 1, 1, true, 0}, {largest, 1, 1, true, 0}, {least, 1, 1, true, 0}});
  const EventStatistics& s = counter.all();
  EXPECT_EQ(s.longest_gap_us, largest);
  EXPECT_EQ(s.longest_gap_at_us, least);
  EXPECT_EQ(s.gaps, 1);
  EXPECT_EQ(s.longest_step_back_us, largest);
  EXPECT_EQ(s.back_in_time, 1);
  EXPECT_GT(s.duration_s(), 9e12);
  EXPECT_GT(s.mean_rate_hz().value(), 0.0);
}

}  // namespace
}  // namespace saccade
