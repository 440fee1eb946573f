#include "evaluation/report/sweep_report.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <iostream>

#include "tests/evaluation/report/text_of.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;

/// Two axes and seeds; precision falls with the speed, faster where it is noisy.
SweepTable table_of(int speeds, int noises, int seeds) {
  SweepTable table;
  table.name = "speed <and> noise";
  table.scenario = "a.yaml";
  table.version = "version 1";
  table.axes = {"speed_m_s", "noise", "seed"};
  table.metrics = {"detectors.one.average_precision", "detectors.two.average_precision",
                   "gaze.fixation_error_deg.median"};
  table.worst = 3;
  for (int i = 0; i < speeds; ++i) {
    for (int k = 0; k < noises; ++k) {
      for (int s = 1; s <= seeds; ++s) {
        SweepRow row;
        row.run = std::ssize(table.rows) + 1;
        row.id = fmt::format("id{}", row.run);
        row.status = "done";
        row.values = {fmt::format("{}", 0.5 + i), fmt::format("{}", k), std::to_string(s)};
        const double precision = 0.9 - 0.5 * (i + k) / (speeds + noises) + 0.01 * s;
        row.metrics = {precision, 0.5 * precision, k == 0 ? std::optional<double>() : 1.0 + k};
        for (const char* detector : {"one", "two"}) {
          std::vector<CurvePoint> curve;
          for (int p = 1; p <= 200; ++p)
            curve.push_back(
                {.threshold = 1.0 - p * 0.004, .precision = 1.0 - 0.001 * p, .recall = p * precision / 200});
          row.curves.emplace_back(detector, std::move(curve));
        }
        table.rows.push_back(std::move(row));
      }
    }
  }
  return table;
}

TEST(SweepReport, TheWorstRunsAreThoseWithTheWorstMainMetricEachOnce) {
  SweepTable table = table_of(3, 2, 2);
  const auto lowest = worst_runs(table);
  ASSERT_THAT(lowest, SizeIs(3));
  EXPECT_EQ(lowest[0]->run, 11);
  EXPECT_EQ(lowest[1]->run, 12);
  table.lowest_is_worst = false;
  EXPECT_EQ(worst_runs(table)[0]->run, 2);
  table.rows[0].id = table.rows[1].id;
  EXPECT_EQ(worst_runs(table)[0]->run, 1)
      << "the same run twice in the plan: its first place, by its own metric";
  for (SweepRow& row : table.rows) row.metrics[0].reset();
  EXPECT_THAT(worst_runs(table), SizeIs(0));
}

TEST(SweepReport, ShowsCurvesMapsWorstRunsAndFailedRuns) {
  const TempFolder folder;
  SweepTable table = table_of(4, 2, 2);
  table.rows[5].status = "failed";
  table.rows[5].failure = "no <light>";
  table.rows[5].metrics.assign(3, std::nullopt);
  table.rows[5].curves.clear();
  fs::create_directories(folder / "worst/id15");
  folder.write("worst/id15/report.html", "");
  write_sweep_report(table, folder / "");
  const std::string page = bytes_of(folder / "report.html");
  EXPECT_THAT(page, HasSubstr("<h1>speed &lt;and&gt; noise</h1>"));
  EXPECT_THAT(page, HasSubstr("16 runs of a.yaml: 15 done, 1 failed, 0 to do"));
  EXPECT_THAT(page, HasSubstr("average_precision over speed_m_s</h3>"));
  EXPECT_THAT(page, HasSubstr("average_precision of one over speed_m_s and noise</h3>"));
  EXPECT_THAT(page, HasSubstr("Precision and recall over noise</h3>"));
  EXPECT_THAT(page, HasSubstr("<a href=\"worst/id15/report.html\">report</a>"));
  EXPECT_THAT(page, HasSubstr("saccade run runs/id16/scenario.yaml"));
  EXPECT_THAT(page, HasSubstr("no &lt;light&gt;"));
  EXPECT_THAT(without_scripts(page), Not(HasSubstr("http"))) << "a page that needs no network";
  EXPECT_THAT(page, Not(HasSubstr("<script src")));

  EXPECT_THAT(page, HasSubstr("\"over_x\":true")) << "plots that can be zoomed";
  EXPECT_THAT(page, Not(HasSubstr("\"over_x\":false")));

  // Speed 0.5, noise 0: the mean of both seeds, by hand.
  const std::string numbers = bytes_of(folder / "figures/average_precision_over_speed_m_s.csv");
  EXPECT_THAT(numbers, HasSubstr("0.5,noise 0,one,2,0.915,"));
  EXPECT_THAT(bytes_of(folder / "figures/map_average_precision_of_one_speed_m_s_noise.csv"),
              HasSubstr("\n0,0.5,2,0.915,"));
}

TEST(SweepReport, AnAxisOfManyRandomValuesIsDrawnInIntervals) {
  const TempFolder folder;
  SweepTable table = table_of(40, 1, 1);
  write_sweep_report(table, folder / "");
  const std::string numbers = bytes_of(folder / "figures/average_precision_over_speed_m_s.csv");
  EXPECT_EQ(std::count(numbers.begin(), numbers.end(), '\n'), 17)
      << "a head, 8 stretches of both detectors: " << numbers;
}

TEST(SweepReport, AThousandRunsMakeAPageOfLessThanFiveMegabytes) {
  const TempFolder folder;
  write_sweep_report(table_of(10, 10, 10), folder / "");
  const auto size = fs::file_size(folder / "report.html");
  std::cout << "[          ] a page of 1000 runs has " << size / 1000 << " kB\n";
  EXPECT_LT(size, 5'000'000U);
}

TEST(SweepReport, WithoutResultsThereIsStillAPage) {
  const TempFolder folder;
  SweepTable table = table_of(2, 2, 1);
  for (SweepRow& row : table.rows) {
    row.status = "waiting";
    row.metrics.assign(3, std::nullopt);
    row.curves.clear();
  }
  write_sweep_report(table, folder / "");
  EXPECT_THAT(bytes_of(folder / "report.html"), HasSubstr("0 done, 0 failed, 4 to do"));
}

}  // namespace
}  // namespace saccade
