#include "apps/deploy/recording_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "recording/format_registry.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;

std::vector<Event> events_of(const std::filesystem::path& file) {
  std::vector<Event> events;
  const auto reader = open_event_file(file);
  while (reader->read(events, 1 << 16) > 0) {
  }
  return events;
}

/// Writes 1000 events per second and a reading every 10 ms, from second `from` to second `to`.
void write(RecordingFiles& files, int from, int to) {
  for (std::int64_t t_us = from * 1'000'000; t_us < to * 1'000'000; t_us += 1000) {
    const std::vector<Event> events = {{t_us, 3, 4, t_us % 2000 == 0, 0}};
    std::optional<JointsRow> joints;
    if (t_us % 10'000 == 0) joints = JointsRow{t_us, JointVector::Zero()};
    files.write(t_us, events, joints);
  }
}

TEST(RecordingFiles, GoOnInTheNextPairAfterTheirTimeAndLoseNoEvent) {
  const TempFolder folder;
  RecordingFiles files(folder / "", built_in_formats(), {128, 128}, {"aedat4", INT64_MAX, 3'000'000, 0});
  write(files, 1, 9);
  files.commit();
  EXPECT_EQ(files.count(), 3);
  EXPECT_EQ(files.first_file(), "events.aedat4");
  std::vector<Event> all;
  for (const char* name : {"events.aedat4", "events_2.aedat4", "events_3.aedat4"}) {
    const auto part = events_of(folder / name);
    all.insert(all.end(), part.begin(), part.end());
  }
  ASSERT_EQ(all.size(), 8000u);
  for (std::size_t i = 0; i < all.size(); ++i)
    ASSERT_EQ(all[i].t_us, 1'000'000 + static_cast<std::int64_t>(i) * 1000);
  EXPECT_EQ(read_table<JointsRow>(folder / "joints_2.csv").size(), 300u);
}

TEST(RecordingFiles, GoOnInTheNextPairAfterTheirSize) {
  const TempFolder folder;
  RecordingFiles files(folder / "", built_in_formats(), {128, 128}, {"csv", 30'000, INT64_MAX, 0});
  write(files, 1, 9);
  files.commit();
  EXPECT_GE(files.count(), 3);
}

TEST(RecordingFiles, NumbersGoOnAfterThoseThatAreThereFinishedOrNot) {
  const TempFolder folder;
  const auto record = [&] {
    RecordingFiles files(folder / "", built_in_formats(), {128, 128}, {"csv", INT64_MAX, INT64_MAX, 0});
    write(files, 1, 2);
    files.commit();
    return files.first_file();
  };
  EXPECT_EQ(record(), "events.csv");
  EXPECT_EQ(record(), "events_2.csv");
  std::ofstream(folder / "events_7.csv.part") << "of a killed run";
  EXPECT_EQ(record(), "events_8.csv");
  EXPECT_EQ(events_of(folder / "events.csv").size(), 1000u) << "the first one is untouched";
}

TEST(RecordingFiles, ADiskWithoutRoomIsRefusedAndEndsARecording) {
  const TempFolder folder;
  const RecordingFilesConfig full{"csv", INT64_MAX, INT64_MAX, INT64_MAX};
  EXPECT_THAT(
      [&] {
        RecordingFiles files(folder / "", built_in_formats(), {128, 128}, full);
      },
      testing::ThrowsMessage<RunError>(HasSubstr("MB free, --record needs output.least_free_mb")));
}

}  // namespace
}  // namespace saccade
