#include "recording/event_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "core/error.h"
#include "core/random.h"
#include "recording/format_registry.h"
#include "tests/recording/read_events.h"
#include "tests/recording/small_files.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;

void write_file(const std::filesystem::path& path, ImageSize size, const std::vector<Event>& events) {
  const auto writer = create_event_file(path, size);
  writer->write(events);
  writer->commit();
}

/// Events all over the image, with the corners among them, and equal times now and then.
std::vector<Event> scattered_events(ImageSize size, std::int64_t first_us, int count, std::int64_t step_us) {
  const RandomStream random(11, "event_file_test");
  std::vector<Event> events;
  for (int i = 0; i < count; ++i) {
    const auto n = static_cast<std::uint64_t>(i);
    const bool right = i < 4 ? (i & 1) != 0 : random.uniform(0, n) < 0.5;
    Event event;
    event.t_us = first_us;
    event.x = static_cast<std::uint16_t>(random.bits(1, n) % static_cast<std::uint64_t>(size.width));
    event.y = static_cast<std::uint16_t>(random.bits(2, n) % static_cast<std::uint64_t>(size.height));
    if (i < 4) event.x = static_cast<std::uint16_t>(right ? size.width - 1 : 0);
    if (i < 4) event.y = static_cast<std::uint16_t>((i & 2) != 0 ? size.height - 1 : 0);
    event.on = (random.bits(3, n) & 1) != 0;
    events.push_back(event);
    first_us += static_cast<std::int64_t>(random.bits(4, n) % static_cast<std::uint64_t>(step_us));
  }
  return events;
}

std::string record(std::uint32_t address, std::uint32_t stamp) {
  return big_endian(address) + big_endian(stamp);
}

std::uint32_t davis_address(std::uint32_t x, std::uint32_t y, std::uint32_t on) {
  return y << 22 | x << 12 | on << 11;
}

const std::string aedat_header = "#!AER-DAT2.0\r\n# a comment\r\n";

// ---- choosing the codec --------------------------------------------------------------------------

TEST(EventFile, AFileThatCannotBeOpenedIsReportedWithTheReason) {
  TempFolder folder;
  const auto message = [&](const std::filesystem::path& path) -> std::string {
    try {
      (void)open_event_file(path);
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(path.string()));
      return error.what();
    }
    return "opened";
  };
  EXPECT_THAT(message(folder / "none.aedat"), HasSubstr("No such file"));
  EXPECT_THAT(message(folder / ""), HasSubstr("a directory"));
  EXPECT_THAT(message(folder.write("empty", "")), HasSubstr("an empty file"));
  EXPECT_THAT(message(folder.write("png", "\x89PNG\r\n\x1a\n")),
              HasSubstr("event-driven binary dump or text"));
  EXPECT_THAT(message(folder.write("v5", "#!AER-DAT5.0\r\n")), HasSubstr("starts with #!AER-DAT5.0..,"));
  EXPECT_THAT(message(folder.write("percent", "% Date today\n\x01\x02")), HasSubstr("names no encoding"));
  EXPECT_THAT(message(folder.write("cut", "#!AER-DA")), HasSubstr("cut off"));
}

TEST(EventFile, RejectsToWriteAFormatItDoesNotHaveOrAnImageThatDoesNotFit) {
  TempFolder folder;
  EXPECT_THROW((void)create_event_file(folder / "a.png", {128, 128}), InputError);
  EXPECT_THROW((void)create_event_file(folder / "a", {128, 128}), InputError);
  EXPECT_THROW((void)create_event_file(folder / "a.aedat", {1280, 720}), InputError);
  EXPECT_THROW((void)create_event_file(folder / "a.raw", {2049, 720}), InputError);
  EXPECT_THROW((void)create_event_file(folder / "a.aedat4", {40000, 10}), InputError);
  EXPECT_THROW((void)create_event_file(folder / "a.aedat", {1280, 720}, 2), InputError);
  EXPECT_TRUE(std::filesystem::is_empty(folder / ""));
}

TEST(EventFile, RejectsEventsThatTheFormatCannotHold) {
  TempFolder folder;
  for (const char* name : {"a.csv", "a.aedat", "a.aedat4", "a.raw", "a.log", "a.h5"}) {
    const auto writer = create_event_file(folder / name, {128, 128});
    EXPECT_THROW(writer->write(std::vector<Event>{{0, 128, 0, true, 0}}), InputError) << name;
    EXPECT_THROW(writer->write(std::vector<Event>{{0, 0, 128, true, 0}}), InputError) << name;
    EXPECT_THROW(writer->write(std::vector<Event>{{0, 0, 0, true, 1}}), InputError) << name;
  }
}

struct Written {
  std::string name;
  ImageSize size;
};

class WrittenEvents : public testing::TestWithParam<Written> {};

TEST_P(WrittenEvents, AreReadBackExactlyWhateverTheBlock) {
  TempFolder folder;
  const auto path = folder / GetParam().name;
  const auto events = scattered_events(GetParam().size, 1234, 20000, 200);
  write_file(path, GetParam().size, events);
  for (const std::size_t block :
       {std::size_t{1}, std::size_t{333}, std::numeric_limits<std::size_t>::max()}) {
    EXPECT_EQ(read_all(*open_event_file(path), block), events) << block;
  }
}

TEST_P(WrittenEvents, MayBeNone) {
  TempFolder folder;
  const auto path = folder / GetParam().name;
  write_file(path, GetParam().size, {});
  EXPECT_TRUE(read_file(path).empty());
}

TEST_P(WrittenEvents, CutAtAnyByteGiveTheEventsBeforeTheCutAndThenAnErrorOrACleanEnd) {
  TempFolder folder;
  const auto events = scattered_events(GetParam().size, 1, 12, 90000);
  write_file(folder / GetParam().name, GetParam().size, events);
  const std::string whole = bytes_of(folder / GetParam().name);
  const std::size_t errors = count_errors_of_cut_files(whole, events);
  // A cut between two records, words or header lines looks like the end; after AEDAT 4's events comes a table.
  const std::string extension = std::filesystem::path(GetParam().name).extension();
  const std::size_t ends_of_event = extension == ".raw" ? 5 : 2;
  const std::size_t table = extension == ".aedat4" ? 120 : 0;
  EXPECT_GE(errors, whole.size() - ends_of_event * (events.size() + 4) - table);
}

INSTANTIATE_TEST_SUITE_P(EventFile, WrittenEvents,
                         testing::Values(Written{"small.csv", {128, 128}}, Written{"large.txt", {1280, 720}},
                                         Written{"dvs128.aedat", {128, 128}},
                                         Written{"atis.aedat", {304, 240}},
                                         Written{"davis240.aedat", {240, 180}},
                                         Written{"largest.aedat", {1024, 512}}, Written{"tiny.aedat", {8, 8}},
                                         Written{"dvs128.aedat4", {128, 128}},
                                         Written{"hd.aedat4", {1280, 720}}, Written{"hd.raw", {1280, 720}},
                                         Written{"tiny.raw", {8, 8}}),
                         [](const auto& written) {
                           std::string name = written.param.name;
                           std::replace(name.begin(), name.end(), '.', '_');
                           return name;
                         });

// ---- two cameras ---------------------------------------------------------------------------------

class TwoCameras : public testing::TestWithParam<const char*> {
 protected:
  TwoCameras() : events_(scattered_events({128, 128}, 1'000, 5000, 40)) {
    for (std::size_t i = 0; i < events_.size(); ++i) events_[i].camera = i % 3 == 0 ? 1 : 0;
    std::ranges::stable_sort(events_, {}, [](const Event& e) { return std::pair(e.t_us, e.camera); });
  }

  TempFolder folder_;
  std::filesystem::path path_ = folder_ / GetParam();
  std::vector<Event> events_;
};
INSTANTIATE_TEST_SUITE_P(, TwoCameras,
                         testing::Values("e.aedat", "e.csv", "e.aedat4", "e.h5", "e.raw", "e.bag",
                                         "e.packets.bag", "e.mcap"));

TEST_P(TwoCameras, AreReadBackExactlyTogetherAndEachAlone) {
  const auto writer = create_event_file(path_, {128, 128}, 2);
  writer->write(events_);
  writer->commit();
  EXPECT_EQ(read_all(*open_event_file(path_), 77), events_);
  for (const std::uint8_t camera : std::initializer_list<std::uint8_t>{0, 1}) {
    std::vector<Event> alone = events_;
    std::erase_if(alone, [&](const Event& e) { return e.camera != camera; });
    EXPECT_EQ(read_all(*open_event_file(path_, {.image_size = {}, .camera = camera}), 77), alone);
  }
}

TEST_P(TwoCameras, AreRejectedByAFileOfOneCamera) {
  const auto writer = create_event_file(path_, {128, 128});
  EXPECT_THROW(writer->write(events_), InputError);
}

TEST(TwoCamerasOfAnySize, AreReadBackExactlyFromEveryFormatThatHoldsThem) {
  const TempFolder folder;
  constexpr ImageSize size{640, 480};
  std::vector<Event> events = scattered_events(size, 5000, 30'000, 40);
  for (std::size_t i = 0; i < events.size(); ++i) events[i].camera = i % 5 < 2 ? 1 : 0;
  std::ranges::stable_sort(events, {}, [](const Event& e) { return std::pair(e.t_us, e.camera); });
  const FormatRegistry formats = built_in_formats();
  for (const std::string& choice : formats.run_choices_for(size, 2)) {
    const auto path = folder / ("events." + choice);
    const auto writer = create_event_file(path, size, 2);
    writer->write(std::span(events).first(20'000));
    writer->write(std::span(events).subspan(20'000));
    writer->commit();
    EXPECT_EQ(read_all(*open_event_file(path), 1'000), events) << choice;
  }
}

TEST(TwoCamerasOfEvt3, NeedTheRightCamerasFileBesideTheLeftOne) {
  const TempFolder folder;
  const auto writer = create_event_file(folder / "e.raw", {128, 128}, 2);
  const std::vector<Event> events = {{10, 1, 2, true, 0}, {20, 3, 4, false, 1}};
  writer->write(events);
  writer->commit();
  std::filesystem::remove(folder / "e_right.raw");
  EXPECT_THAT([&] { (void)open_event_file(folder / "e.raw"); },
              testing::ThrowsMessage<InputError>(testing::HasSubstr("e_right.raw: found no such file")));
}

TEST(Aedat2, HoldsTwoCamerasOf128x128Only) {
  TempFolder folder;
  EXPECT_THROW((void)create_event_file(folder / "e.aedat", {304, 240}, 2), InputError);
}

TEST(Aedat2, TheRightCameraOfAStereoPairHasBit15) {
  TempFolder folder;
  const std::string header =
      "#!AER-DAT2.0\r\n# AEChip: ch.unizh.ini.jaer.chip.stereopsis.DVS128StereoPair\r\n";
  const auto path =
      folder.write("e.aedat", header + record(0, 10) + record(1u << 15 | 3u << 8 | 2u << 1 | 1u, 20));
  const std::vector<Event> expected = {{10, 127, 127, true, 0}, {20, 125, 124, false, 1}};
  EXPECT_EQ(read_all(*open_event_file(path), 10), expected);
}

// ---- AEDAT 2.0 -----------------------------------------------------------------------------------

TEST(Aedat2, Dvs128AddressesAreMirroredInBothAxesAndBitZeroIsOff) {
  TempFolder folder;
  const auto path = folder.write("a.aedat", aedat_header + record(0x00004ca2, 5) + record(0x8001, 6) +
                                                record(0x7f << 8 | 0x7f << 1 | 1, 7) + record(0, 7));
  const auto reader = open_event_file(path);
  EXPECT_EQ(reader->format(), "AEDAT 2.0 DVS128");
  EXPECT_EQ(reader->image_size(), (ImageSize{128, 128}));
  EXPECT_EQ(read_all(*reader),
            (std::vector<Event>{{5, 46, 51, true, 0}, {7, 0, 0, false, 0}, {7, 127, 127, true, 0}}));
}

TEST(Aedat2, DavisAddressesHaveTheirOriginBottomRightAndSpecialRecordsAreSkipped) {
  TempFolder folder;
  const std::string chip = "# AEChip: eu.seebetter.ini.chips.davis.DAVIS240C\r\n";
  const auto path = folder.write("a.aedat", aedat_header + chip + record(davis_address(0, 0, 1), 5) +
                                                record(davis_address(9, 9, 0) | 1u << 31, 6) +
                                                record(davis_address(9, 9, 0) | 1u << 10, 6) +
                                                record(davis_address(239, 179, 0), 7));
  const auto reader = open_event_file(path);
  EXPECT_EQ(reader->format(), "AEDAT 2.0 DAVIS");
  EXPECT_EQ(reader->image_size(), (ImageSize{240, 180}));
  EXPECT_EQ(read_all(*reader), (std::vector<Event>{{5, 239, 179, true, 0}, {7, 0, 0, false, 0}}));
}

TEST(Aedat2, TheLayoutComesFromTheHeaderElseFromTheAddressesElseFromTheOption) {
  TempFolder folder;
  const std::string narrow = record(0x0102, 1);
  const std::string wide = record(davis_address(345, 20, 1), 1);
  const auto format = [&](const std::string& content, const EventReadOptions& options = {}) {
    const auto reader = open_event_file(folder.write("a.aedat", content), options);
    return reader->format().substr(10) + " " + std::to_string(reader->image_size()->width);
  };
  EXPECT_EQ(format(aedat_header + narrow), "DVS128 128");
  EXPECT_EQ(format(aedat_header + wide), "DAVIS 346");
  EXPECT_EQ(format(aedat_header + "# AEChip: a.b.DVS128\r\n" + narrow), "DVS128 128");
  EXPECT_EQ(format(aedat_header + "# AEChip: a.b.Davis346blue\r\n" + narrow), "DAVIS 346");
  EventReadOptions options;
  options.aedat2_layout = "davis";
  EXPECT_EQ(format(aedat_header + narrow, options), "DAVIS 240");
  options.image_size = ImageSize{304, 240};
  EXPECT_EQ(format(aedat_header + narrow, options), "DAVIS 304");
  EXPECT_THROW(format(aedat_header + "# AEChip: a.b.Cochlea64\r\n" + narrow), InputError);
  EXPECT_EQ(format(aedat_header + "# AEChip: a.b.Cochlea64\r\n" + narrow, options), "DAVIS 304");
  options.aedat2_layout = "atis";
  EXPECT_THROW(format(aedat_header + narrow, options), InputError);
}

TEST(Aedat2, APixelOutsideTheSensorEndsTheReadingWithItsByte) {
  TempFolder folder;
  const std::string header = aedat_header + "# AEChip: DAVIS 10x8\r\n";
  const auto path = folder.write(
      "a.aedat", header + record(davis_address(9, 7, 1), 1) + record(davis_address(10, 7, 1), 2));
  const auto reader = open_event_file(path);
  std::vector<Event> events;
  EXPECT_EQ(reader->read(events, 10), 1u);
  EXPECT_THAT([&] { (void)reader->read(events, 10); },
              testing::ThrowsMessage<InputError>(HasSubstr("byte " + std::to_string(header.size() + 8))));
}

TEST(Aedat2, TheHeaderMayEndItsLinesWithLineFeedsOnly) {
  TempFolder folder;
  const auto path = folder.write("a.aedat", "#!AER-DAT2.0\n# x\n#\n" + record(0, 3));
  EXPECT_EQ(read_file(path), (std::vector<Event>{{3, 127, 127, true, 0}}));
}

TEST(Aedat2, ARecordThatStartsLikeAHeaderLineIsARecord) {
  TempFolder folder;
  // 0x23 is '#', 0x0a a line feed: raw y 140, x 160 to 175, as a DAVIS stores them.
  for (std::uint32_t x = 0; x < 240; ++x) {
    const auto path = folder.write("a.aedat", aedat_header + record(davis_address(x, 140, 1), 0x20202020));
    EventReadOptions options;
    options.image_size = ImageSize{240, 180};
    ASSERT_EQ(read_file(path, options).size(), 1u) << x;
  }
}

TEST(Aedat2, TimeContinuesOverItsWraps) {
  TempFolder folder;
  const auto times = [&](const std::vector<std::uint32_t>& stamps) {
    std::string content = aedat_header;
    for (const std::uint32_t stamp : stamps) content += record(0, stamp);
    std::vector<std::int64_t> t_us;
    for (const Event& event : read_file(folder.write("a.aedat", content))) t_us.push_back(event.t_us);
    return t_us;
  };
  const std::int64_t wrap = std::int64_t{1} << 31;
  using testing::ElementsAre;
  // Two wraps at 2^32, with a late event across the first one.
  EXPECT_THAT(times({0x7fffffff, 0x80000000, 0x7fffffff, 0x80000005, 0xa0000000, 0, 0x60000000, 0x80000000}),
              ElementsAre(wrap - 1, wrap, wrap - 1, wrap + 5, wrap + 0x20000000, 2 * wrap,
                          2 * wrap + 0x60000000, 3 * wrap));
  // Wraps at 2^31, with a late event across the first one.
  EXPECT_THAT(times({0x7ffffff0, 2, 0x7fffffff, 3, 0x30000000, 0x60000000, 7}),
              ElementsAre(wrap - 16, wrap + 2, wrap - 1, wrap + 3, wrap + 0x30000000, wrap + 0x60000000,
                          2 * wrap + 7));
  // A start again in mid-range is no wrap, nor is a first stamp near the end.
  EXPECT_THAT(times({0x30000000, 0, 5}), ElementsAre(0x30000000, 0, 5));
  EXPECT_THAT(times({0xffffff00, 4}), ElementsAre(-256, 4));
}

TEST(Aedat2, WritesTimesBeyondItsRangeSoThatTheyReadBackAndRejectsThoseThatWouldNot) {
  TempFolder folder;
  const ImageSize size{128, 128};
  // 20,000 events up to 1 s apart pass 2^31 and 2^32 us twice.
  const auto events = scattered_events(size, 2'000'000'000, 20000, 1'000'000);
  ASSERT_GT(events.back().t_us, std::int64_t{1} << 33);
  write_file(folder / "a.aedat", size, events);
  EXPECT_EQ(read_file(folder / "a.aedat"), events);

  const auto writer = create_event_file(folder / "b.aedat", size);
  EXPECT_THROW(writer->write(std::vector<Event>{{1605537493718345, 0, 0, true, 0}}), InputError);
}

// ---- real recordings -----------------------------------------------------------------------------

TEST_F(RealRecording, TheShapesHaveTheirCountAndTheirFirstAndLastEvents) {
  const auto events = read_real("shapes_rotation_davis240_txt.txt");
  ASSERT_EQ(events.size(), 20000u);
  EXPECT_EQ(std::vector<Event>(events.begin(), events.begin() + 5),
            (std::vector<Event>{{2097134, 162, 27, false, 0},
                                {2097140, 77, 45, false, 0},
                                {2097141, 108, 160, false, 0},
                                {2097145, 230, 94, true, 0},
                                {2097145, 132, 103, false, 0}}));
  EXPECT_EQ(events.back(), (Event{2195729, 127, 147, true, 0}));
}

TEST_F(RealRecording, ReadsBackTheSameFromEveryWriter) {
  const auto events = read_real("ball_looming_dvs128_aedat2.aedat");
  TempFolder folder;
  for (const char* name : {"a.aedat", "a.aedat4", "a.csv", "a.raw", "a.log", "a.h5"}) {
    write_file(folder / name, {128, 128}, events);
    EXPECT_EQ(read_file(folder / name), events) << name;
  }
}

TEST(EventFile, ExtremeTimesReadBackTheSameOrAreRejected) {
  const TempFolder folder;
  for (const char* name : {"a.csv", "a.aedat", "a.aedat4", "a.raw", "a.log", "a.h5"}) {
    for (const std::int64_t first_us :
         {std::numeric_limits<std::int64_t>::min(), -(std::int64_t{1} << 62) - 5, std::int64_t{1} << 61,
          (std::int64_t{1} << 61) + 1, (std::int64_t{1} << 62) + 5,
          std::numeric_limits<std::int64_t>::max() - 9}) {
      const std::vector<Event> events = {{first_us, 1, 2, true, 0}, {first_us + 9, 3, 4, false, 0}};
      try {
        write_file(folder / name, {128, 128}, events);
      } catch (const InputError&) {
        continue;
      }
      EXPECT_EQ(read_file(folder / name), events) << name << " " << first_us;
    }
    try {
      write_file(folder / name, {128, 128},
                 {{std::numeric_limits<std::int64_t>::min(), 1, 2, true, 0},
                  {std::numeric_limits<std::int64_t>::max(), 3, 4, false, 0}});
      EXPECT_EQ(read_file(folder / name).back().t_us, std::numeric_limits<std::int64_t>::max()) << name;
    } catch (const InputError&) {
    }
  }
}

}  // namespace
}  // namespace saccade
