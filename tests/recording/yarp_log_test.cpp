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

TEST(YarpLog, IsRecognisedByItsFirstLineAndHasTheSizeOfTheAtis) {
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

TEST(YarpLog, SkipsAndCountsListsThatAreNoCameraEvents) {
  const TempFolder folder;
  const auto path = folder.write(
      "data.log", "0 1.5 AE (0 " + std::to_string(skin) + " 25 " + std::to_string(address(1, 2, true, 0)) +
                      ") FLOW (1 2 (3 x) 4)\n1 1.5 IMUS (5)\n2 1.5 AE ()\n3 1.6 AE (50 " +
                      std::to_string(skin | address(3, 4, true, 0)) + ")\n");
  const auto reader = open_event_file(path);
  EXPECT_EQ(read_all(*reader), (std::vector<Event>{{2, 1, 2, true, 0}}));
  EXPECT_EQ(reader->skipped(), "2 skin events, 2 lists not AE");
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

TEST(YarpLog, TimeContinuesOverTheWrapOfACounterOfAnyWidth) {
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
        BrokenLog{"TimeTooLate", "3 4000000000.5 AE (1 2)", "4000000000.5, expected a time"},
        BrokenLog{"NoList", "3 1.5 AE FLOW", "F, expected a list"},
        BrokenLog{"NoBytes", "3 1.5 AE 1000", "the end of the line, expected a packet's bytes"},
        BrokenLog{"BytesNotInWords", "3 1.5 AE 1000 \"abc\"", "3 bytes in quotes, expected words"},
        BrokenLog{"BytesNotClosed", "3 1.5 AE 1000 \"abc", "the end of the file, expected the rest"},
        BrokenLog{"ListNotClosed", "3 1.5 AE (", "the end of the line"},
        BrokenLog{"OtherListNotClosed", "3 1.5 FLOW ((1 2)", "the end of the line"},
        BrokenLog{"StampAlone", "3 1.5 AE (7)", "), expected"},
        BrokenLog{"StampTooLarge", "3 1.5 AE (2147483648 2)", "2147483648, expected a time stamp"},
        BrokenLog{"AddressNegative", "3 1.5 AE (1 -2)", "-2, expected an address"},
        BrokenLog{"AddressOfLetters", "3 1.5 AE (1 x)", "x, expected an address"},
        BrokenLog{"NulByte", std::string("\0", 1), "., expected"},
        BrokenLog{"WordTooLong", "3 1.5 AE (" + std::string(100, '1') + " 2)", "1111"},
        BrokenLog{"TwoPacketsInALine", "3 1.5 AE () 4 1.6 AE ()", "1.6, expected a duration"}),
    [](const auto& broken) { return broken.param.name; });

TEST(YarpLog, CutAtAnyByteGivesTheEventsBeforeTheCutAndThenAnErrorOrACleanEnd) {
  const std::string whole = "1 1.5 AE (100 2 125 4)\n2 1.6 AE (150 6)\n3 1.7 AE (1750 8) FLOW (1 2)\n";
  const auto events = read_text(whole);
  ASSERT_EQ(events.size(), 4u);
  // Clean: behind each bracket, line end and time, and the blanks after them; not told apart from text: the
  // first line before its bracket, which is refused as such.
  EXPECT_GE(count_errors_of_cut_files(whole, events), whole.size() - 13);
}

// ---- codecs --------------------------------------------------------------------------------------

std::vector<Event> read_as(const std::string& codec, const std::string& content) {
  const TempFolder folder;
  EventReadOptions options;
  options.yarp_codec = codec;
  return read_file(folder.write("data.log", content), options);
}

TEST(YarpCodecs, HaveTheirBitsAsDocumentedWithPolarityZeroForOn) {
  // Polarity 1, x 5, y 7, channel 1 in each of them, at the stamp word of 2016 for 123 ticks.
  const auto log = [](std::uint32_t word) {
    return "0 1.5 AE (" + std::to_string(static_cast<std::int32_t>(0x8000007b)) + " " + std::to_string(word) +
           ")\n";
  };
  EXPECT_EQ(read_as("dvs_128", log(0x870b)), (std::vector<Event>{{16, 5, 7, false, 1}}));
  EXPECT_EQ(read_as("dvs_128_upright", log(0x870b)), (std::vector<Event>{{16, 7, 122, false, 1}}));
  EXPECT_EQ(read_as("atis_20", log(0x101c0b)), (std::vector<Event>{{10, 5, 7, false, 1}}));
  EXPECT_EQ(read_as("atis_24", log(0x40700b)), (std::vector<Event>{{10, 5, 7, false, 1}}));
  EXPECT_EQ(read_as("ev2", log(0x40700b)), (std::vector<Event>{{10, 5, 7, false, 1}}));
  // The last pixel of each.
  EXPECT_EQ(read_as("dvs_128", log(0x7ffe)), (std::vector<Event>{{16, 127, 127, true, 0}}));
  EXPECT_EQ(read_as("dvs_128_upright", log(0x7ffe)), (std::vector<Event>{{16, 127, 0, true, 0}}));
  EXPECT_EQ(read_as("atis_20", log(303u << 1 | 239u << 10)), (std::vector<Event>{{10, 303, 239, true, 0}}));
  EXPECT_EQ(read_as("ev2", log(1279u << 1 | 719u << 12)), (std::vector<Event>{{10, 1279, 719, true, 0}}));
  EXPECT_TRUE(read_as("atis_20", log(1u << 21)).empty()) << "skin";
  EXPECT_THAT([&] { (void)read_as("atis32", log(0)); },
              testing::ThrowsMessage<InputError>(
                  HasSubstr("atis32, expected one of auto, dvs_128, dvs_128_upright")));
}

/// A log of version 1 with 500 events all over the image and a stamp every 10 ticks.
std::string log_with(ImageSize size, int y_bit, std::uint32_t stamp_bit) {
  std::string content;
  for (int i = 0; i < 500; ++i) {
    const auto x = static_cast<std::uint32_t>(i * 37 % size.width);
    const auto y = static_cast<std::uint32_t>(i * 53 % size.height);
    content += std::to_string(i) + " 1.5 AE (" +
               std::to_string(static_cast<std::int32_t>(static_cast<std::uint32_t>(i * 10) | stamp_bit)) +
               " " + std::to_string(x << 1 | y << y_bit) + ")\n";
  }
  return content;
}

TEST(YarpCodecs, AreGuessedFromTheAddressesAndMarkedAsGuessed) {
  const TempFolder folder;
  const auto format = [&](const std::string& content, const EventReadOptions& options = {}) {
    const auto reader = open_event_file(folder.write("data.log", content), options);
    return reader->format() + " " + std::to_string(reader->image_size()->width);
  };
  EXPECT_EQ(format(log_with({128, 128}, 8, 1u << 31)), "event-driven log, codec dvs_128 (guessed) 128");
  EXPECT_EQ(format(log_with({128, 128}, 8, 0)), "event-driven log, codec dvs_128 (guessed) 128");
  EXPECT_EQ(format(log_with({304, 240}, 10, 1u << 31)), "event-driven log, codec atis_20 (guessed) 304");
  EXPECT_EQ(format(log_with({304, 240}, 12, 0)), "event-driven log, codec atis_24 (guessed) 304");
  EXPECT_EQ(format(log_with({640, 480}, 12, 0)), "event-driven log, codec atis_24 (guessed) 304");
  // The option has precedence over the info file, and that over a guess.
  folder.write("info.log",
               "Type: Bottle;\n[1.5] /zynqGrabber/vBottle:o [connected]\nCodec: atis_24;\nSize: 200x100;\n");
  EXPECT_EQ(format(log_with({128, 128}, 8, 0)), "event-driven log, codec atis_24 200");
  EventReadOptions options;
  options.yarp_codec = "atis_20";
  options.image_size = ImageSize{304, 240};
  EXPECT_EQ(format(log_with({128, 128}, 8, 0), options), "event-driven log, codec atis_20 304");
  folder.write("info.log", "Codec: none;\n");
  EXPECT_THAT([&] { (void)open_event_file(folder / "data.log"); },
              testing::ThrowsMessage<InputError>(HasSubstr("info.log: found none, expected one of auto")));
}

TEST(YarpCodecs, TicksOf128NanosecondsAndTheirWrapsAt24BitsAreContinuedOverSilences) {
  // A counter of 24 bits of 128 ns wraps every 2.147 s; the host's clock gives the number of wraps in 10 s.
  std::string content;
  std::vector<std::int64_t> expected;
  for (const std::int64_t ticks : {16'000'000, 16'900'000, 17'000'000, 95'000'000, 95'000'001, 260'000'000}) {
    const double host_s = 1.46e9 + static_cast<double>(ticks) * 128e-9 + (ticks % 2 == 0 ? 0.05 : 0.0);
    const auto word = static_cast<std::int32_t>(static_cast<std::uint32_t>(ticks % (1 << 24)) | 1u << 31);
    content += "0 " + std::to_string(host_s) + " AE (" + std::to_string(word) + " 0)\n";
    expected.push_back(std::llround(static_cast<double>(ticks) * 0.128));
  }
  std::vector<std::int64_t> t_us;
  for (const Event& event : read_as("dvs_128", content)) t_us.push_back(event.t_us);
  EXPECT_EQ(t_us, expected);
}

// ---- version 2 -----------------------------------------------------------------------------------

std::string escaped(const std::vector<std::uint32_t>& words) {
  std::string text;
  for (const std::uint32_t word : words) {
    for (int shift = 0; shift < 32; shift += 8) {
      const char c = static_cast<char>(word >> shift & 0xff);
      text += c == '\0' ? "\\0" : c == '\n' ? "\\n" : c == '\r' ? "\\r" : std::string(1, c);
      if (c == '"' || c == '\\') text.insert(text.size() - 1, 1, '\\');
    }
  }
  return '"' + text + '"';
}

TEST(YarpLog2, HasRawBytesInQuotesAndSpreadsEventsWithoutStampsOverTheirPacket) {
  const TempFolder folder;
  EXPECT_EQ(escaped({0x00014014}), std::string("\"\x14@\x01\\0\""));
  const auto path = folder.write(
      "data.log",
      "0 1795207852.671570 AE 1000 " + escaped({0x00014014, 0x0040700b, skin, 0x0a0d225c & 0x3ffffff}) +
          "\n1 1795207852.672570 AE 1000 \"\"\n2 1795207852.7 IMUS 1000 " + escaped({1, 2}) + "\n");
  const auto reader = open_event_file(path);
  EXPECT_EQ(reader->format(), "event-driven log, codec ev2 (guessed)");
  EXPECT_EQ(reader->image_size(), std::nullopt);
  const std::uint32_t odd = 0x0a0d225c & 0x3ffffff;
  EXPECT_EQ(read_all(*reader, 1),
            (std::vector<Event>{{1795207852670820, 10, 20, true, 0},
                                {1795207852671070, 5, 7, false, 1},
                                {1795207852671570, static_cast<std::uint16_t>(odd >> 1 & 0x7ff),
                                 static_cast<std::uint16_t>(odd >> 12 & 0x3ff), true, 0}}));
  EXPECT_EQ(reader->skipped(), "1 skin events, 1 lists not AE");
}

TEST(YarpLog2, IsTakenForStampedWhereEveryOtherWordRises) {
  const auto log = [](const auto& stamp, bool stamped) {
    std::string content;
    for (std::uint32_t i = 0; i < 50; ++i) {
      std::vector<std::uint32_t> words;
      for (std::uint32_t k = 0; k < 6; ++k) {
        if (stamped) words.push_back(stamp(i * 6 + k));
        words.push_back((i * 41 + k * 17) % 304 << 1 | (i * 29 + k * 3) % 240 << 12);
      }
      content +=
          std::to_string(i) + " " + std::to_string(100 + 0.001 * i) + " AE 1000 " + escaped(words) + "\n";
    }
    return content;
  };
  const TempFolder folder;
  const auto format = [&](const std::string& content) {
    return open_event_file(folder.write("data.log", content))->format();
  };
  const auto small = [](std::uint32_t n) { return 5000 + n * 25; };
  const auto large = [](std::uint32_t n) { return 0x70000000 + n * 25; };
  const auto wrapping = [](std::uint32_t n) { return (0xffffff - 3000 + n * 25) & 0xffffff; };
  EXPECT_EQ(format(log(small, true)), "event-driven log, codec ev2_ts (guessed)");
  EXPECT_EQ(format(log(large, true)), "event-driven log, codec ev2_ts (guessed)");
  EXPECT_EQ(format(log(wrapping, true)), "event-driven log, codec ev2_ts (guessed)");
  EXPECT_EQ(format(log(small, false)), "event-driven log, codec ev2 (guessed)");
  const auto events = read_file(folder.write("data.log", log(wrapping, true)));
  ASSERT_EQ(events.size(), 300u);
  for (std::size_t i = 1; i < events.size(); ++i) ASSERT_EQ(events[i].t_us - events[i - 1].t_us, 2) << i;
}

std::vector<Event> events_of_two_cameras(std::int64_t first_us, std::int64_t step_us) {
  std::vector<Event> events;
  for (int i = 0; i < 20000; ++i) {
    events.push_back({first_us + i * step_us, static_cast<std::uint16_t>(i * 331 % 2048),
                      static_cast<std::uint16_t>(i * 177 % 1024), i % 3 == 0,
                      static_cast<std::uint8_t>(i % 2)});
  }
  return events;
}

TEST(YarpLog2, IsReadBackExactlyAcrossItsWrapsSilencesAndFarFromZero) {
  for (const std::int64_t first_us : std::initializer_list<std::int64_t>{0, 171'000'000, 1605537493718345}) {
    for (const std::int64_t step_us : std::initializer_list<std::int64_t>{1, 333, 86'000'001}) {
      const TempFolder folder;
      auto events = events_of_two_cameras(first_us, step_us);
      std::swap(events[100], events[101]);
      const auto writer = create_event_file(folder / "data.log", {2048, 1024}, 2);
      writer->write(events);
      EXPECT_TRUE(!std::filesystem::exists(folder / "data.log") &&
                  !std::filesystem::exists(folder / "info.log"));
      writer->commit();
      const auto reader = open_event_file(folder / "");
      EXPECT_EQ(reader->format(), "event-driven log, codec ev2_ts");
      EXPECT_EQ(reader->image_size(), (ImageSize{2048, 1024}));
      EXPECT_TRUE(read_all(*reader, 777) == events) << first_us << " " << step_us;
    }
  }
}

TEST(YarpLog2, RejectsWhatItCannotHoldAndLeavesNothing) {
  const TempFolder folder;
  EXPECT_THROW((void)create_event_file(folder / "data.log", {2049, 10}), InputError);
  for (const Event& event : {Event{-1, 0, 0, true, 0}, Event{4'000'000'000'000'000, 0, 0, true, 0},
                             Event{0, 0, 0, true, 1}, Event{0, 640, 0, true, 0}}) {
    const auto writer = create_event_file(folder / "data.log", {640, 480});
    EXPECT_THROW(writer->write(std::span(&event, 1)), InputError);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder / ""));
}

TEST(YarpLog2, CutAtAnyByteGivesThePacketsBeforeTheCutAndThenAnErrorOrACleanEnd) {
  const TempFolder folder;
  std::vector<Event> events;
  for (int i = 0; i < 12; ++i) events.push_back({i * 700, static_cast<std::uint16_t>(i), 0, true, 0});
  const auto writer = create_event_file(folder / "data.log", {304, 240});
  writer->write(events);
  writer->commit();
  const std::string whole = bytes_of(folder / "data.log");
  std::size_t errors = 0;
  for (std::size_t length = 0; length < whole.size(); ++length) {
    folder.write("data.log", whole.substr(0, length));
    std::vector<Event> read;
    try {
      const auto reader = open_event_file(folder / "data.log");
      while (reader->read(read, 1) > 0) {
      }
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("data.log"));
      ++errors;
    }
    EXPECT_TRUE(std::equal(read.begin(), read.end(), events.begin())) << "cut at " << length;
  }
  // Clean: behind each of the 6 packets, with and without the end of its line.
  EXPECT_EQ(errors, whole.size() - 11);
}

// ---- binary --------------------------------------------------------------------------------------

TEST(YarpBinaryLog, IsPairsOfWordsRecognisedByItsNameOrItsInfoFile) {
  const auto bytes = [](const std::vector<std::uint32_t>& words) {
    std::string text;
    for (const std::uint32_t word : words) {
      for (int shift = 0; shift < 32; shift += 8) text += static_cast<char>(word >> shift & 0xff);
    }
    return text;
  };
  const std::vector<Event> expected = {{2, 5, 7, false, 1}, {4, 5, 7, false, 1}};
  const std::string dump = bytes({25, 0x0040700b, 30, skin, 50, 0x0040700b});
  const TempFolder folder;
  const auto named = open_event_file(folder.write("binaryevents.log", dump));
  EXPECT_EQ(named->format(), "event-driven binary log, codec atis_24 (guessed)");
  EXPECT_EQ(read_all(*named, 1), expected);
  EXPECT_EQ(named->skipped(), "1 skin events");
  EXPECT_EQ(read_file(folder / ""), expected);

  const auto other = folder.write("left.log", dump);
  EXPECT_THROW((void)open_event_file(other), InputError);
  folder.write("left.info.log", "Type: Binary;\n[1569859362.954442] /zynqGrabber/AE:o [connected]\n");
  EXPECT_EQ(read_file(other), expected);
  expect_events_then_error(folder.write("binaryevents.log", dump.substr(0, 20)), {expected.front()},
                           "byte 16");

  for (const int bits : {24, 30, 31}) {
    // Without a host's time a step back is a wrap of the counter that holds the stamps so far.
    const std::uint32_t range = 1u << bits;
    const std::uint32_t late = range - 40;
    const auto path = folder.write("binaryevents.log", bytes({range - 50, 0, 25, 0, late, 0, 50, 0}));
    std::vector<std::int64_t> ticks;
    for (const Event& event : read_file(path)) ticks.push_back(event.t_us);
    const auto us = [&](std::int64_t t) { return std::llround(static_cast<double>(t) * 0.08); };
    EXPECT_EQ(ticks, (std::vector<std::int64_t>{us(range - 50), us(std::int64_t{range} + 25), us(late),
                                                us(std::int64_t{range} + 50)}))
        << bits;
  }
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

TEST_F(RealRecording, OfSkinHasNoEventsAndCountsTheSkinEvents) {
  const auto reader = open_event_file(path_of("icub_skin_yarp_AE.log"));
  EXPECT_TRUE(read_all(*reader).empty());
  EXPECT_EQ(reader->skipped(), "124784 skin events");
}

}  // namespace
}  // namespace saccade
