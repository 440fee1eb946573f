#include "robot/event_timeline.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "core/random.h"
#include "robot/event_queue.h"
#include "robot/sender_clock.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

EventTimelineConfig config(PacketFormat format, int stamp_bits = 30) {
  EventTimelineConfig config;
  config.image_size = {128, 128};
  config.format = format;
  config.stamp_bits = stamp_bits;
  return config;
}

WireEvent wire(int x, int y, std::int64_t ticks = 0, int stamp_bits = 30) {
  const Event event{0, static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), true, 0};
  return {static_cast<std::uint32_t>(ticks & ((std::int64_t{1} << stamp_bits) - 1)),
          encode_address(event, AddressCodec::ev2)};
}

std::vector<std::int64_t> times(const std::vector<Event>& events) {
  std::vector<std::int64_t> t_us;
  for (const Event& event : events) t_us.push_back(event.t_us);
  return t_us;
}

std::vector<Event> add(EventTimeline& timeline, const EventPacket& packet,
                       std::optional<std::int64_t> sent_us, std::int64_t arrival_us) {
  std::vector<Event> events;
  timeline.add(packet, sent_us, arrival_us, events);
  return events;
}

TEST(SenderClock, TheMessageWithTheLeastDelaySetsTheOffset) {
  SenderClock clock;
  EXPECT_EQ(clock.to_local(5'000'000, 300), 300);
  EXPECT_EQ(clock.to_local(5'001'000, 1'900), 1'300) << "600 us late";
  EXPECT_EQ(clock.to_local(5'002'000, 2'200), 2'200) << "100 us earlier than ever";
  EXPECT_EQ(clock.to_local(5'003'000, 3'300), 3'200);
}

TEST(SenderClock, ClockDriftIsCompensated) {
  SenderClock clock;
  const RandomStream random(1, "drift");
  double worst_us = 0.0;
  for (std::int64_t i = 0; i < 120'000; ++i) {
    const std::int64_t t_us = i * 1000;
    const auto sent_us = static_cast<std::int64_t>(static_cast<double>(t_us) * (1.0 - 50e-6)) + 77'000'000;
    const auto delay_us = static_cast<std::int64_t>(random.bits(0, static_cast<std::uint64_t>(i)) % 2000);
    const auto off_us = static_cast<double>(clock.to_local(sent_us, t_us + delay_us) - t_us);
    worst_us = std::max(worst_us, std::abs(off_us));
  }
  std::cout << "50 ppm over 120 s: " << worst_us << " us off at most\n";
  EXPECT_LT(worst_us, 600.0) << "50 ppm of 10 s are 500 us";
}

TEST(SenderClock, AJumpOfTheClockResetsTheOffset) {
  SenderClock clock;
  clock.to_local(5'000'000, 1'000'000);
  EXPECT_EQ(clock.to_local(1'000, 2'000'000), 2'000'000) << "the sender started again";
  EXPECT_EQ(clock.to_local(90'000'000, 2'001'000), 2'001'000) << "its clock was set";
  EXPECT_EQ(clock.to_local(90'001'000, 2'002'000), 2'002'000);
}

TEST(StampCounter, UnwrapsTheCounterAlsoAfterALongPause) {
  for (const int bits : {24, 30, 31, 32}) {
    StampCounter counter(bits);
    std::int64_t ticks = (std::int64_t{1} << bits) - 3000;
    const auto stamp = [&] { return static_cast<std::uint32_t>(ticks & ((std::int64_t{1} << bits) - 1)); };
    const std::int64_t offset = counter.begin(stamp(), 0) - ticks;
    for (int i = 0; i < 10; ++i) {
      ticks += 1000;
      ASSERT_EQ(counter.next(stamp()), ticks + offset) << bits << " bits";
    }
    ticks -= 9000;
    EXPECT_EQ(counter.next(stamp()), ticks + offset) << "a late one from before the wrap";
    for (const double wraps : {0.4, 0.9, 3.7}) {
      const auto silence = static_cast<std::int64_t>(wraps * std::pow(2.0, bits));
      ticks += silence;
      EXPECT_EQ(counter.begin(stamp(), silence + 12'345), ticks + offset) << bits << " bits, " << wraps;
    }
  }
}

TEST(EventTimeline, EventsWithoutStampsAreSpreadOverTheDurationUpToTheEnvelope) {
  EventTimeline timeline(config(PacketFormat::packet));
  const EventPacket packet{4000, {wire(1, 2), wire(3, 4), wire(5, 6), wire(7, 8)}};
  const std::vector<Event> events = add(timeline, packet, 777'000'000, 50'000);
  EXPECT_THAT(times(events), ElementsAre(47'000, 48'000, 49'000, 50'000));
  EXPECT_EQ(events[1], (Event{48'000, 3, 4, true, 0}));
  EXPECT_THAT(times(add(timeline, packet, 777'004'000, 54'700)), ElementsAre(51'000, 52'000, 53'000, 54'000))
      << "it came 0.7 ms late";
  EXPECT_THAT(times(add(timeline, packet, std::nullopt, 60'000)), ElementsAre(57'000, 58'000, 59'000, 60'000))
      << "without an envelope";
}

TEST(EventTimeline, EventsAfterALongPauseAreAtTheEndOfTheDuration) {
  EventTimeline timeline(config(PacketFormat::packet));
  const EventPacket packet{3'000'000, {wire(1, 2), wire(3, 4)}};
  EXPECT_THAT(times(add(timeline, packet, std::nullopt, 5'000'000)), ElementsAre(4'995'000, 5'000'000));
}

TEST(EventTimeline, EventsWithStampsKeepTheirDistances) {
  for (const int bits : {24, 30, 31}) {
    EventTimeline timeline(config(PacketFormat::stamped_packet, bits));
    const RandomStream random(2, "stamped");
    std::int64_t ticks = (std::int64_t{1} << bits) - 1'000'000;
    std::int64_t t_us = 100'000;
    std::vector<std::int64_t> expected;
    std::vector<Event> events;
    for (std::uint64_t i = 0; i < 200; ++i) {
      EventPacket packet{1000, {}};
      for (int k = 0; k < 5; ++k) {
        packet.events.push_back(wire(1, 2, ticks, bits));
        expected.push_back(t_us);
        ticks += 2500;  // 200 us
        t_us += 200;
      }
      const auto late_us = static_cast<std::int64_t>(i == 0 ? 0 : random.bits(0, i) % 3000);
      const std::int64_t arrival_us = t_us - 200 + late_us;
      timeline.add(packet, std::nullopt, arrival_us, events);
      ASSERT_LE(events.back().t_us, arrival_us);
    }
    EXPECT_EQ(times(events), expected) << bits << " bits";
    EXPECT_EQ(timeline.dropped(), 0);
  }
}

TEST(EventTimeline, UnwrapsStampsAfterAPauseLongerThanTheCounter) {
  EventTimeline timeline(config(PacketFormat::vbottle, 24));  // wraps every 1.34 s
  add(timeline, {0, {wire(1, 1, 1000, 24)}}, std::nullopt, 10'000);
  const std::int64_t pause_us = 5'000'000;
  EXPECT_THAT(times(add(timeline, {0, {wire(1, 1, 1000 + pause_us * 25 / 2, 24)}}, std::nullopt,
                        10'000 + pause_us + 300)),
              ElementsAre(10'000 + pause_us));
}

TEST(EventTimeline, ATickIs128NanosecondsWithDvs128) {
  EventTimelineConfig dvs = config(PacketFormat::vbottle, 24);
  dvs.codec = AddressCodec::dvs_128;
  EventTimeline timeline(dvs);
  EXPECT_THAT(
      times(add(timeline, {0, {{0x80000000U + 7'812, 0}, {0x80000000U + 15'625, 0}}}, std::nullopt, 9'000)),
      ElementsAre(8'000, 9'000))
      << "bit 31 is no time";
}

TEST(EventTimeline, TimeStampsNeverDecrease) {
  EventTimeline timeline(config(PacketFormat::stamped_packet));
  const auto ticks = [](std::int64_t t_us) { return t_us * 25 / 2; };
  const std::vector<Event> events =
      add(timeline, {1000, {wire(3, 0, ticks(20'000)), wire(1, 0, ticks(18'000)), wire(2, 0, ticks(19'000))}},
          std::nullopt, 20'000);
  EXPECT_THAT(times(events), ElementsAre(18'000, 19'000, 20'000)) << "sorted";
  EXPECT_EQ(events.front().x, 1);
  EXPECT_THAT(times(add(timeline, {1000, {wire(1, 0, ticks(16'000)), wire(2, 0, ticks(21'000))}},
                        std::nullopt, 21'000)),
              ElementsAre(20'000, 21'000))
      << "4 ms behind: it comes as now";
  EXPECT_EQ(timeline.dropped(), 0);
  EXPECT_THAT(times(add(timeline, {1000, {wire(1, 0, ticks(10'000)), wire(2, 0, ticks(22'000))}},
                        std::nullopt, 22'000)),
              ElementsAre(22'000));
  EXPECT_EQ(timeline.dropped(), 1) << "11 ms behind";
}

TEST(EventTimeline, EventsOutsideTheImageAndOfTheSkinAreDroppedAndCounted) {
  EventTimeline timeline(config(PacketFormat::packet));
  EventPacket packet{1000, {wire(128, 5), wire(5, 128), wire(127, 127), wire(1, 1)}};
  packet.events[3].address |= 1U << 24;
  EXPECT_THAT(add(timeline, packet, std::nullopt, 5'000), SizeIs(1));
  EXPECT_EQ(timeline.dropped(), 3);
}

TEST(EventTimeline, SwapsAndFlipsAxesAsConfigured) {
  EventTimelineConfig dvs_2016 = config(PacketFormat::packet);
  dvs_2016.image_size = {128, 100};
  dvs_2016.swap_xy = true;
  dvs_2016.flip_y = true;
  EventTimeline timeline(dvs_2016);
  const std::vector<Event> events = add(timeline, {1000, {wire(10, 120)}}, std::nullopt, 5'000);
  ASSERT_THAT(events, SizeIs(1));
  EXPECT_EQ(events[0], (Event{5'000, 120, 89, true, 0}));
  EventTimelineConfig flipped = config(PacketFormat::packet);
  flipped.flip_x = true;
  flipped.camera = 1;
  EventTimeline other(flipped);
  EXPECT_EQ(add(other, {1000, {wire(10, 120)}}, std::nullopt, 5'000).at(0),
            (Event{5'000, 117, 120, true, 1}));
}

TEST(EventTimeline, AnEmptyPacketHasNoEvents) {
  EventTimeline timeline(config(PacketFormat::stamped_packet));
  EXPECT_THAT(add(timeline, {1000, {}}, 5, 5'000), IsEmpty());
}

Event at(std::int64_t t_us) { return {t_us, 0, 0, false, 0}; }

TEST(EventQueue, GivesEachEventOnceUpToTheRequestedTime) {
  EventQueue queue(10);
  const std::vector<Event> pushed = {at(1), at(2), at(2), at(5)};
  queue.push(pushed);
  std::vector<Event> events;
  queue.pop_until(2, events);
  EXPECT_THAT(times(events), ElementsAre(1, 2, 2));
  queue.pop_until(4, events);
  EXPECT_THAT(events, SizeIs(3));
  EXPECT_EQ(queue.size(), 1);
  queue.pop_until(5, events);
  EXPECT_EQ(events, pushed);
  EXPECT_EQ(queue.dropped(), 0);
}

TEST(EventQueue, BetweenTwoThreadsEveryEventIsWholeInOrderAndReadOrDropped) {
  constexpr std::int64_t count = 400'000;
  EventQueue queue(512);
  std::thread sender([&] {
    std::vector<Event> packet;
    for (std::int64_t t_us = 1; t_us <= count; ++t_us) {
      packet.push_back({t_us, static_cast<std::uint16_t>(t_us % 128), static_cast<std::uint16_t>(t_us % 97),
                        t_us % 2 == 0, static_cast<std::uint8_t>(t_us % 2)});
      if (packet.size() < 7) continue;
      queue.push(packet);
      packet.clear();
    }
    queue.push(packet);
  });
  std::vector<Event> events;
  std::int64_t newest_us = 0;
  std::int64_t read = 0;
  while (newest_us < count) {
    events.clear();
    queue.pop_until(count, events);
    for (const Event& event : events) {
      ASSERT_GT(event.t_us, newest_us);
      newest_us = event.t_us;
      ASSERT_EQ(event.x, newest_us % 128);
      ASSERT_EQ(event.y, newest_us % 97);
      ASSERT_EQ(event.on, newest_us % 2 == 0);
    }
    read += static_cast<std::int64_t>(events.size());
  }
  sender.join();
  EXPECT_EQ(read + queue.dropped(), count);
}

TEST(CameraView, NamesACameraOfAnotherSizeAnotherCodecAndASinglePolarity) {
  CameraView view{2000, 0, 1000, 120, 119};
  EXPECT_EQ(view.problem({128, 128}), "");
  view = {2000, 1900, 1000, 303, 239};
  EXPECT_THAT(view.problem({128, 128}),
              HasSubstr("95 % of the events lie outside 128 x 128 pixels (largest x 303, y 239)"));
  view = {2000, 0, 1000, 127, 100};
  EXPECT_THAT(view.problem({304, 240}), HasSubstr("the events fill 128 x 101 pixels of 304 x 240"));
  view = {2000, 0, 2000, 120, 119};
  EXPECT_THAT(view.problem({128, 128}), HasSubstr("100 % of the events are ON"));
  view.events = 999;
  EXPECT_EQ(view.problem({128, 128}), "") << "too few to tell";
}

TEST(EventTimeline, ABrightEdgeThatMovesMakesOnEventsWithBothMeaningsOfThePolarityBit) {
  // Luminance is 1 left of the edge and 0.1 right of it. The bit as two kinds of cameras send it for a change of luminance:
  // event-driven's own (1: darker), and its bridges to Prophesee cameras, which pass on Prophesee's bit (1: brighter).
  const auto luminance = [](int x, double edge_x) { return x < edge_x ? 1.0 : 0.1; };
  for (const bool one_is_brighter : {false, true}) {
    for (const double step_px : {1.0, -1.0}) {
      EventTimelineConfig config;
      config.image_size = {128, 128};
      config.swap_polarity = one_is_brighter;
      EventTimeline timeline(config);
      std::vector<Event> events;
      for (int k = 1; k <= 20; ++k) {
        EventPacket packet{1000, {}};
        for (int x = 0; x < 128; ++x) {
          const double change = luminance(x, 64.0 + k * step_px) - luminance(x, 64.0 + (k - 1) * step_px);
          if (change == 0.0) continue;
          const std::uint32_t bit = (change > 0.0) == one_is_brighter ? 1U : 0U;
          packet.events.push_back({0, static_cast<std::uint32_t>(x) << 1 | 60U << 12 | bit});  // ev2
        }
        timeline.add(packet, std::nullopt, 10'000 + 1000 * k, events);
      }
      ASSERT_THAT(events, SizeIs(20));
      for (const Event& event : events)
        EXPECT_EQ(event.on, step_px > 0.0) << "a bright edge that moves to the right makes pixels brighter";
    }
  }
}

TEST(EventTimeline, SwapsPolarityAndCountsWhatItSees) {
  EventTimelineConfig swapped;
  swapped.image_size = {128, 128};
  swapped.swap_polarity = true;
  EventTimeline timeline(swapped);
  EventPacket packet{1000, {}};
  packet.events.push_back({0, encode_address({0, 5, 6, true, 0}, swapped.codec)});
  packet.events.push_back({0, encode_address({0, 200, 6, false, 0}, swapped.codec)});
  std::vector<Event> events;
  timeline.add(packet, std::nullopt, 10'000, events);
  ASSERT_THAT(events, SizeIs(1));
  EXPECT_FALSE(events[0].on);
  EXPECT_EQ(timeline.view().events, 2);
  EXPECT_EQ(timeline.view().outside, 1);
  EXPECT_EQ(timeline.view().max_x, 200);
}

TEST(EventQueue, DropsTheOldestEventsIfItIsFull) {
  EventQueue queue(4);
  std::vector<Event> events;
  queue.push(std::vector<Event>{at(1), at(2), at(3)});
  queue.pop_until(1, events);
  queue.push(std::vector<Event>{at(4), at(5), at(6)});
  EXPECT_EQ(queue.size(), 4);
  EXPECT_EQ(queue.dropped(), 1);
  events.clear();
  queue.pop_until(100, events);
  EXPECT_THAT(times(events), ElementsAre(3, 4, 5, 6));
  events.clear();
  queue.push(std::vector<Event>{at(7), at(8), at(9), at(10), at(11), at(12)});
  queue.pop_until(100, events);
  EXPECT_THAT(times(events), ElementsAre(9, 10, 11, 12));
  EXPECT_EQ(queue.dropped(), 3);
}

}  // namespace
}  // namespace saccade
