#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include "apps/sweep/dataset_card.h"
#include "apps/sweep/dataset_file.h"
#include "apps/sweep/sweep_plan.h"
#include "core/error.h"
#include "tests/config/built_in.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

const std::string head = "name: s\nscenario: " SACCADE_SOURCE_DIR "/scenarios/look_at_ball.yaml\n";

std::vector<std::string> lines_of(const auto& work) {
  std::vector<std::string> lines;
  try {
    work();
  } catch (const InputError& error) {
    for (const Problem& problem : error.problems()) lines.push_back(problem.text());
  }
  return lines;
}

class Dataset : public testing::Test {
 protected:
  DatasetFile read(const std::string& yaml, const std::vector<std::string>& sets = {}) {
    return read_dataset_file(folder_.write("set.yaml", head + yaml), sets);
  }
  std::vector<std::string> complaints(const std::string& yaml) {
    return lines_of([&] { static_cast<void>(read(yaml)); });
  }

  TempFolder folder_;
};

TEST(ShippedDataset, TheExampleSplitsRunsOfTrainingSeeds) {
  const DatasetFile file = read_dataset_file(SACCADE_SOURCE_DIR "/examples/dataset/balls.yaml", {});
  ASSERT_THAT(file.splits, SizeIs(2));
  for (const SweepConfig& split : file.splits) {
    const SweepPlan plan = plan_sweep(split, "version 1", built_in());
    for (const PlannedRun& run : plan.runs) EXPECT_GE(run.seed, 100000);
  }
}

TEST_F(Dataset, ASplitHasTheKeysOfTheFileAndItsOwnWhichReplaceThem) {
  const DatasetFile file = read(
      "licence: MIT\nset: {lab.density: 0, run.duration_s: 1}\naxes: {lab.clutter: [textured, rectilinear]}\n"
      "splits:\n"
      "  train: {axes: {seed: {seeds: 2}}}\n"
      "  test: {set: {run.duration_s: 2}, axes: {seed: [9], lab.clutter: [textured]}}\n",
      {"lab.density=0.5"});
  EXPECT_EQ(file.licence, "MIT");
  ASSERT_THAT(file.splits, SizeIs(2));
  const SweepPlan train = plan_sweep(file.splits[0], "version 1", built_in());
  const SweepPlan test = plan_sweep(file.splits[1], "version 1", built_in());
  EXPECT_EQ(train.config.name, "train");
  EXPECT_THAT(train.runs, SizeIs(4));
  EXPECT_THAT(train.runs[0].scenario, HasSubstr("duration_s: 1\n"));
  EXPECT_THAT(train.runs[0].scenario, HasSubstr("density: 0.5\n"));
  EXPECT_THAT(train.runs[0].scenario, HasSubstr("events: npz\n"));
  ASSERT_THAT(test.runs, SizeIs(1));
  EXPECT_THAT(test.runs[0].scenario, HasSubstr("duration_s: 2\n"));
  EXPECT_EQ(test.runs[0].seed, 9);
}

TEST_F(Dataset, ASplitMayHaveNothingOfItsOwn) {
  const DatasetFile file = read("axes: {seed: {seeds: 3}}\nsplits: {all: }\n");
  EXPECT_THAT(plan_sweep(file.splits.at(0), "version 1", built_in()).runs, SizeIs(3));
}

TEST_F(Dataset, EveryMistakeIsReportedOnceWithItsLine) {
  EXPECT_THAT(complaints("set: 3\nsplits:\n  a: {axes: {seed: [1]}}\n  b: {axes: {seed: [2]}}\n"),
              ElementsAre(HasSubstr("set.yaml:3: set: found 3, expected a block of keys")));
  EXPECT_THAT(complaints("axes: {seed: [1]}\n"), ElementsAre(HasSubstr("splits: found nothing")));
  EXPECT_THAT(complaints("splits: {a: 3}\n"), ElementsAre(HasSubstr("splits.a: found 3, expected a block")));
  EXPECT_THAT(complaints("splits: {a: {}}\n"), ElementsAre(HasSubstr("axes: found nothing")));
  EXPECT_THAT(complaints("splits:\n  a: {axes: {seed: [1]}, nme: 2}\nlicense: MIT\n"),
              ElementsAre(HasSubstr("set.yaml:5: license"),
                          HasSubstr("set.yaml:4: splits.a.nme: found no such key")));
  for (const char* set :
       {"set: {output.events: csv}", "set: {output: {events: csv}}", "axes: {output.events: [csv, h5]}"}) {
    EXPECT_THAT(complaints(std::string(set) + "\nsplits: {a: {axes: {seed: [1]}}}\n"),
                Contains(HasSubstr("no output.events: a data set has events.npy")))
        << set;
  }
}

DatasetCard card_of_two() {
  DatasetCard card{.name = "two",
                   .description = "",
                   .licence = "",
                   .program = "saccade 1",
                   .limits = {"none|all"},
                   .runs = {}};
  for (const char* split : {"train", "test"}) {
    DatasetRun run;
    run.split = split;
    run.folder = std::string(split) + "/runs/0";
    run.seed = 7;
    run.values = {{"seed", "7"}, {"emulator.preset", "ideal"}};
    run.duration_s = 1.5;
    run.image = {128, 96};
    run.events = 1000;
    run.instants = 4;
    run.with_target = 3;
    run.files = {{"events.npy", 13000, "0123"}};
    card.runs.push_back(run);
  }
  return card;
}

TEST(DatasetCard, IsReadAsItWasWritten) {
  const TempFolder folder;
  const DatasetCard card = card_of_two();
  write_dataset_card(folder / ".", card);
  const ReadDatasetCard read = read_dataset_card(folder / ".");
  EXPECT_EQ(read.digest, digest_of(card));
  EXPECT_EQ(digest_of(read.card), digest_of(card));
  EXPECT_THAT(splits_of(read.card), ElementsAre("train", "test"));
  EXPECT_EQ(split_text(read.card, "test"), "test: 1 runs, 1.5 s, 0.00 million events, 0.0 MB");
  const std::string page = bytes_of(folder / "card.md");
  EXPECT_THAT(page, HasSubstr("|licence|not stated|"));
  EXPECT_THAT(page, HasSubstr("|train|1|1.5|1000|0.0|128x96|7|0.750|0.00 %|`emulator.preset`: ideal (1)|"));
}

TEST(DatasetCard, ItsDigestChangesWithEveryFileAndNotWithTheProgram) {
  const std::string before = digest_of(card_of_two());
  DatasetCard other = card_of_two();
  other.program = "saccade 2";
  other.runs[0].folder = "train/runs/1";
  EXPECT_EQ(digest_of(other), before);
  other.runs[1].files[0].digest = "0124";
  EXPECT_NE(digest_of(other), before);
}

TEST(DatasetCard, AFolderWithoutOneIsRefused) {
  const TempFolder folder;
  const auto message = [&] { return lines_of([&] { static_cast<void>(read_dataset_card(folder / ".")); }); };
  EXPECT_THAT(message(), ElementsAre(HasSubstr("found no card.json, expected the folder of a data set")));
  folder.write("plan.json", "{}");
  EXPECT_THAT(message(), ElementsAre(HasSubstr("found a data set without all of its runs")));
  folder.write("card.json", "{\"schema\": 2}");
  EXPECT_THAT(message(), ElementsAre(HasSubstr("card.json: found schema 2, expected 1")));
  folder.write("card.json", "[");
  EXPECT_THAT(message(), ElementsAre(HasSubstr("expected the card of a data set, as saccade wrote it")));
}

}  // namespace
}  // namespace saccade
