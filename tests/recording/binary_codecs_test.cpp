#include <array>

#include "recording/wrapping_time.h"
#include "tests/recording/read_events.h"
#include "tests/recording/small_files.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

std::string message_of(const std::filesystem::path& path) {
  try {
    (void)read_file(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "read";
}

std::vector<std::int64_t> times_of(const std::filesystem::path& path) {
  std::vector<std::int64_t> t_us;
  for (const Event& event : read_file(path)) t_us.push_back(event.t_us);
  return t_us;
}

TEST(WrappingTime, ContinuesOverWrapsAndBackForLateValuesAndKeepsOtherJumps) {
  WrappingTime time{{{0, 100}}, 30, 10};
  std::vector<std::int64_t> out;
  for (const std::int64_t in : {95, 3, 97, 5, 40, 20, 60, 5, 99, 2, 99}) out.push_back(time.extend(in));
  // 60 to 5 is no wrap, 5 to 99 is late, 99 to 2 is a wrap again.
  EXPECT_THAT(out, ElementsAre(95, 103, 97, 105, 140, 120, 160, 105, 99, 102, 99));
}

// ---- AEDAT 1.0 -----------------------------------------------------------------------------------

TEST(Aedat1, TimeContinuesOverItsWrapAt32Bits) {
  const TempFolder folder;
  std::string content = "#!AER-DAT1.0\r\n";
  for (const std::uint32_t stamp : {0xfffffff0u, 5u, 0xffffffffu, 0x10000000u, 0x7fffffffu, 0x80000000u})
    content += big_endian(std::uint16_t{0}) + big_endian(stamp);
  const std::int64_t wrap = std::int64_t{1} << 32;
  EXPECT_THAT(
      times_of(folder.write("a.aedat", content)),
      ElementsAre(wrap - 16, wrap + 5, wrap - 1, wrap + 0x10000000, wrap + 0x7fffffff, wrap + 0x80000000));
}

TEST(Aedat1, IsReadWithoutALineForTheVersion) {
  const TempFolder folder;
  const std::string record = big_endian(std::uint16_t{51 << 8 | 46 << 1}) + big_endian(5u);
  const auto reader = open_event_file(folder.write("a.dat", "# This is a raw AE data file\r\n" + record));
  EXPECT_EQ(reader->format(), "AEDAT 1.0 DVS128");
  EXPECT_THAT(read_all(*reader), ElementsAre(Event{5, 81, 76, true, 0}));
}

TEST(Aedat1, OfAStereoPairHasTwoCamerasAndOfADavisIsAnError) {
  const TempFolder folder;
  const std::string start = "#!AER-DAT1.0\r\n# AEChip: ";
  const std::string record = big_endian(std::uint16_t{0x8000}) + big_endian(9u);
  EXPECT_THAT(read_file(folder.write("a.aedat", start + "DVS128StereoPair\r\n" + record)),
              ElementsAre(Event{9, 127, 127, true, 1}));
  EXPECT_THAT(message_of(folder.write("a.aedat", start + "DAVIS240C\r\n" + record)),
              HasSubstr("16 bits in AEDAT 1.0"));
}

// ---- AEDAT 3.1 -----------------------------------------------------------------------------------

std::string aedat3(const std::string& packets, const std::string& lines = "#Source 1: DAVIS240C\r\n") {
  return "#!AER-DAT3.1\r\n#Format: RAW\r\n" + lines + "#!END-HEADER\r\n" + packets;
}
std::string packet(std::int16_t type, std::int16_t source, std::int32_t wraps,
                   std::initializer_list<std::uint32_t> words) {
  const auto events = static_cast<std::int32_t>(words.size() / 2);
  return little_endian(type) + little_endian(source) +
         little_endian_words<std::int32_t>({8, 4, wraps, events, events, events}) +
         little_endian_words<std::uint32_t>(words);
}

TEST(Aedat3, ReturnsEventsWithTheOriginTopLeftAndCountsSkippedRecords) {
  const TempFolder folder;
  const auto path = folder.write(
      "a.aedat",
      aedat3(packet(0, 1, 0, {0, 0}) +
             packet(1, 1, 0, {239u << 17 | 179u << 2 | 3u, 5, 7u << 17 | 2u, 6, 1u << 17 | 1u, 7}) +
             packet(1, 2, 0, {1u, 8}) + packet(30, 1, 0, {0, 0, 0, 0})));
  const auto reader = open_event_file(path);
  EXPECT_EQ(reader->format(), "AEDAT 3.1");
  EXPECT_EQ(reader->image_size(), (ImageSize{240, 180}));
  EXPECT_THAT(read_all(*reader), ElementsAre(Event{5, 239, 179, true, 0}, Event{7, 1, 0, false, 0}));
  EXPECT_EQ(reader->skipped(), "1 events of source 2, 1 invalid events, 1 special events, 2 type 30 events");
}

TEST(Aedat3, TimeContinuesByTheCountOfWrapsAt31Bits) {
  const TempFolder folder;
  const std::int64_t wrap = std::int64_t{1} << 31;
  EXPECT_THAT(times_of(folder.write(
                  "a.aedat", aedat3(packet(1, 1, 0, {1u, 0x7fffffff}) + packet(1, 1, 1, {1u, 0, 1u, 9}) +
                                    packet(1, 1, 0, {1u, 0x7ffffffe}) + packet(1, 1, 900, {1u, 3})))),
              ElementsAre(wrap - 1, wrap, wrap + 9, wrap - 2, 900 * wrap + 3));
}

TEST(Aedat3, BrokenContentIsReportedWithItsPlace) {
  const TempFolder folder;
  const std::string good = packet(1, 1, 0, {1u, 7});
  const auto expect = [&](const std::string& broken, const std::string& message) {
    const auto path = folder.write("a.aedat", aedat3(good + broken + good));
    expect_events_then_error(path, {{7, 0, 0, false, 0}}, message);
  };
  const std::string place = "byte " + std::to_string(aedat3(good).size()) + ": ";
  const std::string huge = little_endian_words<std::int32_t>({0x7fffffff, 4, 0, 0x7fffffff, 0x7fffffff, 0});
  const std::string seven = little_endian_words<std::int32_t>({7, 4, 0, 1, 1, 1});
  expect(little_endian_words<std::int16_t>({-1, 1}) + huge, place + "found a packet of type -1");
  expect(little_endian_words<std::int16_t>({1, 1}) + seven, place + "found polarity events of 7 bytes");
  expect(little_endian_words<std::int16_t>({2, 1}) + huge,
         "found the end of the file, expected the rest of a packet");
  expect(packet(1, 1, 0, {1u, 0x80000000u}), "found the time -2147483648");
  EXPECT_THAT(message_of(folder.write("a.aedat", "#!AER-DAT3.1\r\n#Format: PNG\r\n#!END-HEADER\r\n")),
              HasSubstr("the format PNG, expected RAW"));
  EXPECT_THAT(message_of(folder.write("a.aedat", "#!AER-DAT3.1\r\nhello\r\n")),
              HasSubstr("expected a header line"));
}

TEST(Aedat3, TakesTheImageSizeFromTheSourceOfItsEventsElseFromTheOption) {
  const TempFolder folder;
  EventReadOptions options;
  options.image_size = ImageSize{100, 90};
  const std::string lines = "#Source 0: DVS128\r\n#Source 1: DAVIS346\r\n";
  const auto two = open_event_file(folder.write("a.aedat", aedat3(packet(1, 1, 0, {1u, 1}), lines)), options);
  (void)read_all(*two);
  EXPECT_EQ(two->image_size(), (ImageSize{346, 260}));
  const auto none = open_event_file(folder.write("a.aedat", aedat3("", "#Source 1: MyCamera\r\n")), options);
  EXPECT_EQ(none->image_size(), options.image_size);
}

// ---- DAT -----------------------------------------------------------------------------------------

TEST(Dat, HasTheAddressesOfItsVersionAndTimesThatContinueOverTheWrap) {
  const TempFolder folder;
  const std::string start = "% Data file containing CD events.\n";
  const std::string kind(1, '\0');
  const auto one = folder.write(
      "a.dat", start + kind + "\x08" +
                   little_endian_words<std::uint32_t>({0xffffffffu, 1u << 17 | 239u << 9 | 303u, 4, 5}));
  const std::int64_t wrap = std::int64_t{1} << 32;
  EXPECT_THAT(read_file(one),
              ElementsAre(Event{wrap - 1, 303, 239, true, 0}, Event{wrap + 4, 5, 0, false, 0}));
  const auto two =
      folder.write("a.dat", start + "% Version 2\n% Height 720\n% Width 1280\n" + kind + "\x08" +
                                little_endian_words<std::uint32_t>({7, 1u << 28 | 719u << 14 | 1279u}));
  const auto reader = open_event_file(two);
  EXPECT_EQ(reader->image_size(), (ImageSize{1280, 720}));
  EXPECT_EQ(reader->format(), "DAT 2");
  EXPECT_THAT(read_all(*reader), ElementsAre(Event{7, 1279, 719, true, 0}));
}

TEST(Dat, OfOtherEventsIsAnError) {
  const TempFolder folder;
  const std::string start = "% Version 2\n";
  EXPECT_THAT(message_of(folder.write("a.dat", start + "\x0e\x08")), HasSubstr("events of type 14"));
  EXPECT_THAT(message_of(folder.write("a.dat", start + "\x0c\x10")), HasSubstr("events of 16 bytes"));
  EXPECT_THAT(message_of(folder.write("a.dat", "% Version 3\n\x0c\x08")), HasSubstr("version 3"));
}

// ---- Event Stream --------------------------------------------------------------------------------

TEST(EventStream, OfOtherVersionsAndTypesIsAnErrorThatNamesThem) {
  const TempFolder folder;
  const auto file = [&](char major, char type) {
    return folder.write("a.es", "Event Stream" + std::string({major, 0, 0, type, 64, 1, '\xf0', 0}));
  };
  EXPECT_EQ(message_of(file(2, 1)), "read");
  EXPECT_THAT(message_of(file(1, 1)), HasSubstr("Event Stream 1, expected version 2"));
  for (const char type : {'\0', '\2', '\3', '\4'}) {
    EXPECT_THAT(message_of(file(2, type)), HasSubstr("events of type " + std::to_string(type)));
  }
}

TEST(EventStream, HasItsOriginBottomLeftUnlessTheOptionSaysThatYGoesDown) {
  const TempFolder folder;
  std::string content =
      "Event Stream" + std::string({2, 0, 0, 1}) + little_endian_words<std::uint16_t>({8, 6});
  for (const auto& [x, y] : {std::pair(0, 0), std::pair(7, 5), std::pair(3, 2), std::pair(1, 6)})
    content +=
        '\x15' + little_endian(static_cast<std::uint16_t>(x)) + little_endian(static_cast<std::uint16_t>(y));
  const auto path = folder.write("a.es", content);
  const auto up = open_event_file(path);
  EXPECT_EQ(up->format(), "Event Stream 2 DVS");
  EXPECT_THAT(read_all(*up), ElementsAre(Event{10, 0, 5, true, 0}, Event{20, 7, 0, true, 0},
                                         Event{30, 3, 3, true, 0}, Event{40, 1, 6, true, 0}))
      << "the last one lies outside the image";
  EventReadOptions options;
  options.event_stream_y = "down";
  const auto down = open_event_file(path, options);
  EXPECT_EQ(down->format(), "Event Stream 2 DVS (y down)");
  EXPECT_THAT(read_all(*down), ElementsAre(Event{10, 0, 0, true, 0}, Event{20, 7, 5, true, 0},
                                           Event{30, 3, 2, true, 0}, Event{40, 1, 6, true, 0}));
  options.event_stream_y = "left";
  EXPECT_THROW((void)open_event_file(path, options), InputError);
}

TEST(EventStream, CountsResets) {
  const TempFolder folder;
  const std::string start =
      "Event Stream" + std::string({2, 0, 0, 1}) + little_endian_words<std::uint16_t>({320, 240});
  const auto reader = open_event_file(
      folder.write("a.es", start + "\xff\xff\xfe\xfd" + little_endian_words<std::uint16_t>({3, 239})));
  EXPECT_THAT(read_all(*reader), ElementsAre(Event{127 + 127 + 126, 3, 0, true, 0}));
  EXPECT_EQ(reader->skipped(), "1 resets");
}

// ---- N-MNIST -------------------------------------------------------------------------------------

std::string nmnist(std::initializer_list<std::array<std::uint32_t, 4>> records) {
  std::string bytes;
  for (const auto& [t, x, y, on] : records) {
    bytes += static_cast<char>(x);
    bytes += static_cast<char>(y);
    bytes += big_endian(on << 23 | t).substr(1);
  }
  return bytes;
}

TEST(Nmnist, HasTimesOf23BitsThatAreContinuedAndRecordsThatAddTime) {
  const TempFolder folder;
  EventReadOptions options;
  options.image_size = ImageSize{34, 34};
  const auto reader = open_event_file(
      folder.write("a.bin", nmnist({{1000, 3, 4, 1}, {1500, 33, 2, 0}, {0, 0, 240, 0}, {1600, 0, 33, 1}})),
      options);
  EXPECT_EQ(reader->format(), "N-MNIST");
  EXPECT_EQ(reader->image_size(), options.image_size);
  EXPECT_THAT(read_all(*reader), ElementsAre(Event{1000, 3, 4, true, 0}, Event{1500, 33, 2, false, 0},
                                             Event{8192 + 1600, 0, 33, true, 0}));
  options.format = "n-mnist";
  EXPECT_THAT(read_file(folder.write("a.dat", nmnist({{0x7fffff, 1, 2, 0}, {4, 3, 4, 1}})), options),
              ElementsAre(Event{0x7fffff, 1, 2, false, 0}, Event{0x800004, 3, 4, true, 0}));
}

TEST(Nmnist, IsRecognisedByTheExtensionAndByPlausibleEventsOnly) {
  const TempFolder folder;
  const std::string good = nmnist({{1000, 3, 4, 1}, {1500, 33, 2, 0}, {1600, 0, 33, 1}});
  EXPECT_EQ(open_event_file(folder.write("a.bin", good))->format(), "N-MNIST");
  EXPECT_THAT(message_of(folder.write("a.png", good)), HasSubstr("expected a recording in a known format"));
  for (const std::string& other : {nmnist({{1000, 3, 4, 1}, {999, 33, 2, 0}}), nmnist({{1000, 240, 4, 1}}),
                                   nmnist({{1000, 3, 241, 1}})}) {
    EXPECT_THAT(message_of(folder.write("a.bin", other)),
                HasSubstr("expected a recording in a known format"));
  }
  EventReadOptions options;
  options.format = "N-MNIST 2";
  EXPECT_THAT(
      [&] { (void)open_event_file(folder / "a.bin", options); },
      testing::ThrowsMessage<InputError>(HasSubstr("--format: found N-MNIST 2, expected auto, AEDAT 1.0")));
}

// ---- AEDAT 4 written -----------------------------------------------------------------------------

TEST(Aedat4Writer, KeepsAnyTimeAndNamesItsPacketsInTheTableAtTheEnd) {
  const TempFolder folder;
  std::vector<Event> events;
  for (int i = 0; i < 20'000; ++i) {
    events.push_back({std::numeric_limits<std::int64_t>::min() + i * std::int64_t{400'000'000'000'000},
                      static_cast<std::uint16_t>(i % 1280), static_cast<std::uint16_t>(i % 720), i % 3 == 0,
                      0});
  }
  events.push_back({std::numeric_limits<std::int64_t>::max(), 1, 2, true, 0});
  const auto writer = create_event_file(folder / "a.aedat4", {1280, 720});
  writer->write(std::span(events).first(5));
  writer->write(std::span(events).subspan(5));
  writer->commit();
  const auto reader = open_event_file(folder / "a.aedat4");
  EXPECT_EQ(reader->image_size(), (ImageSize{1280, 720}));
  EXPECT_EQ(reader->format(), "AEDAT 4.0 LZ4");
  EXPECT_EQ(read_all(*reader), events);
  // Cut before the table it no longer looks whole, since the header contains the end of its packets.
  const std::string whole = bytes_of(folder / "a.aedat4");
  EXPECT_THAT(message_of(folder.write("cut.aedat4", whole.substr(0, whole.size() / 2))),
              HasSubstr("the end of the file"));
}

}  // namespace
}  // namespace saccade
