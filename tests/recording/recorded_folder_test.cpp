#include "recording/recorded_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "recording/run_files.h"
#include "tests/recording/read_events.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;

const EventReadOptions sized{.image_size = ImageSize{64, 48}};

/// 40 events of 1 ms each, from `first_us` on.
std::vector<Event> some_events(std::int64_t first_us) {
  std::vector<Event> events;
  for (int i = 0; i < 40; ++i)
    events.push_back({first_us + i * 1000, static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(i % 7),
                      i % 3 == 0, 0});
  return events;
}

RecordedFile inspect_one(const std::filesystem::path& path) {
  const auto files = inspect_recorded(built_in_formats(), path, sized);
  EXPECT_EQ(files.size(), 1u);
  return files.front();
}

class TornRecordings : public testing::TestWithParam<std::string> {};

TEST_P(TornRecordings, CutAtEveryByteOfTheLastRecordAreNamedAndRepaired) {
  const TempFolder folder;
  const std::filesystem::path part = folder / ("events." + GetParam() + ".part");
  std::vector<Event> all;
  std::vector<std::uintmax_t> sizes;
  {
    const auto writer = create_event_file(folder / ("events." + GetParam()), {64, 48});
    for (const std::int64_t first_us : {1'000'000, 2'000'000, 3'000'000}) {
      const auto events = some_events(first_us);
      writer->write(events);
      all.insert(all.end(), events.begin(), events.end());
      writer->sync();
      sizes.push_back(std::filesystem::file_size(part));
    }
  }
  ASSERT_TRUE(std::filesystem::exists(part)) << "what was synced remains without commit";
  const std::string bytes = bytes_of(part);
  ASSERT_EQ(bytes.size(), sizes[2]);
  ASSERT_GT(sizes[2], sizes[1]);
  for (std::size_t length = sizes[1]; length <= sizes[2]; ++length) {
    const TempFolder cut_folder;
    const auto cut =
        cut_folder.write("events." + GetParam() + ".part", std::string_view(bytes).substr(0, length));
    const RecordedFile file = inspect_one(cut);
    ASSERT_EQ(file.unreadable, "") << length;
    EXPECT_TRUE(file.unfinished);
    EXPECT_GE(file.rows, 80) << "cut at " << length;
    EXPECT_LE(file.rows, 120) << "cut at " << length;
    if (file.torn) {
      EXPECT_EQ(file.torn->byte + file.torn->bytes, length);
      EXPECT_GE(file.torn->byte, sizes[1]) << "cut at " << length;
    }
    if (length == sizes[2]) {
      EXPECT_EQ(file.rows, 120);
    }
    const auto whole = write_whole_part(built_in_formats(), file, sized);
    EXPECT_EQ(whole, cut_folder / ("events." + GetParam()));
    std::vector<Event> read;
    const auto reader = open_event_file(whole, sized);
    while (reader->read(read, 1000) > 0) {
    }
    ASSERT_EQ(static_cast<std::int64_t>(read.size()), file.rows) << "cut at " << length;
    EXPECT_TRUE(std::equal(read.begin(), read.end(), all.begin())) << "cut at " << length;
    EXPECT_EQ(bytes_of(cut).size(), length) << "the torn file stays";
  }
}

INSTANTIATE_TEST_SUITE_P(, TornRecordings,
                         testing::Values("aedat", "aedat4", "bag", "csv", "log", "mcap", "raw"));

TEST(RecordedFolder, ATableCutAtEveryByteOfItsLastRowLosesThatRowAlone) {
  const TempFolder folder;
  {
    TableWriter<JointsRow> table(folder / "joints.csv");
    for (int i = 1; i <= 3; ++i) table.write({i * 10'000, JointVector::Constant(0.25 * i)});
    table.sync();
  }
  const std::string bytes = bytes_of(folder / "joints.csv.part");
  const std::size_t last_row = bytes.rfind('\n', bytes.size() - 2) + 1;
  for (std::size_t length = last_row + 1; length < bytes.size(); ++length) {
    const TempFolder cut_folder;
    const RecordedFile file =
        inspect_one(cut_folder.write("joints.csv.part", std::string_view(bytes).substr(0, length)));
    EXPECT_EQ(file.rows, 2);
    EXPECT_EQ(file.last_us, 20'000);
    ASSERT_TRUE(file.torn) << length;
    EXPECT_EQ(file.torn->byte, last_row);
    EXPECT_EQ(file.torn->bytes, length - last_row);
    const auto rows = read_table<JointsRow>(write_whole_part(built_in_formats(), file, sized));
    ASSERT_EQ(rows.size(), 2u);
    EXPECT_EQ(rows[1].position_rad[neck_yaw], 0.5);
  }
}

TEST(RecordedFolder, ATableWhoseEndTheDiskFilledWithZerosEndsBeforeThem) {
  const TempFolder folder;
  const auto path = folder.write("joints.csv", "t_us,a_rad\n10,0.5\n20," + std::string(100, '\0'));
  const RecordedFile file = inspect_one(path);
  EXPECT_EQ(file.rows, 1);
  ASSERT_TRUE(file.torn);
  EXPECT_EQ(file.torn->byte, 18u);
  EXPECT_EQ(file.torn->bytes, 103u);
  EXPECT_EQ(write_whole_part(built_in_formats(), file, sized), folder / "joints_whole.csv")
      << "the name is taken";
  EXPECT_EQ(bytes_of(folder / "joints_whole.csv"), "t_us,a_rad\n10,0.5\n");
}

TEST(RecordedFolder, GapsBetweenRotatedRecordingsAreNamedInTheOrderOfTheirNumbers) {
  const TempFolder folder;
  const auto write = [&](const std::string& name, std::int64_t first_us) {
    const auto writer = create_event_file(folder / name, {64, 48});
    writer->write(some_events(first_us));
    writer->commit();
  };
  write("events.aedat4", 1'000'000);
  EXPECT_FALSE(has_parts(built_in_formats(), folder / ""));
  write("events_2.aedat4", 1'040'000);
  write("events_10.aedat4", 3'000'000);
  write("events_11.aedat4", 500'000);
  folder.write("events_12.aedat4.part", "#!AER");
  folder.write("notes.txt", "no table");
  EXPECT_TRUE(has_parts(built_in_formats(), folder / ""));
  const auto files = inspect_recorded(built_in_formats(), folder / "", sized);
  ASSERT_EQ(files.size(), 5u);
  EXPECT_EQ(files[0].after_gap_us, std::nullopt);
  EXPECT_EQ(files[1].after_gap_us, 1000);
  EXPECT_EQ(files[2].number, 10);
  EXPECT_EQ(files[2].after_gap_us, 3'000'000 - 1'079'000);
  EXPECT_LT(files[3].after_gap_us, 0) << "a later run";
  EXPECT_THAT(files[4].unreadable, HasSubstr("events_12.aedat4.part"));
  EXPECT_TRUE(files[4].unfinished);
  EXPECT_THROW((void)write_whole_part(built_in_formats(), files[4], sized), InputError);
}

TEST(RecordedFolder, OfAFinishedFileThatIsTornTheWholePartGetsAnotherName) {
  const TempFolder folder;
  {
    const auto writer = create_event_file(folder / "events.aedat4", {64, 48});
    writer->write(some_events(1000));
    writer->sync();
    writer->write(some_events(2'000'000));
    writer->commit();
  }
  const std::string bytes = bytes_of(folder / "events.aedat4");
  folder.write("events.aedat4", std::string_view(bytes).substr(0, bytes.size() * 2 / 3));
  const RecordedFile file = inspect_one(folder / "events.aedat4");
  ASSERT_TRUE(file.torn);
  EXPECT_EQ(write_whole_part(built_in_formats(), file, sized), folder / "events_whole.aedat4");
  EXPECT_TRUE(inspect_one(folder / "events_whole.aedat4").is_whole());
}

}  // namespace
}  // namespace saccade
