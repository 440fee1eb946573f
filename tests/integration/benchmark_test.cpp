// saccade benchmark: entries, resuming, verification, table.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/integration/run_shell.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;
using Json = nlohmann::json;

const std::string benchmark_call = "'" SACCADE_BINARY "' benchmark ";

class BenchmarkCommand : public testing::Test {
 protected:
  BenchmarkCommand() {
    folder_.write("world.yaml",
                  "name: world\nworld: {family: random}\nrun: {duration_s: 0.3}\n"
                  "render: {max_interval_ms: 5}\ndetectors: {best: {}}\ngaze: {detector: none}\n");
    folder_.write("aim.yaml",
                  "name: aim\nrun: {duration_s: 0.1}\nrender: {max_interval_ms: 5}\nlab: {density: 0}\n"
                  "ball: {trajectory: {kind: hold, points_m: [[-0.506, 0, 0.347]]}}\n"
                  "detectors: {best: {}}\ngaze: {detector: best}\n");
    folder_.write("list.yaml",
                  "name: Tiny\nversion: 3\n"
                  "full: {worlds: world.yaml, first_seed: 7, with_ball: 2, without_ball: 1, loop: aim.yaml}\n"
                  "quick: {worlds: world.yaml, first_seed: 7, with_ball: 1, without_ball: 0}\n");
  }
  [[nodiscard]] std::string at(const std::string& name) const { return (folder_ / name).string(); }
  [[nodiscard]] Outcome call(const std::string& arguments) const {
    return run_shell(benchmark_call + arguments + " --list " + at("list.yaml"));
  }
  [[nodiscard]] Json result(const std::string& name) const { return Json::parse(bytes_of(folder_ / name)); }

  TempFolder folder_;
};

TEST_F(BenchmarkCommand, AnEntryHasAResultThatIsVerifiedAndATable) {
  folder_.write("mine.yaml", "detectors:\n  mine: {preset: paper_directed, threshold: 12}\n");
  const Outcome made = call("best " + at("mine.yaml") + " --out " + at("out"));
  ASSERT_EQ(made.status, 0) << made.text;
  EXPECT_THAT(made.text, HasSubstr("## Tiny, version 3\n"));
  EXPECT_THAT(made.text, HasSubstr("\n| mine |"));
  const Json best = result("out/best/result.json");
  EXPECT_EQ(best["list"]["name"], "Tiny");
  EXPECT_EQ(best["configuration"], "{best: {}}");
  ASSERT_EQ(best["runs"].size(), 4u);
  EXPECT_EQ(best["runs"][0]["run"], "ball_7");
  EXPECT_TRUE(best["runs"][0]["figures"]["average_precision"].is_number());
  EXPECT_TRUE(best["runs"][2]["figures"]["alarm_ratio"].is_number()) << "the world without a ball";
  EXPECT_TRUE(best["runs"][3]["loop"]);
  const Json mine = result("out/mine/result.json");
  EXPECT_EQ(best["worlds_digest"], mine["worlds_digest"]) << "both get the same events";
  EXPECT_THAT(bytes_of(folder_ / "out/best/report.html"), HasSubstr("By kind of world"));

  const Outcome again = call("best --out " + at("out"));
  EXPECT_THAT(again.text, HasSubstr("2 have a result")) << "nothing is run twice";
  EXPECT_EQ(result("out/best/result.json"), best);

  const Outcome verified = call("verify " + at("out/mine/result.json") + " --out " + at("verified"));
  EXPECT_EQ(verified.status, 0) << verified.text;
  EXPECT_THAT(verified.text,
              HasSubstr("3 of 4 runs repeated: every figure within 0.01, and the same events"));

  Json changed = mine;
  changed["runs"][0]["figures"]["average_precision"] = 0.987;
  changed["runs"][0]["events_digest"] = "0";
  folder_.write("changed.json", changed.dump());
  const Outcome refuted = call("verify " + at("changed.json") + " --out " + at("verified"));
  EXPECT_EQ(refuted.status, 3) << refuted.text;
  EXPECT_THAT(refuted.text, HasSubstr("in the result 0.9870"));
  EXPECT_THAT(refuted.text, HasSubstr("3 of 4 runs repeated: 2 differences"));

  const Outcome table = run_shell(benchmark_call + "table " + at("out/best/result.json") + " " +
                                  at("changed.json") + " --html " + at("table.html"));
  EXPECT_EQ(table.status, 0) << table.text;
  const std::size_t first = table.text.find("## Tiny");
  EXPECT_NE(table.text.find("## Tiny", first + 1), std::string::npos) << "other events, another table";
  EXPECT_THAT(bytes_of(folder_ / "table.html"), HasSubstr("<th>mine</th>"));
}

/// The runs of a result without what the clock measures.
Json runs_without_costs(Json result) {
  for (Json& run : result["runs"]) {
    run["figures"].erase("us_per_event");
    run.erase("together");
  }
  return result["runs"];
}

TEST_F(BenchmarkCommand, EntriesThatShareTheWorldsHaveTheFiguresThatEachHasAlone) {
  folder_.write("mine.yaml", "detectors:\n  mine: {preset: paper_directed, threshold: 12}\n");
  const std::string entries = "best " + at("mine.yaml") + " eros";
  const std::string command =
      benchmark_call + entries + " --jobs 1 --list " + at("list.yaml") + " --out " + at("out");
  const Outcome killed =
      signal_when("ls " + at("out") + "/eros/ball/runs/*/metrics.json", "KILL", command, at("console"));
  ASSERT_NE(killed.status, 0) << killed.text;
  EXPECT_THAT(killed.text, HasSubstr("3 entries together, ball: 2 runs"));
  const Outcome made = run_shell(command);
  ASSERT_EQ(made.status, 0) << made.text;
  EXPECT_THAT(made.text, HasSubstr("3 entries together, none: 1 runs"));
  EXPECT_THAT(made.text, Not(HasSubstr("3 entries together, ball: 2 runs"))) << "it goes on where it was";
  EXPECT_TRUE(fs::is_empty(folder_ / "out/side-by-side/none/runs")) << "what was handed over is removed";
  for (const std::string name : {"best", "mine", "eros"}) {
    const Outcome alone = call((name == "mine" ? at("mine.yaml") : name) + " --out " + at("alone"));
    ASSERT_EQ(alone.status, 0) << alone.text;
    EXPECT_THAT(alone.text, Not(HasSubstr("entries together, ")));
    const Json together = result("out/" + name + "/result.json");
    EXPECT_EQ(runs_without_costs(together), runs_without_costs(result("alone/" + name + "/result.json")))
        << name;
    EXPECT_TRUE(together["runs"][0]["figures"]["us_per_event"].is_number());
    EXPECT_EQ(together["figures"]["entries_together"], 3.0);
  }
  const Outcome more = call("best cluster --out " + at("out"));
  ASSERT_EQ(more.status, 0) << more.text;
  EXPECT_THAT(more.text, Not(HasSubstr("entries together, "))) << "best has its results";
}

TEST_F(BenchmarkCommand, AWorldThatFailsForAllIsMadeForEachEntryAlone) {
  folder_.write("ends.py", "class Ends:\n    def __init__(self, width, height): raise SystemExit(1)\n");
  const Outcome made = call("best " + at("ends.py") + ":Ends --out " + at("out"));
  EXPECT_EQ(made.status, 1) << made.text;
  EXPECT_TRUE(fs::exists(folder_ / "out/best/result.json")) << made.text;
  EXPECT_FALSE(fs::exists(folder_ / "out/Ends/result.json"));
}

TEST_F(BenchmarkCommand, TheStreamingScoreHasTheLatenciesOfTheList) {
  const std::string without = bytes_of(folder_ / "list.yaml");
  const auto figures_with = [&](const std::string& latency, const std::string& more) {
    folder_.write("list.yaml", without + latency);
    fs::remove_all(folder_ / "out");
    const Outcome made = call("best --out " + at("out") + more);
    EXPECT_EQ(made.status, 0) << made.text;
    return result("out/best/result.json");
  };
  const Json none = figures_with("", "");
  EXPECT_TRUE(none["latency"].is_null());
  const std::string classes =
      "latency: {machine: slow one, classes: {best: {per_call_us: 90000}, fast: {per_call_us: 1}}}\n";
  const Json slow = figures_with(classes, "");
  EXPECT_EQ(slow["latency"]["class"], "best");
  EXPECT_EQ(slow["latency"]["machine"], "slow one");
  const Json fast = figures_with(classes, " --class fast");
  EXPECT_EQ(fast["latency"]["per_call_us"], 1.0);
  const auto figure = [](const Json& of, const char* name) {
    return of["runs"][0]["figures"][name].get<double>();
  };
  for (const char* name : {"average_precision", "recall", "precision"}) {
    EXPECT_EQ(figure(slow, name), figure(none, name))
        << "a slow detector still gets every event at its time: " << name;
    EXPECT_EQ(figure(fast, name), figure(none, name)) << name;
  }
  EXPECT_GT(figure(none, "streaming_average_precision"), 0.0);
  EXPECT_LT(figure(slow, "streaming_average_precision"), figure(fast, "streaming_average_precision"));

  const Outcome verified = call("verify " + at("out/best/result.json") + " --out " + at("verified"));
  EXPECT_EQ(verified.status, 0) << verified.text;
  EXPECT_THAT(
      call("eros --out " + at("out")).text,
      HasSubstr(
          "the entry eros: found the preset eros, for which the list has no latencies, expected --class "
          "with one of best, fast"));
  EXPECT_THAT(call("eros --class slow --out " + at("out")).text,
              HasSubstr("--class: found slow, expected one of best, fast"));
}

TEST_F(BenchmarkCommand, WhatCannotBeDoneIsSaidBeforeTheFirstRun) {
  EXPECT_THAT(call("best").text, HasSubstr("saccade benchmark: found no --out, expected --out FOLDER"));
  EXPECT_THAT(call("nobody --out " + at("out")).text,
              HasSubstr("found nobody, expected a file of detectors"));
  EXPECT_THAT(call("best best --out " + at("out")).text, HasSubstr("two entries with the name best"));
  EXPECT_THAT(call("verify --out " + at("out")).text, HasSubstr("expected the result.json of an entry"));
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(BenchmarkCommand, AResultIsVerifiedWithItsOwnListAlone) {
  const Outcome made = call("best --quick --out " + at("out"));
  ASSERT_EQ(made.status, 0) << made.text;
  EXPECT_THAT(made.text, HasSubstr("quick (no result of an entry)"));
  folder_.write("list.yaml", bytes_of(folder_ / "list.yaml") + "# changed\n");
  const Outcome outcome = call("verify " + at("out/best/result.json") + " --out " + at("verified"));
  EXPECT_EQ(outcome.status, 2) << outcome.text;
  EXPECT_THAT(outcome.text, HasSubstr("expected that of " + at("out/best/result.json")));
  EXPECT_THAT(outcome.text, Not(HasSubstr("runs repeated")));
}

}  // namespace
}  // namespace saccade
