#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/sweep/benchmark_list.h"
#include "apps/sweep/benchmark_result.h"
#include "apps/sweep/benchmark_run.h"
#include "apps/sweep/benchmark_worlds.h"
#include "core/error.h"
#include "tests/config/built_in.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

BenchmarkRow world_with_ball(std::int64_t seed, double average_precision, std::optional<double> reaction_ms) {
  BenchmarkRow row;
  row.part = "ball";
  row.run = "ball_" + std::to_string(seed);
  row.seed = seed;
  row.duration_s = 2.0;
  row.events = 1000;
  row.events_digest = "digest " + std::to_string(seed);
  row.kinds["sensor"] = seed % 2 == 0 ? "dvs128" : "ideal";
  row.had_chance = true;
  row.figures["average_precision"] = average_precision;
  row.figures["reaction_ms"] = reaction_ms;
  row.figures["us_per_event"] = 0.5;
  return row;
}

BenchmarkResult result_named(const std::string& entry, double average_precision) {
  BenchmarkResult result;
  result.entry = entry;
  result.configuration = "{" + entry + ": {}}";
  result.saccade = "1.0 (abc)";
  result.machine = "a machine";
  result.list = "Clutter";
  result.list_digest = "0123";
  for (std::int64_t seed = 0; seed < 4; ++seed)
    result.rows.push_back(world_with_ball(seed, average_precision, 50.0));
  return result;
}

const BenchmarkFigure& figure(const std::vector<BenchmarkFigure>& figures, const std::string& key) {
  return *std::ranges::find(figures, key, &BenchmarkFigure::key);
}

std::string message_of(const auto& work) {
  try {
    work();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(BenchmarkFigures, TheMeanHasAnIntervalAroundItThatIsTheSameEachTime) {
  std::vector<BenchmarkRow> rows;
  for (int i = 0; i < 100; ++i) rows.push_back(world_with_ball(i, i % 2 == 0 ? 0.4 : 0.8, 5.0));
  const BenchmarkFigure precision = figure(figures_of(rows), "average_precision");
  EXPECT_NEAR(*precision.value, 0.6, 1e-12);
  // The mean of 100 values with a standard deviation of 0.2 has one of 0.02: 95 % lie within 1.96 of them. A bound of a
  // bootstrap of 2000 sets is itself off by some percent.
  EXPECT_NEAR(*precision.low, 0.6 - 1.96 * 0.02, 0.005);
  EXPECT_NEAR(*precision.high, 0.6 + 1.96 * 0.02, 0.005);
  EXPECT_EQ(*figure(figures_of(rows), "average_precision").low, *precision.low);
}

TEST(BenchmarkFigures, AWorldInWhichTheBallIsNeverFoundCountsAmongTheSharesOfReactions) {
  const std::vector<BenchmarkRow> rows = {world_with_ball(1, 0.5, 4.0), world_with_ball(2, 0.5, 60.0),
                                          world_with_ball(3, 0.5, 300.0),
                                          world_with_ball(4, 0.0, std::nullopt)};
  const auto figures = figures_of(rows);
  EXPECT_EQ(figure(figures, "reaction_below_10_ms").value, 0.25);
  EXPECT_EQ(figure(figures, "reaction_below_100_ms").value, 0.5);
  EXPECT_EQ(figure(figures, "reaction_ms").value, 60.0) << "the median of those that were found";
  EXPECT_EQ(figure(figures, "us_per_event").value, 0.5);
  EXPECT_EQ(figure(figures, "us_per_ms").value, 0.25) << "500 us in 2 s";
  EXPECT_EQ(figure(figures, "alarm_ratio").value, std::nullopt) << "there is no world without a ball";
}

TEST(BenchmarkFigures, ReliabilityAddsTheObservationsOfAllWorlds) {
  BenchmarkRow one = world_with_ball(1, 0.5, 4.0);
  one.observations = 30;
  one.reliability.emplace();
  (*one.reliability)[9] = {.observations = 30, .inliers = 30, .mean_score = 0.98};
  BenchmarkRow other = one;
  (*other.reliability)[9] = {.observations = 10, .inliers = 2, .mean_score = 0.94};
  const auto sum = reliability_of({one, other});
  ASSERT_TRUE(sum);
  EXPECT_EQ((*sum)[9].observations, 40);
  EXPECT_EQ((*sum)[9].inliers, 32);
  EXPECT_NEAR((*sum)[9].mean_score, (30 * 0.98 + 10 * 0.94) / 40, 1e-12);
  other.reliability.reset();
  EXPECT_FALSE(reliability_of({one, other})) << "a score that is no probability in one world is none";
}

TEST(BenchmarkTable, ResultsOfOtherEventsStandInATableOfTheirOwn) {
  BenchmarkResult other = result_named("other", 0.9);
  other.rows[2].events_digest = "changed";
  const auto groups = groups_of({result_named("worse", 0.5), other, result_named("better", 0.7)});
  ASSERT_THAT(groups, SizeIs(2));
  EXPECT_EQ(groups[0][0].entry, "better");
  EXPECT_EQ(groups[0][1].entry, "worse");
  EXPECT_EQ(groups[1][0].entry, "other");
  BenchmarkResult in_the_loop = result_named("loop", 0.6);
  in_the_loop.rows.push_back(world_with_ball(9, 0.6, 50.0));
  in_the_loop.rows.back().loop = true;
  EXPECT_EQ(in_the_loop.worlds_digest(), result_named("worse", 0.5).worlds_digest())
      << "in the loop the events depend on the entry";
}

TEST(BenchmarkTable, AFigureThatAppliesToNoRowIsNoColumn) {
  const std::string text = benchmark_table_text(groups_of({result_named("mine", 0.5)}));
  EXPECT_THAT(text, HasSubstr("| average precision | 95 % interval |"));
  EXPECT_THAT(text, testing::Not(HasSubstr("alarm"))) << "no row is a world without a ball";
  BenchmarkResult with_alarms = result_named("mine", 0.5);
  with_alarms.rows.push_back(world_with_ball(7, 0.5, 50.0));
  with_alarms.rows.back().part = "none";
  with_alarms.rows.back().figures["alarm_ratio"] = 0.25;
  EXPECT_THAT(benchmark_table_text(groups_of({with_alarms})), HasSubstr("| alarm share, % |"));
}

TEST(BenchmarkResultFile, TheShippedOnesAreOfTheShippedList) {
  const fs::path folder = SACCADE_SOURCE_DIR "/scenarios/benchmarks";
  const BenchmarkList list = read_benchmark_list(folder / "clutter_1.yaml");
  std::string worlds;
  for (const fs::directory_entry& file : fs::directory_iterator(folder / "clutter_1")) {
    const BenchmarkResult result = read_benchmark_result(file.path());
    EXPECT_EQ(result.entry, file.path().stem().string());
    EXPECT_EQ(result.list_digest, list.digest) << file.path();
    EXPECT_THAT(result.rows, SizeIs(259)) << file.path();
    EXPECT_FALSE(result.quick);
    if (worlds.empty()) worlds = result.worlds_digest();
    EXPECT_EQ(result.worlds_digest(), worlds) << file.path();
  }
  EXPECT_FALSE(worlds.empty());
}

TEST(BenchmarkResultFile, ReadsBackAsItWasWritten) {
  const TempFolder folder;
  BenchmarkResult result = result_named("mine", 0.5);
  result.rows[3].reliability.emplace();
  (*result.rows[3].reliability)[2] = {.observations = 4, .inliers = 3, .mean_score = 0.25};
  result.rows[3].together = 5;
  result.latency_machine = "a robot";
  result.latency_class = "best";
  result.latency = {.per_event_us = 0.5, .per_call_us = 20.0};
  write_benchmark_result(folder / "result.json", result);
  const BenchmarkResult read = read_benchmark_result(folder / "result.json");
  EXPECT_EQ(read.configuration, result.configuration);
  EXPECT_EQ(read.worlds_digest(), result.worlds_digest());
  ASSERT_THAT(read.rows, SizeIs(4));
  ASSERT_TRUE(read.rows[3].reliability);
  EXPECT_EQ((*read.rows[3].reliability)[2].inliers, 3);
  EXPECT_EQ(read.rows[3].figures, result.rows[3].figures);
  EXPECT_EQ(read.rows[3].together, 5);
  EXPECT_EQ(figure(figures_of(read.rows), "entries_together").value, 2.0) << "of 1, 1, 1 and 5";
  EXPECT_EQ(read.latency_machine, "a robot");
  EXPECT_EQ(read.latency_class, "best");
  EXPECT_EQ(read.latency.per_event_us, 0.5);
  EXPECT_EQ(read.latency.per_call_us, 20.0);
  EXPECT_EQ(read.rows[3].kinds, result.rows[3].kinds);

  const fs::path bad = folder.write("bad.json", "{\"scenario\": 1}");
  EXPECT_THAT(message_of([&] { static_cast<void>(read_benchmark_result(bad)); }),
              HasSubstr("expected the result.json of an entry"));
}

TEST(BenchmarkList, TheShippedOneJudgesOnJudgingSeedsAndIsQuickOnOthers) {
  const BenchmarkList list = read_benchmark_list(SACCADE_SOURCE_DIR "/scenarios/benchmarks/clutter_1.yaml");
  const auto parts = parts_of(list, false);
  ASSERT_THAT(parts, SizeIs(5));
  EXPECT_THAT(parts[0].seeds, SizeIs(200));
  EXPECT_THAT(parts[1].seeds, SizeIs(50));
  for (const BenchmarkPart& part : parts) {
    EXPECT_TRUE(fs::exists(part.scenario)) << part.scenario;
    EXPECT_GE(part.seeds.front(), 2000);
    EXPECT_LT(part.seeds.back(), 2200);
  }
  ASSERT_TRUE(list.latency);
  for (const std::string& name : built_in().detectors.names()) {
    const bool has =
        std::ranges::any_of(list.latency->classes, [&](const auto& one) { return one.first == name; });
    EXPECT_TRUE(has) << name;
  }
  EXPECT_EQ(parts[2].run_name(2001), "gaze_square_45cm_2001");
  for (const BenchmarkPart& part : parts_of(list, true)) EXPECT_LT(part.seeds.back(), 1000);
}

TEST(BenchmarkList, AKeyThatDoesNotExistIsAMistake) {
  const TempFolder folder;
  const fs::path file = folder.write(
      "list.yaml", "name: l\nversion: 1\nfull: {first_seed: 1, with_ball: 1, without_ball: 1, ball: 3}\n");
  EXPECT_THAT(message_of([&] { static_cast<void>(read_benchmark_list(file)); }), HasSubstr("full.ball"));
}

TEST(BenchmarkEntry, IsADetectorByNameOrAFileWithOne) {
  const TempFolder folder;
  EXPECT_EQ(benchmark_entry("best", built_in()).detectors.one_line(), "{best: {}}");
  const fs::path one = folder.write("one.yaml", "detectors:\n  mine: {preset: best, threshold: 0.4}\n");
  const BenchmarkEntry entry = benchmark_entry(one.string(), built_in());
  EXPECT_EQ(entry.name, "mine");
  EXPECT_THAT(entry.detectors.one_line(), HasSubstr("threshold: 0.4"));
  EXPECT_EQ(entry.detectors.find("mine.radius_px"), nullptr) << "it follows from each world's image";
  const fs::path fixed =
      folder.write("fixed.yaml", "detectors:\n  mine: {preset: best, radius_px: [5, 9]}\n");
  EXPECT_NE(benchmark_entry(fixed.string(), built_in()).detectors.find("mine.radius_px"), nullptr);

  const fs::path two = folder.write("two.yaml", "detectors:\n  a: {preset: best}\n  b: {preset: best}\n");
  EXPECT_THAT(message_of([&] { static_cast<void>(benchmark_entry(two.string(), built_in())); }),
              HasSubstr("found 2 detectors, expected one detector in a file"));
  EXPECT_THAT(message_of([] { static_cast<void>(benchmark_entry("bst", built_in())); }),
              HasSubstr("found bst, expected a file of detectors, FILE.py:CLASS, a program, or"));
}

TEST(BenchmarkEntry, HasTheLatencyClassOfItsPresetOrTheOneThatIsStated) {
  const TempFolder folder;
  const BenchmarkList list = read_benchmark_list(SACCADE_SOURCE_DIR "/scenarios/benchmarks/clutter_1.yaml");
  const auto class_of = [&](const std::string& text, const std::string& stated) {
    return latency_class_of(benchmark_entry(text, built_in()), list, stated, built_in());
  };
  EXPECT_EQ(class_of("eros", ""), "eros");
  const fs::path mine = folder.write("mine.yaml", "detectors:\n  mine: {preset: paper_directed}\n");
  EXPECT_EQ(class_of(mine.string(), ""), "paper_directed");
  EXPECT_EQ(class_of("eros", "best"), "best");
  EXPECT_EQ(work_of(*list.latency, "best").per_call_us, 55.0);
  EXPECT_THAT(message_of([&] { static_cast<void>(class_of("eros", "quick")); }),
              HasSubstr("--class: found quick, expected one of best"));
}

TEST(BenchmarkEntry, IsAlsoAPythonClassOrAProgram) {
  const TempFolder folder;
  const fs::path python = folder.write("mine.py", "class Mine: pass\n");
  const BenchmarkEntry entry = benchmark_entry(python.string() + ":Mine", built_in());
  EXPECT_EQ(entry.name, "Mine");
  EXPECT_EQ(entry.detectors.find("Mine.python")->text, python.string() + ":Mine");
  EXPECT_THAT(message_of([&] {
                static_cast<void>(benchmark_entry((folder / "no.py").string() + ":Mine", built_in()));
              }),
              HasSubstr("no.py, expected a Python file"));
  const fs::path program = folder.write("rings", "#!/bin/sh\n");
  fs::permissions(program, fs::perms::owner_all);
  EXPECT_EQ(benchmark_entry(program.string(), built_in()).detectors.find("rings.command")->text,
            program.string());
}

}  // namespace
}  // namespace saccade
