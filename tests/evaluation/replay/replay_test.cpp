// Pages that replay runs: what they hold is what the folder holds. tests/browser opens them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <vector>

#include "core/error.h"
#include "evaluation/replay/kept_events.h"
#include "evaluation/replay/packed_table.h"
#include "evaluation/replay/replay_page.h"
#include "recording/event_file.h"
#include "recording/format_registry.h"
#include "recording/output_file.h"
#include "tests/evaluation/report/synthetic_run.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::vector<unsigned char> bytes_of_base64(const std::string& text) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::vector<unsigned char> bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6 | static_cast<unsigned>(digits.find(c));
    count += 6;
    if (count < 8) continue;
    count -= 8;
    bytes.push_back(static_cast<unsigned char>(bits >> count));
  }
  return bytes;
}

/// The columns of a table, read as packed_table.h describes them.
std::map<std::string, std::vector<double>> columns_of(const json& description, const std::string& content) {
  const std::vector<unsigned char> packed = bytes_of_base64(content);
  const auto rows = description.at("rows").get<std::size_t>();
  std::vector<unsigned char> bytes(64 * rows + 64);
  uLongf size = bytes.size();
  EXPECT_EQ(uncompress(bytes.data(), &size, packed.data(), packed.size()), Z_OK);
  std::size_t at = 0;
  const auto varint = [&] {
    std::uint64_t value = 0;
    for (int shift = 0;; shift += 7) {
      const unsigned char byte = bytes.at(at++);
      value |= std::uint64_t{byte & 0x7fU} << shift;
      if (byte < 0x80) return value;
    }
  };
  std::map<std::string, std::vector<double>> columns;
  for (const json& column : description.at("columns")) {
    std::vector<double>& values = columns[column.at("name")];
    const std::string kind = column.at("kind");
    std::int64_t last = 0;
    for (std::size_t i = 0; i < rows; ++i) {
      if (kind == "time") {
        last += static_cast<std::int64_t>(varint());
        values.push_back(static_cast<double>(last));
      } else if (kind == "number") {
        const std::uint64_t code = varint();
        if (code > 0) {
          const std::uint64_t zigzag = code - 1;
          last += static_cast<std::int64_t>(zigzag >> 1) ^ -static_cast<std::int64_t>(zigzag & 1);
        }
        values.push_back(code == 0 ? std::nan("")
                                   : static_cast<double>(last) * column.at("step").get<double>());
      } else if (kind == "bit") {
        values.push_back(bytes.at(at + i / 8) >> (i % 8) & 1);
      } else {
        values.push_back(bytes.at(at + i) + (kind == "word" ? 256.0 * bytes.at(at + rows + i) : 0.0));
      }
    }
    if (kind == "bit") at += (rows + 7) / 8;
    if (kind == "byte") at += rows;
    if (kind == "word") at += 2 * rows;
  }
  EXPECT_EQ(at, size);
  return columns;
}

/// A page's head and tables.
struct ReadPage {
  json head;
  std::map<std::string, std::map<std::string, std::vector<double>>> tables;
  std::string text;

  explicit ReadPage(const std::filesystem::path& file) : text(bytes_of(file)) {
    const std::string open = "id=\"head\">";
    const std::size_t begin = text.find(open) + open.size();
    head = json::parse(text.substr(begin, text.find("</script>", begin) - begin));
    std::size_t at = 0;
    for (const json& table : head.at("tables")) {
      const std::string start = "class=\"table\">";
      at = text.find(start, at) + start.size();
      tables[table.at("name")] = columns_of(table, text.substr(at, text.find('<', at) - at));
    }
  }
};

TEST(PackedTable, ReadsBackWhatWasPutIn) {
  PackedTable table("all", 5);
  const std::vector<std::int64_t> times = {0, 0, 127, 128, 3'000'000'000};
  const std::vector<double> numbers = {-0.5, std::nan(""), 1e6, -1e6, 0.254};
  const std::vector<std::uint16_t> words = {0, 255, 256, 1279, 65535};
  const std::vector<std::uint16_t> narrow = {0, 1, 127, 128, 255};
  table.add_times("t", times);
  table.add_numbers("v", 0.01, numbers);
  table.add_words("x", true, words);
  table.add_words("y", false, narrow);
  table.add_bits("on", {true, false, false, true, true});
  auto columns = columns_of(json::parse(table.description().dump()), table.content());
  EXPECT_THAT(columns["t"], testing::ElementsAre(0, 0, 127, 128, 3e9));
  EXPECT_THAT(columns["v"],
              testing::ElementsAre(-0.5, testing::IsNan(), testing::DoubleNear(1e6, 1e-6),
                                   testing::DoubleNear(-1e6, 1e-6), testing::DoubleNear(0.25, 1e-12)));
  EXPECT_THAT(columns["x"], testing::ElementsAre(0, 255, 256, 1279, 65535));
  EXPECT_THAT(columns["y"], testing::ElementsAre(0, 1, 127, 128, 255));
  EXPECT_THAT(columns["on"], testing::ElementsAre(1, 0, 0, 1, 1));
}

TEST(KeptEvents, AreAllUpToABoundAndEverySecondBeyondIt) {
  KeptEvents kept(8);
  for (int i = 0; i < 8; ++i) kept.add({.t_us = i});
  EXPECT_EQ(kept.every(), 1U);
  EXPECT_EQ(kept.of(0).size(), 8U);
  for (int i = 8; i < 33; ++i) kept.add({.t_us = i});
  EXPECT_EQ(kept.total(), 33U);
  EXPECT_EQ(kept.every(), 8U);
  std::vector<std::int64_t> times;
  for (const Event& event : kept.of(0)) times.push_back(event.t_us);
  EXPECT_THAT(times, testing::ElementsAre(0, 8, 16, 24, 32));
}

TEST(ReplayPage, HoldsEveryEventTruthAndDetectionOfARun) {
  const TempFolder folder;
  const std::filesystem::path run = folder / "run";
  const Metrics metrics = write_synthetic_run(run, false);
  write_replay(run, built_in_formats(), folder / "page.html");
  ReadPage page(folder / "page.html");

  std::vector<Event> events;
  const auto reader = open_event_file(run / metrics.events_file);
  while (reader->read(events, 10'000) > 0) {
  }
  ASSERT_GT(events.size(), 1'000U);
  auto& shown = page.tables["events"];
  ASSERT_EQ(shown["t"].size(), events.size());
  for (std::size_t i = 0; i < events.size(); ++i) {
    ASSERT_EQ(shown["t"][i], static_cast<double>(events[i].t_us - metrics.start_us));
    ASSERT_EQ(shown["x"][i], events[i].x);
    ASSERT_EQ(shown["y"][i], events[i].y);
    ASSERT_EQ(shown["on"][i], events[i].on ? 1.0 : 0.0);
  }
  const std::vector<TruthRow> truth = read_table<TruthRow>(run / "truth.csv");
  ASSERT_EQ(page.tables["truth"]["x"].size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i)
    ASSERT_NEAR(page.tables["truth"]["x"][i], truth[i].circle.x_px, 0.0051);

  std::size_t detections = 0;
  for (const json& detector : page.head.at("detectors"))
    detections += page.tables[detector.at("table")]["score"].size();
  EXPECT_EQ(detections, read_table<DetectionRow>(run / "detections.csv").size());
  EXPECT_EQ(page.head.at("events").at("every"), 1);
  // The gaze error of the page is that of the score, where the ball was acquired.
  std::vector<double> errors;
  for (std::size_t i = 0; i < page.tables["eye"]["t"].size(); ++i) {
    if (page.tables["eye"]["t"][i] >= static_cast<double>(*metrics.gaze->score.acquired_at_us))
      errors.push_back(page.tables["eye"]["error"][i]);
  }
  std::ranges::nth_element(errors, errors.begin() + std::ssize(errors) / 2);
  EXPECT_NEAR(errors[errors.size() / 2], *metrics.gaze->score.fixation_error_deg.median, 0.02);
  // A run that was made elsewhere has no scene: the page has no library for it.
  EXPECT_EQ(page.text.find("WebGLRenderer=function"), std::string::npos);
}

TEST(ReplayPage, NamesNothingOutsideOfItself) {
  const TempFolder folder;
  write_synthetic_run(folder / "run", false);
  write_file(folder / "run" / "scene.json",
             R"({"schema":1,"bodies":[],"geoms":[],"meshes":[],"textures":[]})");
  write_replay(folder / "run", built_in_formats(), folder / "page.html");
  const std::string text = bytes_of(folder / "page.html");
  for (const char* const outside : {"<script src", "<link", "@import"})
    EXPECT_EQ(text.find(outside), std::string::npos) << outside;
  EXPECT_THAT(text, HasSubstr("three.js authors"));
}

TEST(ReplayPage, OfTheMostEventsThatItShowsAllIsBelow15MB) {
  const TempFolder folder;
  {
    // Noise compresses worst: nothing of an event follows from those before.
    const auto writer = create_event_file(folder / "noise.npz", {128, 128});
    std::mt19937 random(1);
    std::vector<Event> events(KeptEvents::most);
    for (std::size_t i = 0; i < events.size(); ++i) {
      events[i] = {.t_us = static_cast<std::int64_t>(i * 12'000'000 / events.size() + random() % 3),
                   .x = static_cast<std::uint16_t>(random() % 128),
                   .y = static_cast<std::uint16_t>(random() % 128),
                   .on = random() % 2 == 0};
    }
    std::ranges::sort(events, {}, &Event::t_us);
    writer->write(events);
    writer->commit();
  }
  write_recording_replay(folder / "noise.npz", built_in_formats(), {}, folder / "page.html");
  EXPECT_LT(std::filesystem::file_size(folder / "page.html"),
            15'000'000U - 1'500'000U);  // with room for three.js and the tables
}

TEST(ReplayPage, OfABrokenFolderIsOneMessageAndNoFile) {
  const TempFolder folder;
  EXPECT_THROW(write_replay(folder / "none", built_in_formats(), folder / "page.html"), InputError);
  write_synthetic_run(folder / "run", false);
  for (const char* const text : {"{\"schema\":1,", "{\"schema\":2}", "{\"schema\":1,\"bodies\":[]}", "[]"}) {
    write_file(folder / "run" / "scene.json", text);
    try {
      write_replay(folder / "run", built_in_formats(), folder / "page.html");
      FAIL() << text;
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr("scene.json")) << text;
    }
  }
  EXPECT_FALSE(std::filesystem::exists(folder / "page.html"));
}

TEST(ReplayPage, OfARunWhoseEventsAreGoneSaysSo) {
  const TempFolder folder;
  const Metrics metrics = write_synthetic_run(folder / "run", false);
  std::filesystem::remove(folder / "run" / metrics.events_file);
  write_replay(folder / "run", built_in_formats(), folder / "page.html");
  const ReadPage page(folder / "page.html");
  EXPECT_THAT(page.head.at("events_remark").get<std::string>(), HasSubstr(metrics.events_file));
  EXPECT_FALSE(page.tables.contains("events"));
}

TEST(ReplayPage, OfARecordingIsNamedAfterItAndShowsBothCameras) {
  const TempFolder folder;
  {
    const auto writer = create_event_file(folder / "two <script> eyes.csv", {64, 48}, 2);
    const std::vector<Event> events = {{.t_us = 5'000'000, .x = 3, .y = 4, .on = true},
                                       {.t_us = 5'000'010, .x = 63, .y = 47, .camera = 1}};
    writer->write(events);
    writer->commit();
  }
  write_recording_replay(folder / "two <script> eyes.csv", built_in_formats(), {}, folder / "page.html");
  ReadPage page(folder / "page.html");
  EXPECT_EQ(page.head.at("title"), "two <script> eyes.csv");
  EXPECT_EQ(page.tables["events"]["t"], std::vector<double>{0.0});
  EXPECT_EQ(page.tables["events_right"]["x"], std::vector<double>{63.0});
}

}  // namespace
}  // namespace saccade
