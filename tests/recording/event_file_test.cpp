#include "recording/event_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "core/error.h"
#include "recording/format_registry.h"
#include "tests/recording/made_events.h"
#include "tests/recording/read_events.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;

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
                                         "e.packets.bag", "e.mcap", "e.db3"));

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

TEST(EventFile, WritersThatCannotHoldTheTimesNameTheOptionThatMovesThem) {
  const TempFolder folder;
  const auto expect_hint = [&](const char* name, std::int64_t t_us) {
    const auto writer = create_event_file(folder / name, {128, 128});
    EXPECT_THAT(
        [&] {
          writer->write(std::vector<Event>{{t_us, 1, 2, true, 0}});
        },
        testing::ThrowsMessage<InputError>(HasSubstr("--zero-time of saccade convert")))
        << name;
  };
  for (const char* name : {"a.bag", "a.packets.bag", "a.mcap", "a.db3", "a.log"})
    expect_hint(name, -1293810339);
  expect_hint("a.aedat", 1605537493718345);
  expect_hint("a.aedat", -(std::int64_t{1} << 31) - 1);
  expect_hint("a.raw", std::int64_t{1} << 62);
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
