#include "evaluation/report/comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include "core/error.h"
#include "evaluation/report/mujoco_ranges.h"
#include "evaluation/report/resolved_scenario.h"
#include "evaluation/scoring/statistics.h"
#include "recording/format_registry.h"
#include "tests/evaluation/report/svg_check.h"
#include "tests/evaluation/report/synthetic_run.h"
#include "tests/evaluation/report/text_of.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

TEST(MeanSd, IsThatOfTheValuesThereAre) {
  const MeanSd some = mean_sd_of(std::vector<std::optional<double>>{1.0, std::nullopt, 2.0, 6.0});
  EXPECT_EQ(some.count, 3U);
  EXPECT_NEAR(*some.mean, 3.0, 1e-12);
  EXPECT_NEAR(*some.sd, std::sqrt(7.0), 1e-12);  // (4 + 1 + 9) / 2
  const MeanSd one = mean_sd_of(std::vector<std::optional<double>>{std::nullopt, 2.0});
  EXPECT_EQ(one.mean, 2.0);
  EXPECT_EQ(one.sd, std::nullopt);
  EXPECT_EQ(mean_sd_of({}).mean, std::nullopt);
}

std::vector<std::string> write_comparison(std::span<const fs::path> runs, const fs::path& out) {
  return saccade::write_comparison(runs, out, built_in_formats());
}

/// Two seeds of one scenario, the second with another detector instead of paper_full, and a run with a
/// setting of its own.
class Comparison : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) / (std::string("saccade_comparison_") +
                                            testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::remove_all(root_);
    fs::create_directories(root_);
    for (int i = 1; i <= 3; ++i) {
      folders_.push_back(root_ / ("run " + std::to_string(i)));
      metrics_.push_back(write_synthetic_run(folders_.back(), false, i, 1500));
      std::ofstream(folders_.back() / "report.html") << "here already";
    }
    metrics_[1].detectors[0].first = "newcomer";
    metrics_[2].settings = {{"lab.clutter", "<rectilinear>"}};
    for (std::size_t i = 0; i < 3; ++i) write_metrics(folders_[i] / "metrics.json", metrics_[i]);
  }
  void TearDown() override { fs::remove_all(root_); }

  [[nodiscard]] std::string page() const {
    write_comparison(folders_, root_ / "out");
    return contents(root_ / "out/report.html");
  }

  fs::path root_;
  std::vector<fs::path> folders_;
  std::vector<Metrics> metrics_;
};

TEST_F(Comparison, PutsSeedsOfTheSameScenarioAndSettingsTogether) {
  const std::string html = page();
  EXPECT_EQ(count(html, "<h2>"), 2U);
  EXPECT_THAT(html, HasSubstr("<h2>synthetic square &lt;45 cm&gt;</h2>"));
  EXPECT_THAT(html, HasSubstr("<h2>synthetic square &lt;45 cm&gt; · lab.clutter=&lt;rectilinear&gt;</h2>"));
  const std::string group = html.substr(html.find("<table id=\"group1\">"));
  const std::string body = group.substr(0, group.find("</table>"));
  EXPECT_EQ(count(body, "<tr><th>"), 1U + 3U);  // head, paper_full, paper_directed, newcomer
  EXPECT_EQ(count(body, "1 runs"), 2U) << "detectors that were in one of the two runs only";
}

TEST_F(Comparison, ShowsMeanAndStandardDeviationOverTheSeeds) {
  const std::string html = page();
  const double a = *metrics_[0].detectors[1].second.average_precision;
  const double b = *metrics_[1].detectors[1].second.average_precision;
  ASSERT_NE(a, b);
  const std::string row =
      html.substr(html.find("paper_directed</span></th>", html.find("<table id=\"group1\">")));
  const auto number = [&](const std::string& key) {
    return std::stod(row.substr(row.find(key + "=\"") + key.size() + 2));
  };
  EXPECT_NEAR(number("data-value"), 0.5 * (a + b), 1e-12);
  EXPECT_NEAR(number("data-sd"), std::abs(a - b) / std::sqrt(2.0), 1e-12);
}

/// A resolved scenario as a run folder has it.
void write_scenario(const fs::path& folder, int seed, const std::string& speed,
                    const std::string& version = "1") {
  std::ofstream(folder / "scenario.yaml")
      << "# saccade " << version << " (abc); llvmpipe " << seed << "\nname: square\nseed: " << seed
      << "\nball:\n  trajectory:\n    speed_m_s: " << speed
      << "\n    points_m:\n      - [0, 1, 2]\n      - [3, 4, 5]\n"
      << "output:\n  video: " << (seed == 1 ? "true" : "false") << "\n";
}

TEST_F(Comparison, PutsEditedCopiesOfAScenarioIntoGroupsOfTheirOwnAndNamesWhatDiffers) {
  metrics_[2].settings.clear();
  write_metrics(folders_[2] / "metrics.json", metrics_[2]);
  write_scenario(folders_[0], 1, "0.1");
  write_scenario(folders_[1], 2, "0.1");
  write_scenario(folders_[2], 3, "0.4");
  const std::string html = page();
  EXPECT_EQ(count(html, "<h2>synthetic"), 2U);
  EXPECT_THAT(html, HasSubstr("<h2>synthetic square &lt;45 cm&gt;</h2>\n<p class=\"facts\">2 runs"));
  EXPECT_THAT(html, HasSubstr("ball.trajectory.speed_m_s=0.4</h2>\n<p class=\"facts\">1 run"));
}

TEST_F(Comparison, PutsRunsOfDifferentVersionsIntoGroupsOfTheirOwn) {
  metrics_[2].settings.clear();
  write_metrics(folders_[2] / "metrics.json", metrics_[2]);
  for (std::size_t i = 0; i < 3; ++i)
    write_scenario(folders_[i], static_cast<int>(i) + 1, "0.1", i == 2 ? "2" : "1");
  const std::string html = page();
  EXPECT_EQ(count(html, "<h2>synthetic"), 2U);
  EXPECT_THAT(html, HasSubstr("version=saccade 2 (abc)</h2>"));
}

TEST(MujocoRange, IsOfTheVersionThatATextNames) {
  EXPECT_EQ(mujoco_range("saccade 0.1.0 (9b6774e), MuJoCo 2.2.2"), "2.2 to 2.3");
  EXPECT_EQ(mujoco_range("saccade 0.1.0 (9b6774e), MuJoCo 3.5.0, served"), mujoco_range("MuJoCo 3.0.0"));
  EXPECT_EQ(mujoco_range("MuJoCo 3.12.0"), "3.0 and newer");
  EXPECT_EQ(mujoco_range("MuJoCo 4.0.0"), "3.0 and newer");
  EXPECT_NE(mujoco_range("MuJoCo 2.3.7"), mujoco_range("MuJoCo 3.0.0"));
  for (const char* const text : {"", "saccade 0.1.0 (9b6774e)", "MuJoCo ", "MuJoCo 3", "MuJoCo x.5"})
    EXPECT_EQ(mujoco_range(text), "") << text;
}

TEST_F(Comparison, WarnsOfRunsOfDifferentRangesOfMujoco) {
  const auto simulate_with = [&](std::size_t i, const std::string& version) {
    std::ofstream(folders_[i] / "scenario.yaml")
        << "# saccade 0.1.0 (abc), MuJoCo " << version << "; llvmpipe\nname: square\nseed: " << i << "\n";
  };
  for (std::size_t i = 0; i < 3; ++i) simulate_with(i, "3.5.0");
  EXPECT_THAT(write_comparison(folders_, root_ / "out"), testing::IsEmpty());
  EXPECT_THAT(contents(root_ / "out/report.html"), Not(HasSubstr("MuJoCo 2")));
  simulate_with(1, "2.2.2");
  const std::vector<std::string> remarks = write_comparison(folders_, root_ / "out");
  ASSERT_EQ(remarks.size(), 1U);
  EXPECT_THAT(remarks[0], HasSubstr("warning: runs of MuJoCo 2.2.2 and 3.5.0"));
  EXPECT_THAT(contents(root_ / "out/report.html"), HasSubstr("Warning: runs of MuJoCo 2.2.2 and 3.5.0"));
}

TEST_F(Comparison, CountsARunThatRepeatsASeedOnceAndNamesIt) {
  metrics_[1].seed = 1;
  metrics_[1].detectors[0].first = "paper_full";
  write_metrics(folders_[1] / "metrics.json", metrics_[1]);
  for (std::size_t i = 0; i < 2; ++i) write_scenario(folders_[i], 1, "0.1");
  folders_.pop_back();
  const std::vector<std::string> duplicates = write_comparison(folders_, root_ / "out");
  ASSERT_EQ(duplicates.size(), 1U);
  EXPECT_THAT(duplicates[0], HasSubstr("run 2 repeats "));
  EXPECT_THAT(duplicates[0], HasSubstr("run 1 (seed 1) and is not counted"));
  const std::string html = contents(root_ / "out/report.html");
  EXPECT_THAT(html, HasSubstr("run 2 repeats "));
  EXPECT_THAT(html, HasSubstr("<p class=\"facts\">1 run"));
  EXPECT_THAT(contents(root_ / "out/figures/means.csv"), HasSubstr(",paper_directed,1,"));
}

TEST_F(Comparison, ARunThatReadAFileOfOtherContentsIsNoRepeat) {
  metrics_[1].seed = 1;
  metrics_[1].detectors[0].first = "paper_full";
  for (std::size_t i = 0; i < 2; ++i) {
    metrics_[i].files = {{"ball.trajectory.file", "/a/motion.csv", "digest " + std::to_string(i), false}};
    write_metrics(folders_[i] / "metrics.json", metrics_[i]);
    write_scenario(folders_[i], 1, "0.1");
  }
  folders_.pop_back();
  EXPECT_TRUE(write_comparison(folders_, root_ / "out").empty());
  EXPECT_THAT(contents(root_ / "out/report.html"),
              HasSubstr("ball.trajectory.file.contents=motion.csv digest 1"));
}

TEST_F(Comparison, AnInterruptedRunIsMarkedAndDoesNotCountBesideWholeOnes) {
  metrics_[0].interrupted = true;
  for (std::size_t i = 0; i < 2; ++i) {
    metrics_[i].seed = 1;
    metrics_[i].detectors[0].first = "paper_full";
    write_metrics(folders_[i] / "metrics.json", metrics_[i]);
    write_scenario(folders_[i], 1, "0.1");
  }
  folders_.pop_back();
  const std::vector<std::string> not_counted = write_comparison(folders_, root_ / "out");
  ASSERT_EQ(not_counted.size(), 1U);
  EXPECT_THAT(not_counted[0], HasSubstr("run 1 was interrupted after "));
  EXPECT_THAT(contents(root_ / "out/figures/means.csv"), HasSubstr(",paper_directed,1,"));
  EXPECT_EQ(contents(root_ / "out/figures/runs.csv").find(",true\n"), std::string::npos);

  folders_.pop_back();
  static_cast<void>(write_comparison(folders_, root_ / "alone"));
  EXPECT_THAT(contents(root_ / "alone/figures/runs.csv"), HasSubstr(",true\n"));
  EXPECT_THAT(contents(root_ / "alone/report.html"), HasSubstr("(interrupted)"));
}

TEST(ResolvedKeys, HoldEveryLineUnderItsPathButTheSeedAndWhatChangesNoScore) {
  const ResolvedKeys keys = resolved_keys(
      "# saccade 0.1.0 (abc); llvmpipe\nseed: 7\ndescription: \"a: b\"\nrun:\n  duration_s: 2\n  threads: "
      "4\nball:\n"
      "  points_m:\n    - [1, 2]\n    - [3, 4]\n  kind: still\nobjects: {}\noutput:\n  video: true\n");
  const ResolvedKeys expected = {{"version", "saccade 0.1.0 (abc)"},
                                 {"run.duration_s", "2"},
                                 {"ball.points_m", "- [1, 2] - [3, 4]"},
                                 {"ball.kind", "still"},
                                 {"objects", "{}"}};
  EXPECT_EQ(keys, expected);
}

TEST(ResolvedKeys, DifferencesAreShortened) {
  const ResolvedKeys a = {{"a", "1"}, {"b", "1"}};
  EXPECT_EQ(difference_text(a, {{"a", "2"}, {"b", "1"}}), "a=2");
  EXPECT_EQ(difference_text(a, {{"b", "1"}}), "without a");
  EXPECT_EQ(difference_text({}, {{"a", "1"}, {"b", "1"}, {"c", "1"}, {"d", "1"}}), "a=1, b=1, c=1, ...");
}

TEST_F(Comparison, WritesTheTablesAsNumbers) {
  static_cast<void>(page());
  const std::string runs = contents(root_ / "out/figures/runs.csv");
  EXPECT_TRUE(runs.starts_with("run,scenario,settings,seed,detector,average_precision,")) << runs;
  EXPECT_EQ(count(runs, "\n"), 1U + 6U);
  EXPECT_THAT(runs, HasSubstr("run 3,synthetic square <45 cm>,lab.clutter=<rectilinear>,3,paper_directed,"));
  const std::string means = contents(root_ / "out/figures/means.csv");
  EXPECT_TRUE(means.starts_with("scenario,settings,detector,runs,average_precision,average_precision_sd,"));
  EXPECT_EQ(count(means, "\n"), 1U + 5U);
  const std::size_t columns = count(means.substr(0, means.find('\n')), ",");
  EXPECT_EQ(count(means, ","), columns * 6U);
  EXPECT_EQ(count(contents(root_ / "out/figures/gaze_means.csv"), "\n"), 1U + 2U);
}

TEST_F(Comparison, DrawsTheGazeOfOneRunOfEachGroup) {
  const std::string html = page();
  EXPECT_EQ(count(html, "<h3>Gaze in the robot's frame"), 1U);
  const std::string csv = contents(root_ / "out/figures/gaze_paths.csv");
  EXPECT_TRUE(csv.starts_with("series,run,time [s],x [m],y [m],z [m]\n"));
  EXPECT_EQ(count(csv, "ball,\"synthetic square <45 cm>, seed 1\","), 1500U);
  EXPECT_EQ(count(csv, "seed 2"), 0U) << "of a group the first run";
  EXPECT_GT(count(csv, "lab.clutter=<rectilinear>, seed 3"), 3000U);
}

TEST_F(Comparison, ComparesCombinationsOfControllerWindowAndGateAndMarksTheBest) {
  EXPECT_EQ(count(page(), "id=\"ablation\""), 0U) << "of one combination there is nothing to compare";
  EXPECT_FALSE(fs::exists(root_ / "out/figures/ablation.csv"));

  // Two seeds with one gate, one with another; a setting that makes no combination would set it apart.
  metrics_[2].settings = {{"gaze.gate", "none"}, {"detectors.paper_directed.window.events", "700"}};
  metrics_[2].gaze->gate = "none";
  metrics_[2].gaze->window = "700 <events>";
  for (std::size_t i = 0; i < 3; ++i) {
    GazeMetrics& gaze = *metrics_[i].gaze;
    gaze.score.fixation_error_deg.median = 1.0 + static_cast<double>(i);  // 1.5 against 3
    gaze.following_rate_hz = 100.0 * static_cast<double>(i);              // 50 against 200
    gaze.score.saccades = 3;
    gaze.score.wrong_moves = 0;
    write_metrics(folders_[i] / "metrics.json", metrics_[i]);
  }
  const std::string html = page();
  const std::string section = html.substr(html.find("<h2 id=\"ablation\">"));
  const std::string table = section.substr(0, section.find("</table>"));
  EXPECT_THAT(html, HasSubstr("href=\"#ablation\""));
  EXPECT_EQ(count(table, "<tr>"), 3U);
  EXPECT_THAT(table, HasSubstr("<th>qp</th><th>paper_directed</th><th>1500 events</th><th>authors</th><td "
                               "data-value=\"2\">2</td><td class=\"best\" data-value=\"1.5\""));
  EXPECT_THAT(table, HasSubstr("<th>700 &lt;events&gt;</th><th>none</th><td data-value=\"1\">1</td><td "
                               "data-value=\"3\">"));
  EXPECT_THAT(table, HasSubstr("<td class=\"best\" data-value=\"200\""));
  EXPECT_THAT(table, Not(HasSubstr("class=\"best\" data-value=\"0\""))) << "as many wrong moves everywhere";
  EXPECT_THAT(table,
              HasSubstr("<td data-value=\"2\" data-sd=\"0\">2 <small>± 0</small></td>"));  // saccades per s
  const std::string csv = contents(root_ / "out/figures/ablation.csv");
  EXPECT_THAT(csv, HasSubstr("\nsynthetic square <45 cm>,,qp,paper_directed,1500 events,authors,2,1.5,"));
  EXPECT_EQ(count(csv, "\n"), 3U);

  metrics_[2].settings.emplace_back("lab.clutter", "textured");
  write_metrics(folders_[2] / "metrics.json", metrics_[2]);
  EXPECT_EQ(count(page(), "id=\"ablation\""), 0U);
}

TEST_F(Comparison, LinksToEveryRunsOwnReportAndWritesTheMissingOnes) {
  fs::remove(folders_[1] / "report.html");
  const std::string html = page();
  EXPECT_THAT(html, HasSubstr("<a href=\"../run%201/report.html\">seed 1</a>"));
  EXPECT_THAT(html, HasSubstr("<a href=\"../run%203/report.html\">seed 3</a>"));
  EXPECT_EQ(contents(folders_[0] / "report.html"), "here already");
  EXPECT_GT(contents(folders_[1] / "report.html").size(), 10'000U);
}

TEST_F(Comparison, IsSelfContainedWithWellFormedFiguresAndUniqueIds) {
  const std::string html = page();
  for (const char* outside :
       {"http:", "https:", "<script src", "<link", "<iframe", "@import", "src=\"figures"}) {
    EXPECT_THAT(without_scripts(html), Not(HasSubstr(outside)));
  }
  std::size_t figures = 0;
  std::vector<std::string> ids;
  for (std::size_t at = 0; (at = html.find("<svg", at)) != std::string::npos; ++at, ++figures) {
    const std::string svg = html.substr(at, html.find("</svg>", at) + 6 - at);
    EXPECT_EQ(nesting_problem(svg), "");
    for (std::size_t id = 0; (id = svg.find(" id=", id)) != std::string::npos; ++id) {
      ids.push_back(svg.substr(id + 5, svg.find(svg[id + 4], id + 5) - id - 5));
    }
  }
  EXPECT_EQ(figures, 2U + 2U * 2U);
  EXPECT_EQ(count(html, "<figcaption>"), figures);
  std::sort(ids.begin(), ids.end());
  EXPECT_EQ(std::adjacent_find(ids.begin(), ids.end()), ids.end());
  EXPECT_EQ(html, page()) << "not the same for the same runs";
}

TEST_F(Comparison, NamesEveryFolderThatIsNoRunAndEveryFolderGivenTwice) {
  fs::create_directories(root_ / "empty");
  fs::create_directories(root_ / "broken");
  std::ofstream(root_ / "broken/metrics.json") << "{";
  const std::vector<fs::path> folders = {root_ / "empty", folders_[0], root_ / "broken", root_ / "nowhere",
                                         root_ / "empty" / ".." / "run 1"};
  try {
    write_comparison(folders, root_ / "out");
    FAIL() << "taken";
  } catch (const InputError& error) {
    EXPECT_EQ(error.problems().size(), 4U);
    EXPECT_THAT(error.what(), HasSubstr("empty: found no metrics.json, expected the folder of a run"));
    EXPECT_THAT(error.what(), HasSubstr("nowhere: found no metrics.json"));
    EXPECT_THAT(error.what(), HasSubstr("broken/metrics.json"));
    EXPECT_THAT(error.what(), HasSubstr("the same run twice"));
  }
  EXPECT_FALSE(fs::exists(root_ / "out"));
}

TEST_F(Comparison, TakesAFolderOfSchemaOneThatAnEarlierVersionWrote) {
  fs::copy(fs::path(SACCADE_SOURCE_DIR) / "tests/evaluation/report/schema_1_run", root_ / "old");
  folders_.push_back(root_ / "old");
  EXPECT_THAT(page(), HasSubstr("<h2>gaze_square_45cm"));
}

TEST_F(Comparison, OfRecordingsWithoutTruthShowsDashes) {
  for (std::size_t i = 0; i < 3; ++i) {
    fs::remove(folders_[i] / "truth.csv");
    fs::remove(folders_[i] / "gaze.csv");
    metrics_[i].gaze.reset();
    metrics_[i].seed.reset();
    metrics_[i].events_dropped.reset();
    for (auto& [name, score] : metrics_[i].detectors) score = {};
    write_metrics(folders_[i] / "metrics.json", metrics_[i]);
  }
  const std::string html = page();
  EXPECT_EQ(count(html, "<svg"), 1U);
  EXPECT_EQ(count(html, "data-value"), 0U);
  EXPECT_EQ(count(html, "<td class=\"none\">–</td>"), 5U * 9U);
  EXPECT_THAT(html, HasSubstr(">run 2</a>"));
}

}  // namespace
}  // namespace saccade
