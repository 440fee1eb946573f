// info, convert and detect on recordings, as a user meets them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/integration/run_shell.h"
#include "tests/recording/read_events.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

Outcome saccade(const std::string& arguments) { return run_shell("'" SACCADE_BINARY "' " + arguments); }

class Recordings : public testing::Test {
 protected:
  [[nodiscard]] std::string at(const std::string& name) const { return (folder_ / name).string(); }
  std::filesystem::path write(const std::string& name, ImageSize size, const std::vector<Event>& events,
                              int cameras = 1) const {
    const auto writer = create_event_file(folder_ / name, size, cameras);
    writer->write(events);
    writer->commit();
    return folder_ / name;
  }

  TempFolder folder_;
  // x, y and polarity that no flip or swap leaves as they are.
  const std::vector<Event> few_ = {{1'000'000, 1, 2, true, 0},
                                   {1'400'000, 10, 20, false, 0},
                                   {1'500'000, 30, 5, true, 0},
                                   {2'000'000, 39, 29, false, 0}};
  const ImageSize size_{40, 30};
};

TEST_F(Recordings, InfoPrintsTheContentAndItsIrregularities) {
  folder_.write("odd.csv", "t_us,x,y,p\n1000,3,4,1\n1500,200,4,0\n1400,3,4,1\n501500,3,4,1\n");
  const Outcome outcome = saccade("info --size 128x128 " + at("odd.csv"));
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  for (const char* line :
       {"format                text\n", "image                 128 x 128\n",
        "events reach          201 x 5\n", "outside the image     1\n", "events                4\n",
        "duration, s           0.500500\n", "mean rate, events/s   8\n", "peak rate in 100 ms   30\n",
        "peak rate in 1 ms     3000\n", "ON : OFF              3 : 1 (75.0 % ON)\n",
        "longest gap, us       500000 at 1500\n", "gaps above 100 ms     1\n",
        "back in time          1 by up to 100 us\n"}) {
    EXPECT_THAT(outcome.text, HasSubstr(line));
  }
  EXPECT_THAT(saccade("info --gap 600 " + at("odd.csv")).text, HasSubstr("gaps above 600 ms     0\n"));

  const auto json = nlohmann::json::parse(saccade("info --json " + at("odd.csv")).text);
  EXPECT_EQ(json["events"], 4);
  EXPECT_EQ(json["image"], nullptr);
  EXPECT_EQ(json["outside_image"], nullptr);
  EXPECT_EQ(json["reach"]["width"], 201);
  EXPECT_EQ(json["peak_rate_hz_in_1ms"], 3000);
  EXPECT_DOUBLE_EQ(json["mean_rate_hz"].get<double>(), 4 / 0.5005);
}

TEST_F(Recordings, InfoNamesWhatATornFileLostAndRepairWritesTheRest) {
  write("events.aedat4", size_, few_);
  folder_.write("torn.csv", "t_us,x,y,p\n1000,3,4,1\n1500,2,4,0\n16");
  const Outcome info = saccade("info --size 40x30 " + at("torn.csv"));
  EXPECT_EQ(info.status, 1) << info.text;
  EXPECT_THAT(info.text, HasSubstr("torn                  2 bytes from byte 33 on are lost: "));
  EXPECT_THAT(info.text, HasSubstr("last event, us        1500\n"));
  EXPECT_EQ(nlohmann::json::parse(saccade("info --json " + at("torn.csv")).text)["torn"]["byte"], 33);
  EXPECT_EQ(saccade("convert " + at("torn.csv") + " " + at("whole.csv")).status, 2);
  EXPECT_EQ(saccade("convert --whole-part " + at("torn.csv") + " " + at("whole.csv")).status, 0);
  EXPECT_EQ(bytes_of(at("whole.csv")), "t_us,x,y,p\n1000,3,4,1\n1500,2,4,0\n");

  std::filesystem::create_directory(folder_ / "run");
  std::filesystem::rename(at("torn.csv"), at("run/events_2.csv.part"));
  std::filesystem::rename(at("events.aedat4"), at("run/events.aedat4"));
  const Outcome before = saccade("info " + at("run"));
  EXPECT_EQ(before.status, 1) << before.text;
  EXPECT_THAT(before.text, HasSubstr("events.aedat4      4 events from 1.000000 to 2.000000 s\n"));
  EXPECT_THAT(
      before.text,
      HasSubstr("events_2.csv.part  not finished; 2 events from 0.001000 to 0.001500 s; times begin anew"));
  const Outcome repair = saccade("repair " + at("run"));
  EXPECT_EQ(repair.status, 0) << repair.text;
  EXPECT_THAT(repair.text, HasSubstr("events_2.csv: 2 events; 2 bytes from byte 33 on are lost"));
  EXPECT_THAT(repair.text, HasSubstr("1 file is whole\n"));
  EXPECT_EQ(bytes_of(at("run/events_2.csv")), bytes_of(at("whole.csv")));
}

TEST_F(Recordings, InfoPrintsEachCamera) {
  write("two.log", {304, 240}, {{10, 1, 1, true, 0}, {20, 1, 1, false, 1}, {1020, 1, 1, true, 1}}, 2);
  const Outcome outcome = saccade("info " + at("two.log"));
  EXPECT_THAT(outcome.text, testing::ContainsRegex("\n +both +left +right\nevents +3 +1 +2\n"))
      << outcome.text;
  EXPECT_THAT(saccade("info --camera right " + at("two.log")).text, Not(HasSubstr("both")));
  const auto json = nlohmann::json::parse(saccade("info --json " + at("two.log")).text);
  EXPECT_EQ(json["cameras"]["left"]["events"], 1);
  EXPECT_EQ(json["cameras"]["right"]["longest_gap_us"], 1000);
}

TEST_F(Recordings, ConvertKeepsEveryEventFromFormatToFormat) {
  write("0.csv", size_, few_);
  const std::vector<std::string> names = {"0.csv", "1.h5",    "2.aedat4", "3.log",
                                          "4.raw", "5.aedat", "6.hdf5",   "7.txt"};
  for (std::size_t i = 1; i < names.size(); ++i) {
    const Outcome outcome = saccade("convert --size 40x30 " + at(names[i - 1]) + " " + at(names[i]));
    ASSERT_EQ(outcome.status, 0) << outcome.text;
    EXPECT_THAT(outcome.text, HasSubstr(names[i] + ": 4 events\n"));
    EXPECT_EQ(read_file(at(names[i])), few_) << names[i];
  }
  EXPECT_EQ(bytes_of(at("7.txt")), bytes_of(at("0.csv")));
}

TEST_F(Recordings, ConvertRemovesHotPixelsBackgroundAndAllButEveryNthEvent) {
  std::string lines;
  for (int i = 0; i < 400; ++i) {
    const std::string t = std::to_string(1000 * i);
    lines += t + ",20,20,1\n";  // a hot pixel
    if (i % 4 == 0) {           // two neighbours, one event a second pair
      lines += t + ",5,5,1\n" + t + ",6,5,0\n";
    }
    if (i % 100 == 50) lines += t + ",30,10,1\n";  // alone
  }
  folder_.write("noisy.csv", "t_us,x,y,p\n" + lines);
  const auto convert = [&](const std::string& options) {
    const Outcome outcome =
        saccade("convert --force --size 40x30 " + at("noisy.csv") + " " + at("out.csv") + " " + options);
    EXPECT_EQ(outcome.status, 0) << outcome.text;
    return outcome.text;
  };
  EXPECT_THAT(convert("--filter hot"), HasSubstr("204 events\nremoved: 400 of 1 hot pixels"));
  // The first event of all, those of the hot pixel and those that are alone have no neighbour.
  EXPECT_THAT(convert("--filter background"), HasSubstr("199 events\nremoved: 405 without a neighbour"));
  EXPECT_THAT(convert("--filter hot,background"), HasSubstr("removed: 5 without a neighbour"));
  EXPECT_THAT(convert("--decimate 4"), HasSubstr("151 events\nremoved: 453 by --decimate"));
  EXPECT_EQ(saccade("convert --force --filter cold " + at("noisy.csv") + " " + at("out.csv")).status, 2);
  EXPECT_EQ(saccade("convert --force --decimate 0 " + at("noisy.csv") + " " + at("out.csv")).status, 2);
}

TEST_F(Recordings, ConvertTakesPartsAndTurnsThem) {
  write("in.csv", size_, few_);
  const auto convert = [&](const std::string& options) {
    const Outcome outcome =
        saccade("convert --force --size 40x30 " + at("in.csv") + " " + at("out.h5") + " " + options);
    EXPECT_EQ(outcome.status, 0) << outcome.text;
    return read_file(at("out.h5"));
  };
  const auto picked = [&](std::initializer_list<std::size_t> which) {
    std::vector<Event> events;
    for (const std::size_t i : which) events.push_back(few_[i]);
    return events;
  };
  EXPECT_EQ(convert("--from 0.4 --until 1"), picked({1, 2})) << "from is in, until is out";
  EXPECT_EQ(convert("--polarity off"), picked({1, 3}));
  EXPECT_EQ(convert("--region 10,5,29,16"), picked({1, 2}));
  EXPECT_EQ(open_event_file(at("out.h5"))->image_size(), size_);
  EXPECT_EQ(convert("--region 10,5,29,16 --crop --zero-time --invert"),
            (std::vector<Event>{{0, 0, 15, true, 0}, {100'000, 20, 0, false, 0}}));
  EXPECT_EQ(open_event_file(at("out.h5"))->image_size(), (ImageSize{29, 16}));
  EXPECT_EQ(convert("--polarity on --flip-x --flip-y"),
            (std::vector<Event>{{1'000'000, 38, 27, true, 0}, {1'500'000, 9, 24, true, 0}}));
  // By 90 degrees clockwise the pixel at the top left goes to the top right.
  EXPECT_EQ(convert("--polarity on --swap-xy --flip-x"),
            (std::vector<Event>{{1'000'000, 27, 1, true, 0}, {1'500'000, 24, 30, true, 0}}));
  EXPECT_EQ(open_event_file(at("out.h5"))->image_size(), (ImageSize{30, 40}));
  EXPECT_EQ(convert("--rotate 90"), convert("--swap-xy --flip-x"));
  EXPECT_EQ(convert("--rotate 180"), convert("--flip-x --flip-y"));
  EXPECT_EQ(convert("--rotate 270"), convert("--swap-xy --flip-y"));
  EXPECT_EQ(convert("--rotate 90 --flip-x"), convert("--swap-xy")) << "the flip comes after the turn";
  const Outcome outcome = saccade("convert " + at("in.csv") + " " + at("out.csv") +
                                  " --from 0.1 --region 0,0,35,30 --polarity on");
  EXPECT_EQ(outcome.text, at("out.csv") +
                              ": 1 events\nremoved: 1 outside the time\nremoved: 1 outside the region\n"
                              "removed: 1 of the other polarity\n");
}

TEST_F(Recordings, ConvertRejectsWhatItCannotDoAndLeavesNothing) {
  write("two.csv", size_, {{10, 1, 1, true, 0}, {20, 1, 1, false, 1}}, 2);
  write("back.csv", size_, {{20, 1, 1, true, 0}, {10, 1, 1, false, 0}});
  folder_.write("cut.csv", "1,2,3,1\n2,2,3");
  folder_.write("wide.csv", "1,2,3,1\n2,200,3,1\n");
  const auto refused = [&](const std::string& arguments, const std::string& message) {
    const Outcome outcome = saccade("convert " + arguments);
    EXPECT_EQ(outcome.status, 2) << arguments;
    EXPECT_THAT(outcome.text, HasSubstr(message)) << arguments;
  };
  refused(at("two.csv") + " " + at("out.aedat") + " --size 40x30",
          "found two cameras of 40x30, expected 128x128");
  refused(at("back.csv") + " " + at("out.h5"), "expected events sorted by time");
  refused(at("cut.csv") + " " + at("out.h5"), "cut.csv:2: found 3 fields");
  refused(at("wide.csv") + " " + at("out.log") + " --size 128x128", "an event at 200, 3");
  refused(at("wide.csv") + " " + at("out.log") + " --size 128x128 --flip-x", "--region removes others");
  refused(at("two.csv") + " " + at("out.mp4"), "the extension .mp4, expected one of .aedat");
  refused(at("two.csv") + " " + at("out.csv") + " --region 1,2,3",
          "--region: found 1,2,3, expected X,Y,WIDTH,HEIGHT");
  refused(at("two.csv") + " " + at("out.csv") + " --crop", "--crop: ");
  refused(at("two.csv") + " " + at("out.csv") + " --rotate 45", "--rotate: ");
  refused(at("two.csv") + " " + at("out.csv") + " --rotate 90 --swap-xy", "--swap-xy");
  refused(at("two.csv") + " " + at("out.csv") + " --from 2 --until 1", "--until: found 1");
  for (const auto& entry : std::filesystem::directory_iterator(folder_ / "")) {
    EXPECT_EQ(entry.path().filename().string().find("out"), std::string::npos) << entry.path();
  }
  EXPECT_EQ(saccade("convert " + at("two.csv") + " " + at("right.h5") + " --camera right").status, 0);
  EXPECT_EQ(read_file(at("right.h5")), (std::vector<Event>{{20, 1, 1, false, 0}}));
}

TEST_F(Recordings, ConvertRemovesAndCountsWhatLiesOutsideTheImageThatTheRecordingStates) {
  const auto davis = [](std::uint32_t x, std::uint32_t y, char t) {
    const std::uint32_t address = y << 22 | x << 12;
    std::string record;
    for (int shift = 24; shift >= 0; shift -= 8) record += static_cast<char>(address >> shift & 0xff);
    return record + std::string({0, 0, 0, t});
  };
  folder_.write("in.aedat", "#!AER-DAT2.0\r\n# AEChip: Davis346blue\r\n" + davis(345, 259, 1) +
                                davis(345, 306, 2) + davis(0, 0, 3));
  EXPECT_THAT(saccade("info " + at("in.aedat")).text,
              AllOf(HasSubstr("outside the image     1\n"), HasSubstr("events                3\n")));
  const Outcome outcome = saccade("convert " + at("in.aedat") + " " + at("out.csv"));
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.text, at("out.csv") + ": 2 events\nremoved: 1 outside the image\n");
  EXPECT_EQ(bytes_of(at("out.csv")), "t_us,x,y,p\n1,0,0,0\n3,345,259,0\n");
}

TEST_F(Recordings, AGuessedImageSizeIsNamedByConvertAndDetect) {
  std::string content = "#!AER-DAT2.0\r\n# made by v2e\r\n";
  for (int i = 0; i < 100; ++i) {
    const std::uint32_t address =
        static_cast<std::uint32_t>(160 + i) << 22 | static_cast<std::uint32_t>(246 + i) << 12;
    for (int shift = 24; shift >= 0; shift -= 8) content += static_cast<char>(address >> shift & 0xff);
    content += std::string({0, 0, 0, static_cast<char>(i)});
  }
  folder_.write("v2e.aedat", content);
  EXPECT_THAT(saccade("convert " + at("v2e.aedat") + " " + at("v2e.csv")).text,
              HasSubstr("guessed: the image size 346x260, from the addresses; --size sets it\n"));
  EXPECT_THAT(saccade("detect " + at("v2e.aedat") + " --out " + at("run")).text,
              HasSubstr("guessed the image size 346x260"));
}

TEST_F(Recordings, ConvertRejectsTheRecordingItselfAsOutputUnderAnyNameEvenWithForce) {
  write("in.csv", size_, few_);
  std::filesystem::create_hard_link(at("in.csv"), at("hard.csv"));
  std::filesystem::create_symlink("in.csv", at("soft.csv"));
  write("data.log", {304, 240}, few_);
  const std::string csv = bytes_of(at("in.csv")), info = bytes_of(at("info.log"));
  for (const char* name : {"in.csv", "./in.csv", "hard.csv", "soft.csv"}) {
    const Outcome outcome = saccade("convert --force --until 0.1 " + at("in.csv") + " " + at(name));
    EXPECT_EQ(outcome.status, 2) << name;
    EXPECT_THAT(outcome.text, HasSubstr("found the file that is read, " + at("in.csv"))) << name;
  }
  EXPECT_EQ(saccade("convert --until 0.1 " + at("in.csv") + " " + at("in.csv")).status, 2);
  EXPECT_EQ(saccade("convert --force " + at("data.log") + " " + at("binaryevents.log")).status, 2)
      << "both names have info.log beside them";
  EXPECT_EQ(saccade("convert --force " + at("") + " " + at("data.log")).status, 2) << "the folder's log";
  EXPECT_EQ(bytes_of(at("in.csv")), csv);
  EXPECT_EQ(bytes_of(at("info.log")), info);
}

TEST_F(Recordings, ConvertReplacesAFileThatExistsWithForceOnly) {
  write("in.csv", size_, few_);
  folder_.write("out.log", "years of work\n");
  folder_.write("new.info.log", "years of work\n");
  for (const char* name : {"out.log", "new.log"}) {
    const Outcome outcome = saccade("convert " + at("in.csv") + " " + at(name));
    EXPECT_EQ(outcome.status, 2) << name;
    EXPECT_THAT(outcome.text, HasSubstr("found a file that exists, expected another name, or --force"));
  }
  EXPECT_EQ(bytes_of(at("out.log")), "years of work\n");
  EXPECT_FALSE(std::filesystem::exists(at("new.log")));
  EXPECT_EQ(saccade("convert --force --size 40x30 " + at("in.csv") + " " + at("out.log")).status, 0);
  EXPECT_EQ(read_file(at("out.log")), few_);
}

/// A recording of a DAVIS240 with an event, a frame and a trigger.
std::string davis_recording() {
  std::string bytes = "#!AER-DAT2.0\r\n# AEChip: eu.seebetter.ini.chips.davis.DAVIS240C\r\n";
  const auto add = [&](std::uint32_t address, std::uint32_t t_us) {
    for (const std::uint32_t word : {address, t_us})
      for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(word >> shift & 0xffu);
  };
  add(1u << 11, 5);
  for (std::uint32_t cycle = 0; cycle < 2; ++cycle)
    for (std::uint32_t pixel = 0; pixel < 240 * 180; ++pixel)
      add(1u << 31 | pixel / 240 << 22 | pixel % 240 << 12 | cycle << 10 | 500 * (1 - cycle), 10 + cycle);
  add(1u << 10 | 3, 12);
  return bytes;
}

TEST_F(Recordings, ConvertAlsoWritesFramesReadingsAndTriggers) {
  folder_.write("in.aedat", davis_recording());
  const std::string call = "convert " + at("in.aedat") + " " + at("out.npz") + " --also frames,imu,triggers ";
  const Outcome outcome = saccade(call);
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_EQ(outcome.text, at("out.npz") + ": 1 events\n" + at("out.frames") + ": 1 frames\n" +
                              "no inertial readings in the recording\n" + at("out.triggers.csv") +
                              ": 1 triggers\n");
  EXPECT_EQ(bytes_of(at("out.triggers.csv")), "t_us,channel,kind,source\n12,0,rising,DAVIS\n");
  EXPECT_EQ(bytes_of(at("out.frames/frames.csv")),
            "file,t_us,begin_us,end_us,x,y,source\n000000.png,10,10,11,0,0,DAVIS\n");
  // A PNG of 240 x 180 with 16 bits of grey.
  EXPECT_EQ(bytes_of(at("out.frames/000000.png")).substr(0, 26),
            std::string("\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\0\xf0\0\0\0\xb4\x10\0", 26));
  EXPECT_FALSE(std::filesystem::exists(at("out.imu.csv")));

  std::filesystem::remove(at("out.npz"));
  EXPECT_THAT(saccade(call).text, HasSubstr("out.triggers.csv: found a file that exists"));
  std::filesystem::remove(at("out.triggers.csv"));
  EXPECT_THAT(saccade(call).text, HasSubstr("out.frames: found a folder that exists"));
  EXPECT_FALSE(std::filesystem::exists(at("out.npz")));
  EXPECT_EQ(saccade(call + "--force").status, 0);
  std::filesystem::remove(at("out.frames/frames.csv"));
  EXPECT_THAT(saccade(call + "--force").text, HasSubstr("expected a folder of frames to replace"));
  EXPECT_TRUE(std::filesystem::exists(at("out.frames/000000.png"))) << "a folder of others is left alone";
  EXPECT_THAT(saccade("convert " + at("in.aedat") + " " + at("b.npz") + " --also frames,sound").text,
              HasSubstr("expected some of frames,imu,triggers"));
}

TEST_F(Recordings, ConvertDeletesOlderFramesAndTriggersOfARecordingThatHasNone) {
  folder_.write("in.aedat", davis_recording());
  write("plain.csv", size_, few_);
  const std::string rest = " " + at("out.npz") + " --force --also frames,imu,triggers";
  ASSERT_EQ(saccade("convert " + at("in.aedat") + rest).status, 0);
  ASSERT_TRUE(std::filesystem::exists(at("out.triggers.csv")));
  const Outcome outcome = saccade("convert " + at("plain.csv") + rest);
  EXPECT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_THAT(outcome.text, HasSubstr("no frames in the recording"));
  EXPECT_FALSE(std::filesystem::exists(at("out.frames")));
  EXPECT_FALSE(std::filesystem::exists(at("out.triggers.csv")));
}

TEST_F(Recordings, ARecordingWithoutImageSizeIsNamedTogetherWithTheOptionThatSetsIt) {
  folder_.write("plain.txt", "10 3 4 1\n20 3 4 0\n");
  const Outcome outcome = saccade("detect " + at("plain.txt") + " --out " + at("run"));
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.text,
              HasSubstr(at("plain.txt") + ": found text without an image size, expected --size"));
}

TEST_F(Recordings, ATruncatedHdf5FileIsBadInput) {
  std::string bytes = bytes_of(write("whole.h5", size_, few_));
  folder_.write("cut.h5", bytes.substr(0, bytes.size() / 2));
  const Outcome outcome = saccade("info " + at("cut.h5"));
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.text, HasSubstr("cut.h5: found what libhdf5 cannot open"));
}

TEST_F(Recordings, AFolderWithALogAndTheFolderOfARunAreReadAsTheyAre) {
  std::filesystem::create_directory(folder_ / "left");
  write("left/data.log", {304, 240}, few_);
  EXPECT_THAT(saccade("info " + at("left")).text, HasSubstr("event-driven log, codec ev2_ts"));
  EXPECT_EQ(saccade("detect " + at("left") + " --out " + at("run")).status, 0);
  EXPECT_EQ(saccade("convert " + at("run") + " " + at("out.csv")).status, 0) << "the run names its events";
  EXPECT_EQ(read_file(at("out.csv")), few_);
}

}  // namespace
}  // namespace saccade
