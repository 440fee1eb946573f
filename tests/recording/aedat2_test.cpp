#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "tests/recording/made_events.h"
#include "tests/recording/read_events.h"
#include "tests/recording/small_files.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;

std::string record(std::uint32_t address, std::uint32_t stamp) {
  return big_endian(address) + big_endian(stamp);
}

std::uint32_t davis_address(std::uint32_t x, std::uint32_t y, std::uint32_t on) {
  return y << 22 | x << 12 | on << 11;
}

const std::string aedat_header = "#!AER-DAT2.0\r\n# a comment\r\n";

TEST(Aedat2, Dvs128AddressesAreMirroredInBothAxesAndBitZeroIsOff) {
  TempFolder folder;
  const auto path = folder.write("a.aedat", aedat_header + record(0x00004ca2, 5) + record(0x8001, 6) +
                                                record(0x7f << 8 | 0x7f << 1 | 1, 7) + record(0, 7));
  const auto reader = open_event_file(path);
  EXPECT_EQ(reader->format(), "AEDAT 2.0 DVS128 (guessed)");
  EXPECT_EQ(reader->image_size(), (ImageSize{128, 128}));
  EXPECT_EQ(read_all(*reader),
            (std::vector<Event>{{5, 46, 51, true, 0}, {7, 0, 0, false, 0}, {7, 127, 127, true, 0}}));
  EXPECT_EQ(reader->skipped(), "1 special events");
}

TEST(Aedat2, DavisAddressesHaveTheirOriginBottomRightAndOtherRecordsAreCountedByKind) {
  TempFolder folder;
  const std::string chip = "# AEChip: eu.seebetter.ini.chips.davis.DAVIS240C\r\n";
  std::string content = aedat_header + chip + record(davis_address(0, 0, 1), 5);
  for (int i = 0; i < 2; ++i) content += record(davis_address(9, 9, 0) | 1u << 31 | 1u << 10 | 77, 6);
  content += record(davis_address(9, 9, 1) | 1u << 31 | 1u << 10, 6);  // bits 10 and 11
  for (int i = 0; i < 3; ++i) content += record(davis_address(9, 9, 1) | 1u << 10, 6);
  const auto path = folder.write("a.aedat", content + record(davis_address(239, 179, 0), 7));
  const auto reader = open_event_file(path);
  EXPECT_EQ(reader->format(), "AEDAT 2.0 DAVIS");
  EXPECT_EQ(reader->guess(), "");
  EXPECT_EQ(reader->image_size(), (ImageSize{240, 180}));
  EXPECT_EQ(read_all(*reader), (std::vector<Event>{{5, 239, 179, true, 0}, {7, 0, 0, false, 0}}));
  EXPECT_EQ(reader->skipped(), "3 special events, 2 APS samples, 1 IMU values");
}

TEST(Aedat2, TheLayoutComesFromTheHeaderElseFromTheOptionElseFromTheAddresses) {
  TempFolder folder;
  const std::string narrow = record(0x0102, 1);
  const std::string wide = record(davis_address(345, 20, 1), 1);
  const auto format = [&](const std::string& content, const EventReadOptions& options = {}) {
    const auto reader = open_event_file(folder.write("a.aedat", content), options);
    return reader->format().substr(10) + " " + std::to_string(reader->image_size()->width);
  };
  EXPECT_EQ(format(aedat_header + narrow), "DVS128 (guessed) 128");
  EXPECT_EQ(format(aedat_header + wide), "DAVIS (guessed) 346");
  EXPECT_EQ(format(aedat_header + "# AEChip: a.b.DVS128\r\n" + narrow), "DVS128 128");
  EXPECT_EQ(format(aedat_header + "# AEChip: a.b.Davis346blue\r\n" + narrow), "DAVIS 346");
  EXPECT_EQ(format(aedat_header + "# AEChip: DAVI346\r\n" + narrow), "DAVIS 346");
  EXPECT_EQ(format(aedat_header + "# AEChip: a.davis.Davis208PixelParade\r\n" + narrow), "DAVIS 208");
  EXPECT_EQ(format(aedat_header + "# AEChip: a.DVS640\r\n" + narrow), "DVS640 640");
  EXPECT_EQ(format(aedat_header + "# AEChip: a.b.CDAVIS\r\n" + wide), "DAVIS (size guessed) 346");
  EventReadOptions options;
  options.aedat2_layout = "davis";
  EXPECT_THAT([&] { (void)format(aedat_header + narrow, options); },
              testing::ThrowsMessage<InputError>(HasSubstr("expected --size WIDTHxHEIGHT")));
  options.image_size = ImageSize{304, 240};
  EXPECT_EQ(format(aedat_header + narrow, options), "DAVIS 304");
  for (const char* other : {"Cochlea64", "DVS1280x720SD", "MultiDavis346BCamera", "Davis240StereoPair"}) {
    const std::string chip = "# AEChip: a.b." + std::string(other) + "\r\n";
    EXPECT_THROW(format(aedat_header + chip + narrow), InputError) << other;
    EXPECT_EQ(format(aedat_header + chip + narrow, options), "DAVIS 304") << other;
  }
  options.aedat2_layout = "atis";
  EXPECT_THROW(format(aedat_header + narrow, options), InputError);
}

// ---- AEDAT 2.0 whose header does not name the sensor ----------------------------------------------------

/// Addresses as v2e writes them for an image of that size.
std::uint32_t v2e_address(ImageSize size, const Event& event) {
  const auto x = static_cast<std::uint32_t>(size.width - 1 - event.x);
  const auto y = static_cast<std::uint32_t>(size.height - 1 - event.y);
  if (size == ImageSize{640, 480}) return y << 11 | x << 1 | (event.on ? 1u : 0u);
  return davis_address(x, y, event.on ? 1 : 0);
}

std::string v2e_file(ImageSize size, const std::vector<Event>& events) {
  std::string content = "#!AER-DAT2.0\r\n# This is a raw AE data file created by AEDat2Output in v2e\r\n";
  for (const Event& event : events)
    content += record(v2e_address(size, event), static_cast<std::uint32_t>(event.t_us));
  return content;
}

/// Events inside a part of the image.
std::vector<Event> events_in(ImageSize part, std::uint16_t x, std::uint16_t y, int count,
                             std::int64_t first_us) {
  std::vector<Event> events = scattered_events(part, first_us, count, 50);
  for (Event& event : events) {
    event.x = static_cast<std::uint16_t>(event.x + x);
    event.y = static_cast<std::uint16_t>(event.y + y);
  }
  return events;
}

TEST(Aedat2, EverySizeThatV2eWritesIsRecognisedFromTheWholeFileAndMarked) {
  const TempFolder folder;
  for (const auto& [size, format] : {std::pair(ImageSize{240, 180}, "AEDAT 2.0 DAVIS (guessed)"),
                                     std::pair(ImageSize{346, 260}, "AEDAT 2.0 DAVIS (guessed)"),
                                     std::pair(ImageSize{640, 480}, "AEDAT 2.0 DVS640 (guessed)")}) {
    const auto events = scattered_events(size, 10, 30'000, 20);
    const auto reader = open_event_file(folder.write("a.aedat", v2e_file(size, events)));
    EXPECT_EQ(reader->format(), format);
    EXPECT_EQ(reader->image_size(), size);
    EXPECT_THAT(reader->guess(), HasSubstr(std::to_string(size.width) + "x" + std::to_string(size.height)));
    EXPECT_EQ(read_all(*reader), events);
  }
}

TEST(Aedat2, ASizeThatIsSeenOnlyLateInTheFileCountsFromItsFirstEvent) {
  const TempFolder folder;
  constexpr ImageSize size{346, 260};
  std::vector<Event> events = events_in({31, 31}, 235, 155, 200'000, 10);  // 1.6 MB, longer than any buffer
  const auto late = events_in({31, 31}, 45, 45, 5'000, events.back().t_us);
  events.insert(events.end(), late.begin(), late.end());
  const auto reader = open_event_file(folder.write("a.aedat", v2e_file(size, events)));
  EXPECT_EQ(reader->image_size(), size);
  EXPECT_EQ(read_all(*reader), events);
}

TEST(Aedat2, EventsThatFitImagesOfSeveralSensorsNeedTheSize) {
  const TempFolder folder;
  constexpr ImageSize size{346, 260};
  const auto events = events_in({31, 31}, 235, 155, 20'000, 10);
  const auto path = folder.write("a.aedat", v2e_file(size, events));
  EXPECT_THAT(
      [&] { (void)open_event_file(path); },
      testing::ThrowsMessage<InputError>(testing::AllOf(
          HasSubstr("that reach 111x105 pixels"), HasSubstr("--size WIDTHxHEIGHT"), HasSubstr("346x260"))));
  EventReadOptions options;
  options.image_size = size;
  const auto reader = open_event_file(path, options);
  EXPECT_EQ(reader->guess(), "");
  EXPECT_EQ(read_all(*reader), events);
  // One event in 20,000 outside 240x180 is an outlier, or the noise of a larger sensor.
  std::vector<Event> with_one = events;
  with_one.push_back({with_one.back().t_us, 0, 0, true, 0});
  EXPECT_THROW((void)open_event_file(folder.write("b.aedat", v2e_file(size, with_one))), InputError);
}

TEST(Aedat2, APixelOutsideTheSensorIsReturnedAsItIsStored) {
  TempFolder folder;
  const std::string header = aedat_header + "# AEChip: DAVIS 10x8\r\n";
  const auto path = folder.write(
      "a.aedat", header + record(davis_address(9, 7, 1), 1) + record(davis_address(10, 7, 1), 2) +
                     record(davis_address(9, 306, 1), 3) + record(davis_address(8, 0, 0), 4));
  EXPECT_EQ(read_file(path),
            (std::vector<Event>{
                {1, 0, 0, true, 0}, {2, 10, 0, true, 0}, {3, 0, 306, true, 0}, {4, 1, 7, false, 0}}));
}

TEST(Aedat2, AddressesOfOtherLayoutsAreCountedAndNotTakenForPixels) {
  TempFolder folder;
  for (const char* chip : {"", "# AEChip: a.b.DVS128\r\n"}) {
    const auto reader = open_event_file(folder.write(
        "a.aedat", aedat_header + chip + record(0x00004ca2, 5) + record(davis_address(9, 9, 0), 6) +
                       record(0x00004ca2, 7) + record(0x80004ca2, 8) + record(0, 9)));
    EXPECT_EQ(read_all(*reader),
              (std::vector<Event>{{5, 46, 51, true, 0}, {7, 46, 51, true, 0}, {9, 127, 127, true, 0}}));
    EXPECT_EQ(reader->skipped(), "1 special events, 1 records that are no address of a DVS128");
  }
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

}  // namespace
}  // namespace saccade
