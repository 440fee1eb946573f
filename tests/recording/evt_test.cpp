#include "core/random.h"
#include "tests/recording/read_events.h"
#include "tests/recording/small_files.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr std::int64_t loop_us = std::int64_t{1} << 24;
const std::string evt2_header = "% evt 2.0\n% end\n";
const std::string evt3_header = "% evt 3.0\n% end\n";

std::string evt2(std::initializer_list<std::uint32_t> words) {
  return evt2_header + little_endian_words<std::uint32_t>(words);
}
std::string evt3(std::initializer_list<std::uint16_t> words) {
  return evt3_header + little_endian_words<std::uint16_t>(words);
}

class Evt : public testing::Test {
 protected:
  std::vector<std::int64_t> times_of(const std::string& content) {
    std::vector<std::int64_t> t_us;
    for (const Event& event : read_file(folder_.write("a.raw", content))) t_us.push_back(event.t_us);
    return t_us;
  }
  std::optional<ImageSize> size_of(const std::string& header) {
    return open_event_file(folder_.write("a.raw", header))->image_size();
  }
  std::string skipped(const std::string& content) {
    const auto reader = open_event_file(folder_.write("a.raw", content));
    (void)read_all(*reader);
    return reader->skipped();
  }
  void write(const std::vector<Event>& events, ImageSize size = {1280, 720}) {
    const auto writer = create_event_file(folder_ / "w.raw", size);
    writer->write(events);
    writer->commit();
  }

  TempFolder folder_;
};

TEST_F(Evt, GeometryIsReadInEverySpelling) {
  EXPECT_EQ(size_of("% evt 3.0\n% geometry 1280x720\n"), (ImageSize{1280, 720}));
  EXPECT_EQ(size_of("% format EVT3;height=720;width=1280\n% end\n"), (ImageSize{1280, 720}));
  EXPECT_EQ(size_of("% format EVT2;width=640;height=480\r\n% end\r\n"), (ImageSize{640, 480}));
  EXPECT_EQ(size_of("% evt 2.0\n% Width 304\n% Height 240\n% end\n"), (ImageSize{304, 240}));
  EXPECT_EQ(size_of("% evt 2.0\n"), std::nullopt);
  EXPECT_EQ(size_of("% evt 2.0\n% geometry 0x0\n"), std::nullopt);
  EventReadOptions options;
  options.image_size = ImageSize{320, 240};
  EXPECT_EQ(open_event_file(folder_.write("a.raw", "% evt 2.0\n"), options)->image_size(),
            options.image_size);
}

TEST_F(Evt, OfAnotherEncodingOrNoneIsNotOpened) {
  const auto message = [&](const std::string& header) -> std::string {
    try {
      (void)open_event_file(folder_.write("a.raw", header));
    } catch (const InputError& error) {
      return error.what();
    }
    return "opened";
  };
  EXPECT_THAT(message("% evt 4.0\n% end\n"), HasSubstr("the encoding 4.0, expected EVT2, EVT21 or EVT3"));
  EXPECT_THAT(message("% format EVT4;height=720;width=1280\n"), HasSubstr("the format EVT4"));
  EXPECT_THAT(message("% Date 2020-09-25\n% end\n"), HasSubstr("names no encoding"));
  EXPECT_THAT(message("% evt 3.0\n% a line without"), HasSubstr("the end of the file"));
  EXPECT_THAT(message("% evt 3.0\n% time_offset_us -9223372036854775808\n"), HasSubstr("time_offset_us"));
}

TEST_F(Evt, WordsOfEvt3MakeEventsWithTheStateBeforeThem) {
  const auto path = folder_.write("a.raw", evt3({0x8b2d, 0x6001, 200, 0x236a, 0x2b26, 201, 0x3c00, 0x4fff,
                                                 0x4000, 0x5081, 0x4001, 0x2005}));
  const std::int64_t t = (0xb2d << 12) + 1;
  std::vector<Event> expected = {{t, 0x36a, 200, false, 0}, {t, 0x326, 200, true, 0}};
  for (std::uint16_t x = 0x400; x < 0x40c; ++x) expected.push_back({t, x, 201, true, 0});
  expected.push_back({t, 0x418, 201, true, 0});
  expected.push_back({t, 0x41f, 201, true, 0});
  expected.push_back({t, 0x420, 201, true, 0});
  expected.push_back({t, 5, 201, false, 0});
  EXPECT_EQ(read_file(path), expected);
}

TEST_F(Evt, TimeOfEvt3IsUpperAndLowerPartAndAStrayLowerPartDoesNotCount) {
  EXPECT_THAT(times_of(evt3({0x8b2d, 0x6000, 1, 0x2001, 0x8b2d, 0x632b, 0x6320, 0x2001, 0x6321, 0x2001,
                             0x8b2e, 0x2001, 0x8b2e, 0x6001, 0x2001})),
              ElementsAre(0xb2d000, 0xb2d320, 0xb2d321, 0xb2e000, 0xb2e001));
}

TEST_F(Evt, TimeOfEvt3ContinuesOverItsWrapsAndBackOverThemForLateEvents) {
  EXPECT_THAT(times_of(evt3({0x8fff, 0x6fff, 1, 0x2001, 0x8000, 0x6000, 0x2001, 0x8fff, 0x2001, 0x8001,
                             0x2001, 0x8800, 0x2001, 0x8fff, 0x2001, 0x8000, 0x2001})),
              ElementsAre(loop_us - 1, loop_us, loop_us - 0x1000, loop_us + 0x1000, loop_us + 0x800000,
                          2 * loop_us - 0x1000, 2 * loop_us));
}

TEST_F(Evt, TimeOfEvt2ContinuesOverItsWraps) {
  const std::uint32_t high = 8u << 28;
  const std::int64_t range = std::int64_t{1} << 34;
  EXPECT_THAT(times_of(evt2({high | 0xfffffffu, 63u << 22, high | 0u, 1u << 28, high | 5u, 1u << 28,
                             high | 0x3ffffffu, 0u})),
              ElementsAre(range - 1, range, range + 5 * 64, range + 0x3ffffff * std::int64_t{64}));
  // Past 2^32 us, half of the range.
  EXPECT_THAT(times_of(evt2({high | 0x4000000u, 7u << 22})), ElementsAre((std::int64_t{1} << 32) + 7));
}

TEST_F(Evt, WordsThatAreNoEventsAreCounted) {
  EXPECT_EQ(skipped(evt3({3, 0x2001, 0x8000, 0x2001, 0x6000, 0x3001, 0x400f, 4, 0x2001, 0xa001, 0xe123,
                          0x7001, 0xf001})),
            "6 events before the first time stamp, 1 triggers, 3 words that are no events");
  EXPECT_EQ(skipped(evt2({1u << 28, 8u << 28, 1u << 28, 0xau << 28, 0xfu << 28})),
            "1 events before the first time stamp, 1 triggers, 1 words that are no events");
  EXPECT_EQ(skipped(evt2({8u << 28, 1u << 28})), "");
}

TEST_F(Evt, WordsOfUndefinedTypesAreCountedByTypeAndTheEventsBehindThemRead) {
  const auto read_and_skipped = [&](const std::string& content) {
    const auto reader = open_event_file(folder_.write("a.raw", content));
    std::vector<Event> events = read_all(*reader);
    return std::pair(std::move(events), reader->skipped());
  };
  const Event first{0, 1, 1, false, 0}, second{0, 2, 1, false, 0};
  EXPECT_EQ(
      read_and_skipped(evt3({0x1abc, 0x8000, 1, 0x2001, 0x9abc, 0xbfff, 0xcfff, 0xdfff, 0x9000, 0x2002})),
      std::pair(std::vector<Event>{first, second},
                std::string("1 words of the undefined type 1, 2 words of the undefined type 9, "
                            "1 words of the undefined type B, 1 words of the undefined type C, "
                            "1 words of the undefined type D")));
  std::string counts;
  std::string words = little_endian(8u << 28);
  for (const unsigned type : {2u, 3u, 4u, 5u, 6u, 7u, 9u, 0xbu, 0xcu}) {
    words += little_endian(type << 28 | 0xfffffffu) + little_endian(1u << 28 | 3u << 11 | 4u);
    counts += (counts.empty() ? "" : ", ") +
              ("1 words of the undefined type " + std::string(1, "0123456789ABC"[type]));
  }
  EXPECT_EQ(read_and_skipped(evt2_header + words),
            std::pair(std::vector<Event>(9, Event{0, 3, 4, true, 0}), counts));
}

// ---- EVT2.1, and headers that do not name the encoding ------------------------------------------------

std::string evt21_words(std::initializer_list<std::uint64_t> words, bool legacy = false) {
  std::string bytes;
  for (const std::uint64_t word : words) bytes += little_endian(legacy ? word << 32 | word >> 32 : word);
  return bytes;
}

std::uint64_t evt21_time(std::int64_t high) {
  return std::uint64_t{8} << 60 | static_cast<std::uint64_t>(high) << 32;
}
std::uint64_t evt21_pixels(bool on, std::uint64_t low, std::uint64_t x, std::uint64_t y,
                           std::uint32_t pixels) {
  return static_cast<std::uint64_t>(on) << 60 | low << 54 | x << 43 | y << 32 | pixels;
}

TEST_F(Evt, WordsOfEvt21AreEventsOfUpTo32PixelsOfARow) {
  const std::int64_t range = std::int64_t{1} << 34;
  const auto words = {evt21_pixels(true, 1, 32, 2, 7),
                      evt21_time(0xfffffff),
                      evt21_pixels(true, 63, 64, 479, 0x80000001),
                      std::uint64_t{0xa} << 60,
                      evt21_time(0),
                      evt21_pixels(false, 5, 608, 0, 1u << 31 | 1u << 30),
                      std::uint64_t{0xe} << 60,
                      std::uint64_t{0x7} << 60,
                      evt21_pixels(true, 6, 0, 0, 0)};
  const std::vector<Event> expected = {{range - 1, 64, 479, true, 0},
                                       {range - 1, 95, 479, true, 0},
                                       {range + 5, 638, 0, false, 0},
                                       {range + 5, 639, 0, false, 0}};
  for (const bool legacy : {false, true}) {
    const std::string header =
        "% evt 2.1\n% format EVT21;endianness=" + std::string(legacy ? "legacy" : "little") +
        ";height=480;width=640\n% end\n";
    const auto reader = open_event_file(folder_.write("a.raw", header + evt21_words(words, legacy)));
    EXPECT_EQ(reader->format(), legacy ? "EVT2.1 legacy" : "EVT2.1");
    EXPECT_EQ(reader->image_size(), (ImageSize{640, 480}));
    EXPECT_EQ(read_all(*reader, 3), expected);
    EXPECT_EQ(reader->skipped(),
              "3 events before the first time stamp, 1 triggers, 1 words that are no events, 1 words of the "
              "undefined type 7");
  }
}

TEST_F(Evt, ManyFullWordsOfEvt21FillEveryBlock) {
  std::string words = evt21_words({evt21_time(1)});
  for (std::uint64_t y = 0; y < 600; ++y) words += evt21_words({evt21_pixels(true, 0, 0, y, ~0u)});
  const auto path = folder_.write("a.raw", "% evt 2.1\n% end\n" + words);
  for (const std::size_t block : {std::size_t{1}, std::size_t{100'000}})
    EXPECT_EQ(read_all(*open_event_file(path), block).size(), 32u * 600);
}

TEST_F(Evt, WithoutEndiannessTheOrderOfTheHalvesIsThatOfTheWords) {
  const auto words = {evt21_time(15), evt21_pixels(true, 1, 32, 2, 1), evt21_time(16),
                      evt21_pixels(false, 2, 64, 3, 1)};
  for (const bool legacy : {false, true}) {
    const auto reader =
        open_event_file(folder_.write("a.raw", "% evt 2.1\n% end\n" + evt21_words(words, legacy)));
    EXPECT_EQ(reader->format(), legacy ? "EVT2.1 legacy (guessed)" : "EVT2.1");
    EXPECT_THAT(read_all(*reader), ElementsAre(Event{961, 32, 2, true, 0}, Event{1026, 64, 3, false, 0}));
  }
}

TEST_F(Evt, AHeaderThatNamesNoEncodingLeavesItToTheOptionElseToTheWords) {
  const std::string header = "% Date 2018-05-03 12:00:00\n% system_ID 21\n";
  const Event event{15 * 64 + 40, 5, 7, true, 0};
  const std::string evt2_words =
      little_endian_words<std::uint32_t>({8u << 28 | 15, 1u << 28 | 40u << 22 | 5u << 11 | 7});
  const std::string evt3_words = little_endian_words<std::uint16_t>({0x8000, 0x6000 | 1000, 7, 0x2805});
  const std::string evt21 = evt21_words({evt21_time(15), evt21_pixels(true, 40, 0, 7, 1u << 5)});
  const std::string evt21_legacy = evt21_words({evt21_time(15), evt21_pixels(true, 40, 0, 7, 1u << 5)}, true);
  struct Case {
    std::string words, name, format;
  };
  for (const Case& one :
       {Case{evt2_words, "evt2", "EVT2"}, Case{evt3_words, "evt3", "EVT3"}, Case{evt21, "evt21", "EVT2.1"},
        Case{evt21_legacy, "evt21_legacy", "EVT2.1 legacy"}}) {
    const auto path = folder_.write("a.raw", header + one.words);
    const auto guessed = open_event_file(path);
    EXPECT_EQ(guessed->format(), one.format + " (guessed)");
    EXPECT_THAT(read_all(*guessed), ElementsAre(event)) << one.name;
    EventReadOptions options;
    options.evt_encoding = one.name;
    const auto named = open_event_file(path, options);
    EXPECT_EQ(named->format(), one.format);
    EXPECT_THAT(read_all(*named), ElementsAre(event)) << one.name;
  }
  EXPECT_THAT([&] { (void)open_event_file(folder_.write("a.raw", header + std::string(64, '\x07'))); },
              testing::ThrowsMessage<InputError>(HasSubstr("--evt with evt2, evt21, evt21_legacy, evt3")));
  EventReadOptions unknown;
  unknown.evt_encoding = "evt5";
  EXPECT_THROW((void)open_event_file(folder_ / "a.raw", unknown), InputError);
}

TEST_F(RealRecording, WordsOfTheSensorsAreRecognisedWithoutTheirHeaders) {
  const TempFolder folder;
  for (const auto& [name, encoding] : {std::pair("spinning_dot_gen3vga_evt2.raw", "EVT2 (guessed)"),
                                       std::pair("driving_gen41hd_evt3.raw", "EVT3 (guessed)")}) {
    const std::string whole = bytes_of(path_of(name));
    std::size_t begin = 0;
    while (whole.compare(begin, 2, "% ") == 0) begin = whole.find('\n', begin) + 1;
    const auto reader = open_event_file(folder.write("a.raw", "% Date 2018-05-03\n" + whole.substr(begin)));
    EXPECT_EQ(reader->format(), encoding);
    EXPECT_EQ(read_all(*reader), read_real(name));
  }
}

/// Rows of pixels of one time and polarity, dense and thin, as edges make them.
std::vector<Event> rows_of_events(std::size_t count, std::uint64_t seed) {
  const RandomStream random(seed, "evt_test");
  std::vector<Event> events;
  std::int64_t t_us = 1000;
  for (std::uint64_t row = 0; events.size() < count; ++row) {
    t_us += static_cast<std::int64_t>(random.bits(0, row) % 3);
    const auto y = static_cast<std::uint16_t>(random.bits(1, row) % 720);
    const bool on = (random.bits(2, row) & 1) != 0;
    const std::uint64_t step = 1 + random.bits(3, row) % 9;
    std::uint64_t x = random.bits(4, row) % 1280;
    for (std::uint64_t i = 0; i < 60 && x < 1280; ++i) {
      events.push_back({t_us, static_cast<std::uint16_t>(x), y, on, 0});
      x += 1 + random.bits(5, 100 * row + i) % step;
    }
  }
  return events;
}

TEST_F(Evt, RowsAreWrittenAsVectorsWhereThatIsShorterAndReadBackExactly) {
  const auto events = rows_of_events(50'000, 3);
  write(events);
  EXPECT_EQ(read_file(folder_ / "w.raw"), events);
  const std::size_t with_vectors = std::filesystem::file_size(folder_ / "w.raw");
  // Without them every event is at least one word.
  EXPECT_LT(with_vectors, 2 * events.size());
  std::printf("%.2f bytes per event in rows\n",
              static_cast<double>(with_vectors) / static_cast<double>(events.size()));

  std::vector<Event> full;
  for (std::uint16_t x = 0; x < 1280; ++x) full.push_back({5, x, 7, true, 0});
  write(full);
  EXPECT_EQ(read_file(folder_ / "w.raw"), full);
  // A row of 1280 is 40 groups of three words behind times, row and base.
  const std::string header = "% evt 3.0\n% format EVT3;height=720;width=1280\n% geometry 1280x720\n% end\n";
  EXPECT_EQ(bytes_of(folder_ / "w.raw").size(), header.size() + 2 * (4 + 40 * 3));
}

TEST_F(Evt, TimesOfAnyAgeAreWrittenSoThatTheyReadBack) {
  // Across wraps with silences of up to 19 h, and late by up to 4 s, within and across a wrap.
  std::vector<Event> events;
  for (const std::int64_t t_us :
       {std::int64_t{1605537493718345}, std::int64_t{1605537493718345} + 3, std::int64_t{1605537503718345},
        std::int64_t{1605537500000000}, std::int64_t{1605540000000000}, std::int64_t{1605540009000000},
        std::int64_t{1605608000000000}}) {
    events.push_back({t_us, 3, 4, true, 0});
  }
  const std::int64_t wrap = 1605608000000000 / loop_us * loop_us + loop_us;
  for (const std::int64_t t_us : {wrap - 2'000'000, wrap + 1, wrap - 1'900'000, wrap + 2}) {
    events.push_back({t_us, 3, 4, true, 0});
  }
  write(events);
  EXPECT_EQ(read_file(folder_ / "w.raw"), events);
  EXPECT_THAT(bytes_of(folder_ / "w.raw"),
              HasSubstr("\n% time_offset_us " + std::to_string(events[0].t_us / loop_us * loop_us)));
  write({{-5, 1, 1, true, 0}, {5, 1, 1, true, 0}});
  EXPECT_THAT(read_file(folder_ / "w.raw"), ElementsAre(Event{-5, 1, 1, true, 0}, Event{5, 1, 1, true, 0}));
  // In the counter's first round there is nothing to add.
  write({{loop_us - 1, 1, 1, true, 0}});
  EXPECT_THAT(bytes_of(folder_ / "w.raw"), testing::Not(HasSubstr("time_offset_us")));
}

TEST_F(Evt, AFileNamedEvt2HasTheWordsOfEvt2) {
  const std::vector<Event> events = {{63, 5, 700, true, 0},
                                     {64, 1279, 0, false, 0},
                                     {std::int64_t{64} << 28, 2047, 2047, true, 0},
                                     {(std::int64_t{64} << 28) - 3'000'000, 1, 2, false, 0},
                                     {std::int64_t{64} * 3 << 28, 3, 4, true, 0}};
  const auto create = [&] { return create_event_file(folder_ / "w.evt2.raw", {2048, 2048}); };
  {
    const auto writer = create();
    writer->write(std::span(events).first(2));
    writer->write(std::span(events).subspan(2));
    writer->commit();
  }
  const std::string bytes = bytes_of(folder_ / "w.evt2.raw");
  const std::string header = "% evt 2.0\n% format EVT2;height=2048;width=2048\n% geometry 2048x2048\n% end\n";
  ASSERT_TRUE(bytes.starts_with(header));
  EXPECT_EQ((bytes.size() - header.size()) % 4, 0u);
  // By hand from the layout: time, event, time, event.
  const std::vector<std::uint32_t> words = {0x8u << 28, 1u << 28 | 63u << 22 | 5u << 11 | 700u,
                                            0x8u << 28 | 1u, 1279u << 11};
  for (std::size_t i = 0; i < words.size(); ++i) {
    std::uint32_t word = 0;
    for (std::size_t byte = 0; byte < 4; ++byte)
      word |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[header.size() + 4 * i + byte]))
              << (8 * byte);
    EXPECT_EQ(word, words[i]) << i;
  }
  EXPECT_EQ(open_event_file(folder_ / "w.evt2.raw")->format(), "EVT2");
  EXPECT_EQ(read_file(folder_ / "w.evt2.raw"), events) << "over wraps, back over one, and after 9.5 h";

  const std::int64_t late_us = 1605537493718345;
  const std::vector<Event> old = {{late_us, 1, 2, true, 0}, {late_us + 100, 1, 2, false, 0}};
  {
    const auto writer = create();
    writer->write(old);
    writer->commit();
  }
  EXPECT_EQ(read_file(folder_ / "w.evt2.raw"), old);
  const auto writer = create();
  EXPECT_THAT(
      [&] {
        writer->write(
            std::vector<Event>{{late_us, 1, 1, true, 0}, {late_us - (std::int64_t{1} << 34), 1, 1, true, 0}});
      },
      testing::ThrowsMessage<InputError>(HasSubstr("expected times that EVT2 holds")));
}

TEST_F(Evt, TimesThatWouldNotReadBackAreRejected) {
  for (const std::int64_t t_us : {std::int64_t{99'000'000} - 5'000'000 - (loop_us >> 1),
                                  std::int64_t{99'000'000} + (std::int64_t{1} << 37)}) {
    EXPECT_THAT(
        [&] {
          write({{99'000'000, 1, 1, true, 0}, {t_us, 1, 1, true, 0}});
        },
        testing::ThrowsMessage<InputError>(HasSubstr("an event at " + std::to_string(t_us) + " us")));
  }
}

}  // namespace
}  // namespace saccade
