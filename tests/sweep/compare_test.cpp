#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "apps/sweep/run_comparison.h"
#include "core/error.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

MeanSd sample(const std::vector<std::optional<double>>& values) { return mean_sd_of(values); }

/// Against R: t.test(a, b)$p.value; for two values each, and for unequal counts and spreads.
TEST(WelchTest, GivesTheTabulatedPValues) {
  // t = 2 with 2 degrees of freedom: P(|t| > 2) = 1 - 2 / sqrt(6).
  const auto two =
      welch_p_value(sample({0.0, 2.0}), sample({2.0 * std::sqrt(2.0), 2.0 + 2.0 * std::sqrt(2.0)}));
  EXPECT_NEAR(two.value(), 1.0 - 2.0 / std::sqrt(6.0), 1e-12);
  // Equal spreads and 3 values each: t = 4.604 is the 99 % quantile of 4 degrees of freedom (tables of Student's t).
  const double shift = 4.604095 * std::sqrt(2.0 / 3.0);
  const auto six = welch_p_value(sample({-1.0, 0.0, 1.0}), sample({shift - 1.0, shift, shift + 1.0}));
  EXPECT_NEAR(six.value(), 0.01, 1e-6);
  // Many values: the normal distribution, 1.96 standard errors.
  std::vector<std::optional<double>> a;
  std::vector<std::optional<double>> b;
  for (int i = 0; i < 100000; ++i) {
    a.push_back(i % 2 == 0 ? -1.0 : 1.0);
    b.push_back(*a.back() + 1.959964 * std::sqrt(2.0 / 100000.0));
  }
  EXPECT_NEAR(welch_p_value(sample(a), sample(b)).value(), 0.05, 1e-4);
}

TEST(WelchTest, IsUndefinedForOneValueAndCertainWithoutSpread) {
  EXPECT_EQ(welch_p_value(sample({1.0}), sample({1.0, 2.0})), std::nullopt);
  EXPECT_EQ(welch_p_value(sample({3.0, 3.0}), sample({3.0, 3.0})), 1.0);
  EXPECT_EQ(welch_p_value(sample({3.0, 3.0}), sample({4.0, 4.0})), 0.0);
}

TEST(PairedTest, GivesTheTabulatedPValues) {
  // Differences 1, 2, 3: t = 2 / (1 / sqrt(3)) = 2 sqrt(3) with 2 degrees of freedom, P = 1 - t / sqrt(t^2 + 2).
  EXPECT_NEAR(paired_p_value(sample({1.0, 2.0, 3.0})).value(), 1.0 - std::sqrt(12.0 / 14.0), 1e-12);
  EXPECT_EQ(paired_p_value(sample({1.0})), std::nullopt);
  EXPECT_EQ(paired_p_value(sample({0.0, 0.0})), 1.0);
  EXPECT_EQ(paired_p_value(sample({0.5, 0.5})), 0.0);
}

class Compare : public testing::Test {
 protected:
  /// A run folder with two figures.
  void run(const std::string& name, int seed, double recall, const std::string& acquire = "0.5",
           const std::string& scenario = "ball", const std::string& commit = "abc") const {
    fs::create_directories(folder_ / name);
    folder_.write(name + "/figures.json",
                  "{\"schema\": 1, \"scenario\": \"" + scenario + "\", \"seed\": " + std::to_string(seed) +
                      ", \"detectors\": {\"best\": {\"recall\": " + std::to_string(recall) +
                      "}}, \"gaze\": {\"acquire_s\": " + acquire + "}}");
    folder_.write(name + "/scenario.yaml", "# saccade 0.1.0 (" + commit + "); gl\nname: " + scenario + "\n");
  }
  /// A run that was killed.
  void unfinished(const std::string& name) const {
    fs::create_directories(folder_ / name);
    folder_.write(name + "/scenario.yaml", "name: ball\n");
    folder_.write(name + "/truth.csv.part", "");
  }
  [[nodiscard]] RunComparison compared(const std::string& a, const std::string& b,
                                       const std::vector<std::string>& tolerances = {},
                                       bool paired = false) const {
    std::vector<Tolerance> all;
    for (const std::string& text : tolerances) all.push_back(tolerance_of(text));
    return compare(read_run_set(folder_ / a), read_run_set(folder_ / b), all, paired);
  }
  static std::vector<std::string> changed(const RunComparison& comparison) {
    std::vector<std::string> names;
    for (const ComparedSet& set : comparison.sets) {
      for (const ComparedFigure& figure : set.figures) {
        if (figure.changed) names.push_back(figure.name);
      }
    }
    return names;
  }

  TempFolder folder_;
};

TEST_F(Compare, OneRunAgainstAnotherIsEqualOnlyWithinTheTolerance) {
  run("a", 1, 0.90);
  run("b", 1, 0.91, "0.5", "ball", "def");
  EXPECT_FALSE(compared("a", "a").different());
  EXPECT_THAT(changed(compared("a", "b")), ElementsAre("detectors.best.recall"));
  EXPECT_TRUE(compared("a", "b", {"detectors.*.recall=0.009"}).different());
  EXPECT_FALSE(compared("a", "b", {"detectors.*.recall=0.011"}).different());
  EXPECT_FALSE(compared("a", "b", {"detectors.*=2%"}).different());
  EXPECT_TRUE(compared("a", "b", {"*=5%", "detectors.best.recall=0"}).different()) << "the last one holds";
  const std::string text = comparison_text(compared("a", "b"));
  EXPECT_THAT(text, HasSubstr("saccade 0.1.0 (abc)"));
  EXPECT_THAT(text, HasSubstr("saccade 0.1.0 (def)"));
  EXPECT_THAT(text, HasSubstr("+0.01"));
  EXPECT_THAT(text, Not(HasSubstr("acquire_s"))) << "it has not changed";
}

TEST_F(Compare, WarnsOfSidesOfDifferentRangesOfMujoco) {
  run("a", 1, 0.90, "0.5", "ball", "abc), MuJoCo 2.2.2 (x");
  run("b", 1, 0.90, "0.5", "ball", "abc), MuJoCo 3.12.0 (x");
  run("c", 1, 0.90, "0.5", "ball", "abc), MuJoCo 2.3.7 (x");
  run("old", 1, 0.90);
  EXPECT_THAT(comparison_text(compared("a", "b")), HasSubstr("\nwarning: runs of MuJoCo 2.2.2 and 3.12.0: "));
  EXPECT_THAT(comparison_json(compared("a", "b")),
              HasSubstr("\"warning\": \"runs of MuJoCo 2.2.2 and 3.12.0: "));
  EXPECT_FALSE(compared("a", "b").different()) << "equal figures stay equal";
  for (const char* const same : {"a", "c", "old"}) {
    EXPECT_THAT(comparison_text(compared("a", same)), Not(HasSubstr("warning"))) << same;
    EXPECT_THAT(comparison_json(compared("a", same)), HasSubstr("\"warning\": \"\"")) << same;
  }
}

TEST_F(Compare, ADifferenceWithinTheSpreadOverSeedsIsNoChangeAndABiggerOneIs) {
  const std::vector<double> recalls = {0.90, 0.92, 0.91, 0.93};
  for (std::size_t i = 0; i < recalls.size(); ++i) {
    const auto seed = static_cast<int>(i) + 1;
    run("a/" + std::to_string(seed), seed, recalls[i]);
    run("near/" + std::to_string(seed), seed, recalls[i] + 0.01);
    run("far/" + std::to_string(seed), seed, recalls[i] + 0.10);
  }
  EXPECT_FALSE(compared("a", "near").different());
  EXPECT_THAT(changed(compared("a", "far")), ElementsAre("detectors.best.recall"));
  EXPECT_FALSE(compared("a", "far", {"detectors.best.recall=0.2"}).different());
  EXPECT_EQ(compared("a", "far").sets.front().seeds_a, (std::vector<std::string>{"1", "2", "3", "4"}));
}

TEST_F(Compare, SeedBySeedADifferenceWithinTheSpreadIsAChange) {
  const std::vector<double> recalls = {0.90, 0.92, 0.91, 0.93};
  for (std::size_t i = 0; i < recalls.size(); ++i) {
    const auto seed = static_cast<int>(i) + 1;
    run("a/" + std::to_string(seed), seed, recalls[i]);
    // In another order, so that equal places are not equal seeds.
    run("b/" + std::to_string(9 - seed), seed, recalls[i] + 0.010 + 0.001 * (seed % 2));
    run("other/" + std::to_string(seed), seed + 1, recalls[i] + 0.01);
  }
  EXPECT_FALSE(compared("a", "b").different());
  EXPECT_THAT(changed(compared("a", "b", {}, true)), ElementsAre("detectors.best.recall"));
  EXPECT_THAT(comparison_text(compared("a", "b", {}, true)), HasSubstr(", paired)"));
  EXPECT_FALSE(compared("a", "other", {}, true).different()) << "not the same seeds";
}

TEST_F(Compare, AFigureThatAppliesOnOneSideAloneHasChanged) {
  run("a", 1, 0.9);
  run("b", 1, 0.9, "null");
  EXPECT_THAT(changed(compared("a", "b", {"*=100"})), ElementsAre("gaze.acquire_s"));
}

TEST_F(Compare, AScenarioThatIsOnOneSideAloneIsADifference) {
  run("a/one", 1, 0.9);
  run("a/two", 1, 0.8, "0.5", "other");
  run("b/one", 1, 0.9);
  EXPECT_TRUE(compared("a", "b").sets.size() == 2 && compared("a", "b").different());
  EXPECT_THAT(comparison_text(compared("a", "b")), HasSubstr("other: only in A"));
  EXPECT_THAT(comparison_json(compared("a", "b")), HasSubstr("\"different\": true"));
}

TEST_F(Compare, ARunWithoutAResultIsADifference) {
  run("a/one", 1, 0.9);
  run("b/one", 1, 0.9);
  EXPECT_FALSE(compared("a", "b").different());
  unfinished("b/two");
  EXPECT_TRUE(compared("a", "b").different());
  EXPECT_THAT(comparison_text(compared("a", "b")), HasSubstr("different: 1 run without a result"));
  EXPECT_TRUE(compared("b", "b").different()) << "nothing is known of either";
  EXPECT_TRUE(compared("a", "b/two").different());
  EXPECT_TRUE(compared("b/two", "b/two").different());
}

TEST_F(Compare, AnInterruptedRunIsNoResult) {
  run("a", 1, 0.9);
  run("b", 1, 0.9);
  const std::string text = bytes_of(folder_ / "b/figures.json");
  folder_.write("b/figures.json", "{\"interrupted\": true, " + text.substr(1));
  EXPECT_TRUE(compared("a", "b").different());
  EXPECT_EQ(compared("a", "b").b.failed, 1u);
}

TEST_F(Compare, RunsThatReadFilesOfOtherContentsAreNotOneGroup) {
  run("a/one", 1, 0.9);
  run("a/two", 1, 0.8);
  for (const char* name : {"one", "two"}) {
    const std::string text = bytes_of(folder_ / ("a/" + std::string(name) + "/figures.json"));
    folder_.write("a/" + std::string(name) + "/figures.json",
                  "{\"files\": [{\"key\": \"detectors.mine.python\", \"file\": \"mine.py\", \"digest\": \"" +
                      std::string(name) + "\"}], " + text.substr(1));
  }
  const RunSet set = read_run_set(folder_ / "a");
  ASSERT_EQ(set.groups.size(), 2u) << "the second is no repeat of the first";
  EXPECT_THAT(set.groups[1].label, HasSubstr("detectors.mine.python.contents=mine.py two"));
}

TEST_F(Compare, AToleranceForNoFigureIsRejected) {
  run("a", 1, 0.9);
  EXPECT_THROW(static_cast<void>(compared("a", "a", {"foo=1"})), InputError);
  EXPECT_THROW(static_cast<void>(compared("a", "a", {"detectors.*.recall=1", "detectors.*.recal=1"})),
               InputError);
  EXPECT_THROW(static_cast<void>(compared("a", "a", {"gaze.acquired_s=1"})), InputError);
  EXPECT_FALSE(compared("a", "a", {"detectors.*.recall=1"}).different());
  EXPECT_FALSE(compared("a", "a", {"latency.*=1"}).different()) << "runs may have no such block";
}

TEST_F(Compare, AFolderWithoutRunsAndABadToleranceAreRejected) {
  fs::create_directories(folder_ / "empty");
  EXPECT_THROW(static_cast<void>(read_run_set(folder_ / "empty")), InputError);
  EXPECT_THROW(static_cast<void>(read_run_set(folder_ / "nowhere")), InputError);
  for (const char* text : {"recall", "=1", "recall=", "recall=-1", "recall=nan", "recall=1%%"})
    EXPECT_THROW(static_cast<void>(tolerance_of(text)), InputError) << text;
}

}  // namespace
}  // namespace saccade
