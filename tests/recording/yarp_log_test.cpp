#include <cmath>

#include "tests/recording/read_events.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::uint32_t skin = 1u << 24;

std::uint32_t address(int x, int y, bool on, int camera) {
  return static_cast<std::uint32_t>(on ? 0 : 1) | static_cast<std::uint32_t>(x) << 1 |
         static_cast<std::uint32_t>(y) << 12 | static_cast<std::uint32_t>(camera) << 22;
}

std::vector<Event> read_text(const std::string& content) {
  const TempFolder folder;
  return read_file(folder.write("data.log", content));
}

TEST(YarpLog, DecodesThe24BitCodecOfBothCamerasWithZeroForOn) {
  // 0x0040700b: polarity 1, x 5, y 7, channel 1. Bits 21 and 23 are corner and type, no part of the event.
  EXPECT_EQ(read_text("0 1.000000 AE (25 " + std::to_string(0x0040700b) + ")\n"),
            (std::vector<Event>{{2, 5, 7, false, 1}}));
  const std::uint32_t labelled = address(303, 239, true, 0) | 1u << 21 | 1u << 23;
  EXPECT_EQ(read_text("0 1.5 AE (0 " + std::to_string(labelled) + ")\n"),
            (std::vector<Event>{{0, 303, 239, true, 0}}));
}

TEST(YarpLog, RoundsTicksOf80NanosecondsToTheNearestMicrosecond) {
  std::string content;
  std::vector<std::int64_t> expected;
  for (std::int64_t ticks = 383033170; ticks < 383033270; ++ticks) {
    content += "7 1.0 AE (" + std::to_string(ticks) + " 0)\n";
    expected.push_back(std::llround(static_cast<double>(ticks) * 0.08));
  }
  std::vector<std::int64_t> t_us;
  for (const Event& event : read_text(content)) t_us.push_back(event.t_us);
  EXPECT_EQ(t_us, expected);
}

TEST(YarpLog, IsToldByItsFirstLineAndHasTheSizeOfTheAtis) {
  const TempFolder folder;
  const auto path = folder.write("recording", "0 1.5 AE (0 2)\r\n\n3 1.5 1.6 AE (25 2 50 2) \n");
  const auto reader = open_event_file(path);
  EXPECT_THAT(reader->format(), HasSubstr("event-driven"));
  EXPECT_EQ(reader->image_size(), (ImageSize{304, 240}));
  EXPECT_EQ(read_all(*reader, 1).size(), 3u);
  EventReadOptions options;
  options.image_size = ImageSize{640, 480};
  EXPECT_EQ(open_event_file(path, options)->image_size(), options.image_size);
}

TEST(YarpLog, MayHaveAPacketLongerThanAnyBuffer) {
  std::string content = "0 1.5 AE (";
  std::vector<Event> expected;
  for (int i = 0; i < 200'000; ++i) {
    content +=
        (i > 0 ? " " : "") + std::to_string(25 * i) + " " + std::to_string(address(i % 304, 9, true, 1));
    expected.push_back({2 * i, static_cast<std::uint16_t>(i % 304), 9, true, 1});
  }
  ASSERT_GT(content.size(), 2u << 20);
  EXPECT_EQ(read_text(content + ")\n"), expected);
}

TEST(YarpLog, PassesOverAndCountsWhatIsNotVision) {
  const TempFolder folder;
  const auto path = folder.write(
      "data.log", "0 1.5 AE (0 " + std::to_string(skin) + " 25 " + std::to_string(address(1, 2, true, 0)) +
                      ") FLOW (1 2 (3 x) 4)\n1 1.5 IMUS (5)\n2 1.5 AE ()\n3 1.6 AE (50 " +
                      std::to_string(skin | address(3, 4, true, 0)) + ")\n");
  const auto reader = open_event_file(path);
  EXPECT_EQ(reader->passed_over(), "");
  EXPECT_EQ(read_all(*reader), (std::vector<Event>{{2, 1, 2, true, 0}}));
  EXPECT_EQ(reader->passed_over(), "2 skin events, 2 lists not AE");
}

/// Times in ticks of the events of a log whose packets have a host time (s) and a stamp each.
std::vector<std::int64_t> ticks_of(const std::vector<std::pair<double, std::int64_t>>& packets) {
  std::string content;
  for (const auto& [host_s, stamp] : packets) {
    // Stamps are multiples of 25 ticks or 2 us, so that nothing is lost on the way.
    content += "0 " + std::to_string(host_s) + " AE (" + std::to_string(25 * stamp) + " 0)\n";
  }
  std::vector<std::int64_t> ticks;
  for (const Event& event : read_text(content)) ticks.push_back(event.t_us * 25 / 2);
  return ticks;
}

TEST(YarpLog, TimeGoesOnAcrossTheWrapOfACounterOfAnyWidth) {
  for (int bits = 24; bits <= 31; ++bits) {
    // Every 0.37 s for 2.2 rounds of the counter, its first stamp in mid-range.
    const std::int64_t range = std::int64_t{1} << bits;
    const std::int64_t step = 4'625'000;
    std::string content;
    std::vector<std::int64_t> expected;
    const std::int64_t first = range / 3 * 2;
    for (std::int64_t ticks = first; ticks < first + range * 11 / 5; ticks += step) {
      // The host's clock is up to 0.1 s off.
      const double host_s =
          1e9 + static_cast<double>(ticks) * 80e-9 + 0.1 * std::sin(static_cast<double>(ticks));
      content += "0 " + std::to_string(host_s) + " AE (" + std::to_string(ticks % range) + " 0)\n";
      expected.push_back((ticks * 4 + 25) / 50);
    }
    std::vector<std::int64_t> t_us;
    for (const Event& event : read_text(content)) t_us.push_back(event.t_us);
    EXPECT_EQ(t_us, expected) << bits;
  }
}

TEST(YarpLog, AnEventThatIsLateAcrossAWrapStaysBeforeIt) {
  const std::int64_t wrap = (std::int64_t{1} << 30) / 25;
  EXPECT_THAT(ticks_of({{1.00, wrap - 100}, {1.01, 50}, {1.01, wrap - 60}, {1.02, 900}}),
              ElementsAre(25 * (wrap - 100), testing::_, 25 * (wrap - 60), testing::_));
}

TEST(YarpLog, ALongSilenceIsNoWrap) {
  EXPECT_THAT(ticks_of({{1.0, 1000}, {41.0, 20'001'000}}), ElementsAre(25'000, 500'025'000));
}

struct BrokenLog {
  std::string name;
  std::string line;
  std::string message;
};

class BrokenYarpLog : public testing::TestWithParam<BrokenLog> {};

TEST_P(BrokenYarpLog, GivesTheEventsBeforeItAndThenItsLine) {
  const TempFolder folder;
  const auto path = folder.write(
      "data.log", "1 1.5 AE (0 2 25 4)\n2 1.6 AE (50 6)\n" + GetParam().line + "\n4 1.7 AE (9 2)\n");
  expect_events_then_error(path, {{0, 1, 0, true, 0}, {2, 2, 0, true, 0}, {4, 3, 0, true, 0}},
                           ":3: found " + GetParam().message);
}

INSTANTIATE_TEST_SUITE_P(
    Recording, BrokenYarpLog,
    testing::Values(
        BrokenLog{"NoNumber", "AE (1 2)", "AE, expected the number"},
        BrokenLog{"NoTime", "3 AE (1 2)", "AE, expected a time"},
        BrokenLog{"NotATime", "3 nan AE (1 2)", "nan, expected a time"},
        BrokenLog{"NoList", "3 1.5 AE 1000", "1, expected a list"},
        BrokenLog{"ListNotClosed", "3 1.5 AE (", "the end of the line"},
        BrokenLog{"OtherListNotClosed", "3 1.5 FLOW ((1 2)", "the end of the line"},
        BrokenLog{"StampAlone", "3 1.5 AE (7)", "), expected"},
        BrokenLog{"StampOfBefore2018", "3 1.5 AE (-2147483525 2)", "-2147483525, expected a time stamp"},
        BrokenLog{"StampTooLarge", "3 1.5 AE (2147483648 2)", "2147483648, expected a time stamp"},
        BrokenLog{"AddressNegative", "3 1.5 AE (1 -2)", "-2, expected an address"},
        BrokenLog{"AddressOfLetters", "3 1.5 AE (1 x)", "x, expected an address"},
        BrokenLog{"NulByte", std::string("\0", 1), "., expected"},
        BrokenLog{"WordTooLong", "3 1.5 AE (" + std::string(100, '1') + " 2)", "1111"},
        BrokenLog{"TwoPacketsInALine", "3 1.5 AE () 4 1.6 AE ()", "1, expected a list"}),
    [](const auto& broken) { return broken.param.name; });

TEST(YarpLog, CutAtAnyByteGivesTheEventsBeforeTheCutAndThenAnErrorOrACleanEnd) {
  const std::string whole = "1 1.5 AE (100 2 125 4)\n2 1.6 AE (150 6)\n3 1.7 AE (1750 8) FLOW (1 2)\n";
  const auto events = read_text(whole);
  ASSERT_EQ(events.size(), 4u);
  // Clean: behind each bracket, line end and time, and the blanks after them; not told apart from text: the
  // first line before its bracket, which is refused as such.
  EXPECT_GE(count_errors_of_cut_files(whole, events), whole.size() - 13);
}

TEST_F(RealRecording, TheBouncingBallHasItsCountAndItsFirstAndLastEvents) {
  const auto events = read_real("ball_bounce_atis304x240_yarp.log");
  ASSERT_EQ(events.size(), 32532u);
  // Ticks 383033170, 383424290, 383493890, 383493900, 384032833 and 581512566.
  EXPECT_EQ(std::vector<Event>(events.begin(), events.begin() + 5),
            (std::vector<Event>{{30642654, 12, 178, false, 1},
                                {30673943, 8, 0, false, 1},
                                {30679511, 208, 170, false, 1},
                                {30679512, 208, 170, true, 1},
                                {30722627, 9, 79, true, 1}}));
  EXPECT_EQ(events.back(), (Event{46521005, 17, 45, false, 1}));
  const ImageSize atis{304, 240};
  for (const Event& event : events) ASSERT_TRUE(event.camera == 1 && atis.contains(event.x, event.y));
}

TEST_F(RealRecording, OfSkinHasNoEventsAndSaysWhatItHas) {
  const auto reader = open_event_file(path_of("icub_skin_yarp_AE.log"));
  EXPECT_TRUE(read_all(*reader).empty());
  EXPECT_EQ(reader->passed_over(), "124784 skin events");
}

}  // namespace
}  // namespace saccade
