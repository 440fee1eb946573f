#include "recording/format_registry.h"

#include <algorithm>
#include <sstream>

#include "core/error.h"
#include "recording/input_file.h"
#include "recording/output_file.h"
#include "recording/run_file_names.h"
#include "tests/recording/read_events.h"
#include "tests/recording/small_files.h"

namespace saccade {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// The table of docs/recordings.md, from the registry.
std::string table_of(const FormatRegistry& registry) {
  std::string table =
      "| format | read | written | time | axes and polarity as stored | limits of written files |\n"
      "|---|---|---|---|---|---|\n";
  for (const RecordingFormat& format : registry.formats()) {
    std::string extensions;
    for (const std::string& extension : format.extensions) {
      extensions += (extensions.empty() ? "" : ", ") + ("`" + extension + "`");
    }
    const auto cell = [](const std::string& text) { return text.empty() ? "" : text + " "; };
    table += "| " + format.name + " (" + extensions + ") | " + format.reads + " | " + cell(format.writes) +
             "| " + format.time + " | " + format.axes + " | " + cell(format.limits) + "|\n";
  }
  return table;
}

TEST(FormatRegistry, TheTableInTheDocumentsIsThatOfTheRegistry) {
  const std::string page = bytes_of(std::filesystem::path(SACCADE_SOURCE_DIR) / "docs/recordings.md");
  EXPECT_THAT(page, HasSubstr(table_of(built_in_formats()))) << "docs/recordings.md needs this table:\n"
                                                             << table_of(built_in_formats());
}

TEST(FormatRegistry, ChoicesAndExtensionsAreThoseOfTheFormatsThatAreWritten) {
  const FormatRegistry formats = built_in_formats();
  EXPECT_THAT(formats.run_choices(),
              ElementsAre("aedat", "aedat4", "bag", "csv", "db3", "h5", "log", "mcap", "npz", "raw"));
  EXPECT_THAT(formats.run_choices(true),
              ElementsAre("aedat", "aedat4", "bag", "csv", "db3", "log", "mcap", "npz", "raw"));
  EXPECT_EQ(formats.written_extensions(),
            ".aedat, .aedat4, .bag, .csv, .db3, .h5, .hdf5, .log, .mcap, .npy, .npz, .raw, .txt");
  EXPECT_EQ(formats.written_extensions(2),
            ".aedat, .aedat4, .bag, .csv, .db3, .h5, .hdf5, .log, .mcap, .npy, .npz, .raw, .txt");
  EXPECT_THAT(formats.run_choices_for({128, 128}, 2),
              ElementsAre("aedat", "aedat4", "bag", "csv", "db3", "h5", "log", "mcap", "npz", "raw"));
  EXPECT_THAT(formats.run_choices_for({304, 240}, 2),
              ElementsAre("aedat4", "bag", "csv", "db3", "h5", "log", "mcap", "npz", "raw"));
  EXPECT_EQ(formats.run_choices_for({304, 240}, 1), formats.run_choices());
  EXPECT_THAT(formats.files_of("a/b.log"), ElementsAre("a/b.log", "a/b.info.log"));
  EXPECT_THAT(formats.files_of("a/b.raw"), ElementsAre("a/b.raw", "a/b_right.raw"));
  EXPECT_THAT(formats.files_of("a/a_0.db3"), ElementsAre("a/a_0.db3", "a/metadata.yaml"));
  EXPECT_THAT(formats.files_of("a/events.db3"), ElementsAre("a/events.db3"));
}

TEST(FormatRegistry, TheNamesOfARunFolderIncludeTheEventFilesOfEveryFormat) {
  const std::vector<std::string> names = run_file_names(built_in_formats());
  for (const char* name : {"scenario.yaml", "events.aedat", "events.aedat4", "events.csv", "events.h5",
                           "events.info.log", "events.log", "events.raw", "truth_right.csv"}) {
    EXPECT_EQ(std::ranges::count(names, name), 1) << name;
  }
}

TEST(FormatRegistry, EveryFormatReadsTheEventsOfItsSmallFileOrOfAFileThatItWrote) {
  const FormatRegistry formats = built_in_formats();
  const TempFolder folder;
  std::vector<std::string> recognised;
  for (const SmallFile& file : small_files()) {
    const auto path = folder.write(file.name, file.bytes());
    InputFile input(path);
    recognised.push_back(formats.recognise({path, input.peek(FileStart::most_bytes)}).name);
  }
  const std::vector<Event> events = {{10, 1, 2, true, 0}, {20, 3, 4, false, 0}};
  for (const RecordingFormat& format : formats.formats()) {
    if (!format.create) {
      EXPECT_THAT(recognised, testing::Contains(format.name)) << "tests/recording/small_files.cpp lacks one";
      continue;
    }
    for (const std::string& extension : format.extensions) {
      const auto path = folder / ("written" + extension);
      const auto writer = create_event_file(formats, path, {128, 128});
      writer->write(events);
      writer->commit();
      InputFile input(path);
      EXPECT_EQ(formats.recognise({path, input.peek(FileStart::most_bytes)}).name, format.name);
      EXPECT_EQ(read_all(*open_event_file(formats, path)), events) << path;
    }
  }
}

TEST(FormatRegistry, MoreCamerasThanAFormatHoldsAreRejectedWithTheExtensionsThatHoldThem) {
  const TempFolder folder;
  const FormatRegistry built_in = built_in_formats();
  FormatRegistry formats;  // in which AEDAT 4 holds one camera
  for (RecordingFormat format : built_in.formats()) {
    if (format.name == "AEDAT 4.0") format.cameras = 1;
    formats.add(std::move(format));
  }
  EXPECT_THAT(
      [&] {
        (void)create_event_file(formats, folder / "a.aedat4", {128, 128}, 2);
      },
      ThrowsMessage<InputError>(AllOf(
          HasSubstr("a.aedat4"), HasSubstr("found two cameras"),
          HasSubstr("or one of .aedat, .bag, .csv, .db3, .h5, .hdf5, .log, .mcap, .npy, .npz, .raw, .txt"))));
  EXPECT_TRUE(std::filesystem::is_empty(folder / ""));
}

// ---- a format of one's own -----------------------------------------------------------------------

/// A line "DOTS", then lines "t x y" of ON events.
class DotsReader final : public EventReader {
 public:
  explicit DotsReader(InputFile file) : lines_(std::string(file.peek(1 << 16))) {
    std::string mark;
    std::getline(lines_, mark);
  }
  std::size_t read(std::vector<Event>& events, std::size_t max_events) override {
    std::size_t count = 0;
    for (Event event; count < max_events && lines_ >> event.t_us >> event.x >> event.y; ++count) {
      event.on = true;
      events.push_back(event);
    }
    return count;
  }
  std::optional<ImageSize> image_size() const override { return ImageSize{9, 9}; }
  std::string format() const override { return "dots"; }

 private:
  std::istringstream lines_;
};

class DotsWriter final : public EventWriter {
 public:
  explicit DotsWriter(const std::filesystem::path& path) : file_(path) { file_.write("DOTS\n"); }
  void write(std::span<const Event> events) override {
    for (const Event& e : events) {
      file_.write(std::to_string(e.t_us) + " " + std::to_string(e.x) + " " + std::to_string(e.y) + "\n");
    }
  }
  void commit() override { file_.commit(); }

 private:
  OutputFile file_;
};

RecordingFormat dots_format() {
  RecordingFormat format;
  format.name = "dots";
  format.extensions = {".dots"};
  format.sniff = [](const FileStart& start) { return start.begins_with("DOTS\n"); };
  format.open = [](InputFile file, const EventReadOptions&) -> std::unique_ptr<EventReader> {
    return std::make_unique<DotsReader>(std::move(file));
  };
  format.create = [](const std::filesystem::path& path, ImageSize, int) -> std::unique_ptr<EventWriter> {
    return std::make_unique<DotsWriter>(path);
  };
  return format;
}

TEST(FormatRegistry, AFormatOfOnesOwnIsReadWrittenAndListedLikeTheOthers) {
  FormatRegistry formats = built_in_formats();
  formats.add(dots_format());
  const TempFolder folder;
  const std::vector<Event> events = {{10, 1, 2, true, 0}, {20, 3, 4, true, 0}};
  const auto writer = create_event_file(formats, folder / "a.dots", {9, 9});
  writer->write(events);
  writer->commit();
  EXPECT_EQ(read_all(*open_event_file(formats, folder / "a.dots")), events);
  EXPECT_THAT(formats.run_choices(), testing::Contains("dots"));
  EXPECT_THAT(formats.written_extensions(), HasSubstr(".csv, .db3, .dots, .h5"));
  EXPECT_THAT([&] { (void)open_event_file(formats, folder.write("b", "DOT")); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("cut off"), HasSubstr("text or dots"))));
  EXPECT_THROW((void)create_event_file(folder / "a.dots", {9, 9}), InputError) << "the built-in formats";
}

}  // namespace
}  // namespace saccade
