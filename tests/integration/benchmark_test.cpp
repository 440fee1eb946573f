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
