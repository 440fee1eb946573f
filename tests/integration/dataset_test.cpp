// saccade dataset: making, killing and resuming, checking, and what is refused.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/integration/run_shell.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using Json = nlohmann::json;

const std::string source = SACCADE_SOURCE_DIR;
const std::string dataset_call = "'" SACCADE_BINARY "' dataset ";

class DatasetCommand : public testing::Test {
 protected:
  [[nodiscard]] std::string at(const std::string& name) const { return (folder_ / name).string(); }
  /// The shortest runs that there are; `more` are further lines of the file.
  [[nodiscard]] std::string file(const std::string& more = "licence: CC0-1.0\n", int seeds = 3) const {
    return folder_
        .write("set.yaml", "name: tiny\nscenario: " + source +
                               "/scenarios/look_at_ball.yaml\n"
                               "set: {run.duration_s: 0.03, render.max_interval_ms: 5, lab.density: 0, "
                               "output.labels: true,\n"
                               "  output.ground_truth: {rate_hz: 100, depth: true, format: npz}}\n"
                               "splits:\n  train: {axes: {seed: {seeds: " +
                               std::to_string(seeds) +
                               "}}}\n  test: {set: {emulator.preset: ideal}, axes: {seed: [9]}}\n" + more)
        .string();
  }
  [[nodiscard]] Outcome make(const std::string& out, const std::string& options = "",
                             const std::string& before = "") const {
    return run_shell(before + dataset_call + at("set.yaml") + " --out " + at(out) + " " + options);
  }
  [[nodiscard]] Json card(const std::string& out) const {
    return Json::parse(bytes_of(folder_ / out / "card.json"));
  }

  TempFolder folder_;
};

TEST_F(DatasetCommand, ADataSetHasSplitsACardAndFilesThatItsCheckCompares) {
  static_cast<void>(file());
  const Outcome made = make("set");
  ASSERT_EQ(made.status, 0) << made.text;
  EXPECT_THAT(made.text, HasSubstr("train: 3 runs, 0.1 s, "));
  const Json json = card("set");
  EXPECT_EQ(json["licence"], "CC0-1.0");
  ASSERT_EQ(json["runs"].size(), 4u);
  EXPECT_EQ(json["runs"][3]["split"], "test");
  EXPECT_EQ(json["runs"][3]["seed"], 9);
  const fs::path run = folder_ / "set" / std::string(json["runs"][0]["folder"]);
  EXPECT_EQ(fs::file_size(run / "events.npy"), 192 + 13 * json["runs"][0]["events"].get<std::uintmax_t>());
  EXPECT_TRUE(fs::exists(run / "labels.npz"));
  EXPECT_TRUE(fs::exists(run / "ground_truth.npz"));
  EXPECT_FALSE(fs::exists(run / "detections.csv")) << "results of detectors are no data";
  const std::string page = bytes_of(folder_ / "set/card.md");
  EXPECT_THAT(page, HasSubstr("|licence|CC0-1.0|"));
  EXPECT_THAT(page, HasSubstr("\n|train|3|0.1|"));
  EXPECT_THAT(page, HasSubstr("## Known limits"));

  const Outcome whole = run_shell(dataset_call + "check " + at("set"));
  EXPECT_EQ(whole.status, 0) << whole.text;
  EXPECT_THAT(whole.text, HasSubstr("as on the card, digest " + std::string(json["digest"])));

  std::string truth = bytes_of(run / "truth.csv");
  truth[truth.size() - 2] = truth[truth.size() - 2] == '1' ? '2' : '1';
  std::ofstream(run / "truth.csv", std::ios::binary) << truth;
  fs::remove(run / "labels.npz");
  folder_.write("set/test/runs/note.txt", "x");
  const Outcome broken = run_shell(dataset_call + "check " + at("set"));
  EXPECT_EQ(broken.status, 3);
  EXPECT_THAT(broken.text, HasSubstr("truth.csv: digest "));
  EXPECT_THAT(broken.text, HasSubstr("labels.npz: missing"));
  EXPECT_THAT(broken.text, HasSubstr("test/runs/note.txt: not on the card"));
  EXPECT_THAT(broken.text, HasSubstr("3 differences"));

  fs::remove_all(run);
  fs::remove(folder_ / "set/test/runs/note.txt");
  const Outcome again = make("set");
  EXPECT_EQ(again.status, 0) << again.text;
  EXPECT_EQ(card("set"), json) << "the run has the same bytes again";
  EXPECT_EQ(run_shell(dataset_call + "check " + at("set")).status, 0);
}

TEST_F(DatasetCommand, AKilledDataSetThatIsContinuedHasTheCardOfAnUndisturbedOne) {
  static_cast<void>(file());
  ASSERT_EQ(make("whole").status, 0);
  const std::string condition = "[ $(ls " + at("killed") + "/train/runs/*/metrics.json | wc -l) -ge 1 ]";
  const Outcome killed =
      signal_when(condition, "KILL", dataset_call + at("set.yaml") + " --jobs 1 --out " + at("killed"),
                  at("console.txt"));
  EXPECT_NE(killed.status, 0);
  const Outcome early = run_shell(dataset_call + "check " + at("killed"));
  EXPECT_EQ(early.status, 2);
  EXPECT_THAT(early.text, HasSubstr("found a data set without all of its runs"));
  ASSERT_EQ(make("killed").status, 0);
  EXPECT_EQ(bytes_of(folder_ / "killed/card.json"), bytes_of(folder_ / "whole/card.json"));
  EXPECT_EQ(bytes_of(folder_ / "killed/card.md"), bytes_of(folder_ / "whole/card.md"));
  EXPECT_EQ(run_shell(dataset_call + "check " + at("killed")).status, 0);
}

TEST_F(DatasetCommand, AFolderBelongsToOneFile) {
  static_cast<void>(file("", 1));
  ASSERT_EQ(make("set").status, 0);
  EXPECT_EQ(card("set")["licence"], nullptr);
  EXPECT_THAT(bytes_of(folder_ / "set/card.md"), HasSubstr("|licence|not stated|"));
  static_cast<void>(file("", 2));
  const Outcome other = make("set");
  EXPECT_EQ(other.status, 2);
  EXPECT_THAT(other.text,
              HasSubstr("found the data set tiny of another file or --set, expected a new folder"));
  EXPECT_EQ(card("set")["runs"].size(), 2u);
  static_cast<void>(file("licence: MIT\n", 1));
  EXPECT_EQ(make("set").status, 0) << "the same runs: the card alone changes";
  EXPECT_EQ(card("set")["licence"], "MIT");
  fs::create_directory(folder_ / "other");
  folder_.write("other/note.txt", "x");
  EXPECT_THAT(make("other").text, HasSubstr("found a folder with other files in it"));
  EXPECT_FALSE(fs::exists(folder_ / "other/plan.json"));
}

TEST_F(DatasetCommand, WhatIsWrongInTheFileIsReportedAtOnceAndLeavesNothing) {
  folder_.write("set.yaml",
                "name: tiny\nscenario: " + source +
                    "/scenarios/look_at_ball.yaml\nlicense: MIT\nset: {output.events: csv, lab.cluter: 1}\n"
                    "splits:\n  train: {axes: {seed: [1]}, seeds: 4}\n  test: {axes: {seed: [1]}}\n");
  const Outcome outcome = make("set", "--engine cloud");
  EXPECT_EQ(outcome.status, 2);
  for (const char* part :
       {"set.yaml:3: license: ", "no output.events: a data set has events.npy",
        "splits.train.seeds: found no such key", "found cloud, expected one of local, slurm"})
    EXPECT_THAT(outcome.text, HasSubstr(part));
  EXPECT_FALSE(fs::exists(folder_ / "set"));

  folder_.write("set.yaml", "name: tiny\nscenario: " + source +
                                "/scenarios/look_at_ball.yaml\nset: {lab.cluter: 1}\n"
                                "splits:\n  train: {axes: {seed: [1]}}\n");
  EXPECT_THAT(make("set").text, HasSubstr("lab.cluter"));
  folder_.write("set.yaml", "name: tiny\nscenario: " + source +
                                "/scenarios/look_at_ball.yaml\n"
                                "splits:\n  train: {axes: {seed: [1, 2]}}\n  test: {axes: {seed: [2]}}\n");
  EXPECT_THAT(make("set").text, HasSubstr("splits.test: found the run of seed 2 that train has too"));
  folder_.write("set.yaml", "name: tiny\nscenario: nothing\n");
  EXPECT_THAT(make("set").text, HasSubstr("splits: found nothing, expected a block"));
  EXPECT_FALSE(fs::exists(folder_ / "set"));
  EXPECT_THAT(run_shell(dataset_call + "check " + at("none")).text,
              HasSubstr("found no folder, expected the folder of a data set"));
}

TEST_F(DatasetCommand, AFullDiskStopsItAndItContinuesWhenThereIsRoom) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "the limit of a file's size ends programs with the thread sanitizer";
#endif
  static_cast<void>(file());
  ASSERT_EQ(make("whole").status, 0);
  // Files of at most 150 kB (300 blocks): the tables fit, the depth does not.
  const Outcome full = make("set", "", "trap '' XFSZ; ulimit -f 300; ");
  EXPECT_EQ(full.status, 1) << full.text;
  EXPECT_THAT(full.text, HasSubstr("goes on when there is room"));
  EXPECT_FALSE(fs::exists(folder_ / "set/card.json"));
  ASSERT_EQ(make("set").status, 0);
  EXPECT_EQ(bytes_of(folder_ / "set/card.json"), bytes_of(folder_ / "whole/card.json"));
}

TEST_F(DatasetCommand, SlurmMakesTheSameDataAsThisMachineAlone) {
  static_cast<void>(file());
  ASSERT_EQ(make("local").status, 0);
  const Outcome outcome = make("slurm", "--engine slurm --jobs 2 --batch 2",
                               "'" + source + "/tests/integration/with_slurm' " + at("daemons") + " ");
  constexpr int no_slurm = 77;
  if (outcome.status == no_slurm) {
    std::cerr << outcome.text;
    GTEST_SKIP() << "NOT TESTED: the engine slurm. " << outcome.text;
  }
  EXPECT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_TRUE(fs::exists(folder_ / "slurm/train/slurm.sh")) << "the runs were made by Slurm";
  EXPECT_EQ(bytes_of(folder_ / "slurm/card.json"), bytes_of(folder_ / "local/card.json"));
}

}  // namespace
}  // namespace saccade
