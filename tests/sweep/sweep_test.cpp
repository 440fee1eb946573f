#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>

#include "apps/sweep/sweep_config.h"
#include "apps/sweep/sweep_folder.h"
#include "apps/sweep/sweep_plan.h"
#include "apps/sweep/sweep_store.h"
#include "core/error.h"
#include "evaluation/scoring/metrics.h"
#include "recording/file_lock.h"
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

class Sweep : public testing::Test {
 protected:
  SweepConfig read(const std::string& yaml, const std::vector<std::string>& sets = {}) {
    return read_sweep(folder_.write("sweep.yaml", head + yaml), sets);
  }
  SweepPlan plan(const std::string& yaml, const std::vector<std::string>& sets = {}) {
    return plan_sweep(read(yaml, sets), "version 1", built_in());
  }
  std::vector<std::string> complaints(const std::string& yaml, const std::vector<std::string>& sets = {}) {
    std::vector<std::string> lines;
    try {
      static_cast<void>(plan(yaml, sets));
    } catch (const InputError& error) {
      for (const Problem& problem : error.problems()) lines.push_back(problem.text());
    }
    return lines;
  }
  static std::vector<std::string> texts(const SweepPlan& plan, std::size_t axis) {
    std::vector<std::string> values;
    for (const PlannedRun& run : plan.runs)
      values.push_back(plan.config.axes[axis].values[run.values[axis]].text);
    return values;
  }

  TempFolder folder_;
};

TEST_F(Sweep, AxesAreCrossedTheFirstTurningSlowest) {
  const SweepPlan p = plan("axes:\n  lab.clutter: [textured, rectilinear]\n  seed: {seeds: 2, first: 7}\n");
  EXPECT_THAT(texts(p, 0), ElementsAre("textured", "textured", "rectilinear", "rectilinear"));
  EXPECT_THAT(texts(p, 1), ElementsAre("7", "8", "7", "8"));
  EXPECT_EQ(p.runs[1].seed, 8);
  EXPECT_THAT(p.runs[2].scenario, HasSubstr("clutter: rectilinear"));
}

TEST_F(Sweep, ARunHasAnotherIdOnceAFileThatItReadsHasOtherContents) {
  const std::string csv = "t_s,x_m,y_m,z_m\n0,-0.5,0,0.3\n2,-0.5,0.1,0.3\n";
  folder_.write("motion.csv", csv);
  const std::string yaml = "set:\n  ball.trajectory: {kind: csv, file: " + (folder_ / "motion.csv").string() +
                           "}\naxes:\n  seed: [1]\n";
  const PlannedRun first = plan(yaml).runs.front();
  EXPECT_EQ(plan(yaml).runs.front().id, first.id);
  folder_.write("motion.csv", csv + "3,-0.5,0.2,0.3\n");
  EXPECT_NE(plan(yaml).runs.front().id, first.id);
  const auto files = [&](const std::string& path) {
    return std::vector<FileDigest>{{"ball.trajectory.file", path, digest_of_file(path), false}};
  };
  const std::string motion = (folder_ / "motion.csv").string();
  EXPECT_THAT(changed_files(files(motion), first.scenario), ElementsAre(motion));
  folder_.write("motion.csv", csv);
  EXPECT_EQ(plan(yaml).runs.front().id, first.id);
  EXPECT_THAT(changed_files(files(motion), first.scenario), testing::IsEmpty());
}

TEST_F(Sweep, TheScenarioMayBeOneThatSaccadeShips) {
  const fs::path file = folder_.write("sweep.yaml", "name: s\nscenario: hand_move\naxes: {seed: [1]}\n");
  EXPECT_EQ(read_sweep(file, {}).scenario.filename(), "hand_move.yaml");
  folder_.write("hand_move", "name: own\n");
  EXPECT_EQ(read_sweep(file, {}).scenario, folder_ / "hand_move") << "a file beside the sweep comes first";
}

TEST_F(Sweep, NullForAKeyThatDoesNotExistIsAMistake) {
  EXPECT_THAT(complaints("set: {frame_30hz: null}\naxes:\n  seed: [1]\n"), testing::IsEmpty());
  EXPECT_THAT(complaints("set: {frame_30z: null}\naxes:\n  seed: [1]\n"),
              Contains(HasSubstr("did you mean frame_30hz?")));
}

TEST_F(Sweep, AnInterruptedRunIsNoResult) {
  const SweepFolder sweep(folder_ / "sweep");
  fs::create_directories(sweep.run("a"));
  Metrics metrics;
  metrics.scenario = "s";
  write_metrics(sweep.run("a") / "metrics.json", metrics);
  EXPECT_TRUE(sweep.has_result("a"));
  metrics.interrupted = true;
  write_metrics(sweep.run("a") / "metrics.json", metrics);
  EXPECT_FALSE(sweep.has_result("a"));
}

TEST_F(Sweep, RangesIncludeTheirEndsAndLogRangesAreEvenInTheLogarithm) {
  const SweepPlan p = plan(
      "axes:\n  ball.diameter_m: {range: [0.05, 0.1], steps: 3}\n"
      "  detectors.paper_full.window.events: {log_range: [100, 1600], steps: 5, whole: true}\n");
  const std::vector<std::string> diameters = texts(p, 0);
  EXPECT_THAT(std::set<std::string>(diameters.begin(), diameters.end()), ElementsAre("0.05", "0.075", "0.1"));
  const std::vector<std::string> windows = texts(p, 1);
  EXPECT_THAT(std::vector<std::string>(windows.begin(), windows.begin() + 5),
              ElementsAre("100", "200", "400", "800", "1600"));
}

TEST_F(Sweep, ALatinHypercubeHasOnePointInEachStretchOfEachAxisAndIsDrawnAlikeEachTime) {
  const std::string yaml =
      "samples: 20\naxes:\n  ball.diameter_m: {latin_hypercube: [0.05, 0.15]}\n"
      "  run.duration_s: {latin_hypercube: [0.1, 10], log: true}\n"
      "  lab.density: {random: [0, 2]}\n";
  const SweepPlan p = plan(yaml);
  ASSERT_THAT(p.runs, SizeIs(20)) << "sampled axes go together";
  std::set<int> stretches;
  std::set<int> log_stretches;
  std::set<std::string> pairs;
  for (std::size_t i = 0; i < p.runs.size(); ++i) {
    stretches.insert(static_cast<int>((*number_in(texts(p, 0)[i]) - 0.05) / 0.1 * 20.0));
    log_stretches.insert(static_cast<int>(std::log10(*number_in(texts(p, 1)[i]) / 0.1) / 2.0 * 20.0));
    const double density = *number_in(texts(p, 2)[i]);
    EXPECT_TRUE(density >= 0.0 && density <= 2.0) << density;
  }
  EXPECT_THAT(stretches, SizeIs(20));
  EXPECT_THAT(log_stretches, SizeIs(20));
  EXPECT_EQ(texts(plan(yaml), 0), texts(p, 0));
  EXPECT_NE(texts(plan(yaml + "sample_seed: 2\n"), 0), texts(p, 0));
}

TEST_F(Sweep, CasesSetSeveralKeysUnderOneName) {
  const SweepPlan p = plan(
      "axes:\n  size:\n    cases:\n      small: {ball.diameter_m: 0.06, lab.density: 0}\n"
      "      0.10: {ball.diameter_m: 0.1}\n");
  EXPECT_THAT(texts(p, 0), ElementsAre("small", "0.10"));
  EXPECT_THAT(p.runs[0].scenario, HasSubstr("diameter_m: 0.06"));
  EXPECT_THAT(p.runs[0].scenario, HasSubstr("density: 0"));
  EXPECT_THAT(p.runs[1].scenario, HasSubstr("density: 1"));
  EXPECT_THAT(plan("set: {expect: null, gaze: null}\naxes:\n  lab.density: [1]\n").runs, SizeIs(1))
      << "null takes a key out";
}

TEST_F(Sweep, RulesLeaveCombinationsOut) {
  const std::string axes = "axes:\n  lab.density: [0, 0.5, 1]\n  lab.contrast: [0, 0.5, 1]\n";
  EXPECT_THAT(plan(axes).runs, SizeIs(9));
  EXPECT_THAT(plan(axes + "except: [{lab.density: 0, lab.contrast: {above: 0.4}}]\n").runs, SizeIs(7));
  EXPECT_THAT(plan(axes + "except: [{lab.density: [0, 1]}]\n").runs, SizeIs(3));
  EXPECT_THAT(plan(axes + "except: [{lab.density: 0}, {lab.contrast: {at_least: 1}}]\n").runs, SizeIs(4));
  EXPECT_THAT(plan(axes + "only: [{lab.density: {below: lab.contrast}}]\n").runs, SizeIs(3))
      << "axis by axis";
  EXPECT_THAT(plan(axes + "only: [{lab.density: {not: 1}}]\nexcept: [{lab.contrast: {at_most: 0}}]\n").runs,
              SizeIs(4));
  EXPECT_THAT(complaints(axes + "except: [{lab.density: {at_least: 0}}]\n"),
              ElementsAre(HasSubstr("no combination left")));
  EXPECT_THAT(complaints(axes + "except: [{lab.clutter: textured}]\n"),
              ElementsAre(HasSubstr("sweep.yaml:6: except[0].lab.clutter: found no such axis")));
  EXPECT_THAT(complaints(axes + "except: [{lab.density: {over: 1}}]\n"),
              ElementsAre(HasSubstr("one of not")));
}

TEST_F(Sweep, WhatIsWrongIsReportedAtOnceWithItsLineBeforeAnythingStarts) {
  EXPECT_THAT(complaints("axes:\n  lab.cluter: [textured]\n"),
              ElementsAre(HasSubstr("sweep.yaml:4: axes.lab.cluter: found an unknown key")));
  EXPECT_THAT(complaints("axes:\n  lab.clutter: []\n"), ElementsAre(HasSubstr("an empty list")));
  EXPECT_THAT(complaints("axes: {}\n"), ElementsAre(HasSubstr("no axis")));
  EXPECT_THAT(complaints("axes:\n  lab.density: [1]\n  lab.density: [2]\n"),
              ElementsAre(HasSubstr("sweep.yaml:5: axes.lab.density: found the key a second time")));
  EXPECT_THAT(complaints("axes:\n  lab.density: [1]\n  room: {cases: {a: {lab.density: 0}}}\n"),
              ElementsAre(HasSubstr("which the axis lab.density sets too")));
  EXPECT_THAT(complaints("set: {lab.density: 2}\naxes:\n  lab.density: [1]\n"),
              ElementsAre(HasSubstr("sweep.yaml:3: set.lab.density: found a key that the axis")));
  EXPECT_THAT(complaints("axes:\n  lab.density: [1]\n", {"lab.density=2"}),
              ElementsAre(HasSubstr("--set lab.density: found a key that the axis")));
  EXPECT_THAT(
      complaints("axes:\n  lab.density: [0, 1, 3]\n  lab.contrast: [1, 9]\n"),
      ElementsAre(HasSubstr("sweep.yaml:5: axes.lab.contrast: found 9"),
                  HasSubstr("sweep.yaml:4: axes.lab.density: found 3, expected a finite number in [0, 2]")));
  EXPECT_THAT(complaints("axes:\n  lab.density: {range: [1, 0], steps: 3}\n"),
              ElementsAre(HasSubstr("smaller")));
  EXPECT_THAT(complaints("axes:\n  lab.density: {range: [0, 1]}\n"), ElementsAre(HasSubstr("steps")));
  EXPECT_THAT(complaints("axes:\n  lab.density: {random: [0, 1]}\n"), ElementsAre(HasSubstr("samples")));
  EXPECT_THAT(complaints("axes:\n  lab.density: 3\n"), ElementsAre(HasSubstr("a list of values")));
  EXPECT_THAT(complaints("axes:\n  lab.density: [1, 1]\n"), ElementsAre(HasSubstr("1 twice")));
  EXPECT_THAT(complaints("axes:\n  lab.density: [1]\nreport: {metrics: [gaze.luck]}\n"),
              ElementsAre(HasSubstr("sweep.yaml:5: report.metrics[0]: found gaze.luck")));
  EXPECT_THAT(complaints("axis:\n  lab.density: [1]\n"), SizeIs(2)) << "an unknown key, and no axes";
  EXPECT_THAT(complaints("axes:\n  lab.density: {range: [0, 1], steps: 1000}\n  lab.contrast: {range: [0, "
                         "1], steps: 1000}\n"),
              ElementsAre(HasSubstr("1000000 combinations")));
}

TEST_F(Sweep, ARunIsKnownByItsContent) {
  const SweepPlan p =
      plan("axes:\n  size: {cases: {a: {}, b: {ball.diameter_m: 0.095}, c: {ball.diameter_m: 0.1}}}\n");
  ASSERT_THAT(p.runs, SizeIs(3));
  EXPECT_NE(p.runs[0].id, p.runs[2].id);
  EXPECT_NE(plan_sweep(p.config, "version 2", built_in()).runs[0].id, p.runs[0].id);
  EXPECT_EQ(plan("axes:\n  seed: [1]\n").runs[0].id, plan("axes:\n  lab.clutter: [textured]\n").runs[0].id)
      << "said or not, the same scenario";
}

/// Results as a run leaves them.
std::string metrics_json(double precision) {
  Metrics metrics;
  metrics.scenario = "s";
  metrics.seed = 1;
  metrics.duration_s = 1.0;
  metrics.wall_s = precision * 3.0;
  DetectorScore score;
  score.average_precision = precision;
  score.pr_curve = {{.threshold = 0.5, .precision = precision, .recall = 0.4}};
  metrics.detectors.emplace_back("paper_full", score);
  return metrics_to_json(metrics);
}

TEST_F(Sweep, TheTableIsTheSameInWhateverOrderTheResultsCome) {
  const SweepPlan p = plan("axes:\n  lab.density: [0, 1, 2]\n  lab.clutter: [textured, rectilinear]\n");
  const auto finish = [&](const SweepFolder& sweep, std::size_t i) {
    fs::create_directories(sweep.run(p.runs[i].id));
    const std::string file = i == 3 ? "failure.txt" : "metrics.json";
    const std::string text = i == 3 ? "no, not this one\n" : metrics_json(0.1 * static_cast<double>(i));
    std::FILE* out = std::fopen((sweep.run(p.runs[i].id) / file).c_str(), "wb");
    std::fputs(text.c_str(), out);
    std::fclose(out);
  };
  const auto table = [&](const char* name, const std::vector<std::size_t>& order, std::size_t before) {
    const SweepFolder sweep(folder_ / name);
    fs::create_directories(sweep.path());
    for (std::size_t i = 0; i < before; ++i) finish(sweep, order[i]);
    SweepStore::create(sweep, p);
    SweepStore store(sweep);
    for (std::size_t i = before; i < order.size(); ++i) {
      finish(sweep, order[i]);
      store.add({p.runs[order[i]].id});
    }
    return store.csv(false);
  };
  const std::string one = table("one", {0, 1, 2, 3, 4, 5}, 0);
  EXPECT_EQ(table("two", {5, 3, 1, 0, 2, 4}, 3), one) << "begun again half-way";
  EXPECT_THAT(one, HasSubstr("4,"));
  EXPECT_THAT(one, HasSubstr("failed,\"no, not this one\",1,rectilinear"));
  EXPECT_THAT(one, HasSubstr("detectors.paper_full.average_precision"));
  EXPECT_EQ(one.find("wall_s"), std::string::npos);
  const SweepStore store(SweepFolder(folder_ / "one"));
  EXPECT_THAT(store.csv(true), HasSubstr("wall_s"));
  EXPECT_EQ(store.count("done"), 5);
  const SweepTable shown = store.table();
  ASSERT_THAT(shown.rows, SizeIs(6));
  ASSERT_THAT(shown.metrics, Contains("detectors.paper_full.average_precision"));
  const auto metric = static_cast<std::size_t>(
      std::find(shown.metrics.begin(), shown.metrics.end(), "detectors.paper_full.average_precision") -
      shown.metrics.begin());
  EXPECT_DOUBLE_EQ(shown.rows[2].metrics.at(metric).value(), 0.2);
  EXPECT_EQ(shown.rows[3].metrics.at(metric), std::nullopt);
  EXPECT_EQ(shown.rows[2].curves.at(0).second.at(0).recall, 0.4);
}

TEST_F(Sweep, ALockIsHeldByOneAndEndsWithIt) {
  const fs::path path = folder_ / "lock";
  EXPECT_FALSE(is_locked(path));
  {
    const FileLock first(path);
    EXPECT_TRUE(first.held());
    EXPECT_TRUE(is_locked(path));
    EXPECT_FALSE(FileLock(path).held());
  }
  EXPECT_FALSE(is_locked(path));
  EXPECT_TRUE(FileLock(path).held());
}

}  // namespace
}  // namespace saccade
