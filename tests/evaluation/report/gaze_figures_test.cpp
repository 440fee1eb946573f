#include "evaluation/report/gaze_figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <sstream>

#include "evaluation/report/overlay.h"
#include "head/icub_cameras.h"
#include "tests/evaluation/report/svg_check.h"

namespace saccade {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// A direction so many degrees to the right of straight ahead.
Eigen::Vector3d direction(double right_deg) {
  const double angle = right_deg * std::numbers::pi / 180.0;
  return {-std::cos(angle), std::sin(angle), 0.0};
}

/// A ball half a metre before an eye at the root's origin, 10 deg to the right; the eye turns 9 deg to the right in
/// the 50 ms from 200 ms on. A target on the ball from 200 ms on, one far from it at 600 ms, that on the ball again at
/// 700 ms.
struct MadeUpRun {
  std::vector<TruthRow> truth;
  std::vector<GazeRow> gaze;
  std::vector<EyeRow> eye;

  explicit MadeUpRun(bool converges = true) {
    for (int t_ms = 1; t_ms <= 1000; ++t_ms) {
      const double right_deg = 9.0 * std::clamp((t_ms - 200) / 50.0, 0.0, 1.0);
      Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
      const Eigen::Vector3d axis = direction(right_deg);
      pose.linear().col(0) = axis.cross(Eigen::Vector3d::UnitZ());
      pose.linear().col(1) = -Eigen::Vector3d::UnitZ();
      pose.linear().col(2) = axis;
      eye.push_back(EyeRow::of(t_ms * 1000, pose));
      truth.push_back(
          {.t_us = t_ms * 1000, .circle = {}, .visible = 1.0, .position_m = 0.5 * direction(10.0)});
      GazeRow row;
      row.t_us = t_ms * 1000;
      row.fixation_m.setConstant(nan);
      if (converges && t_ms > 100) row.fixation_m = 0.45 * axis;
      row.target_m.setConstant(nan);
      if (t_ms >= 200) row.target_m = 0.5 * direction(t_ms >= 600 && t_ms < 700 ? 25.0 : 10.0);
      gaze.push_back(row);
    }
  }
  [[nodiscard]] GazeTables tables() const { return {.truth = truth, .gaze = gaze, .eye = eye}; }
};

/// The rows of a CSV text that begin with `start`, as numbers, NaN where a field is empty.
std::vector<std::vector<double>> rows_of(const std::string& csv, const std::string& start) {
  std::vector<std::vector<double>> rows;
  std::istringstream in(csv);
  for (std::string line; std::getline(in, line);) {
    if (!line.starts_with(start)) continue;
    std::istringstream fields(line.substr(start.size()) + ",");
    rows.emplace_back();
    for (std::string field; std::getline(fields, field, ',');)
      rows.back().push_back(field.empty() ? nan : std::stod(field));
  }
  return rows;
}

TEST(GazeOverTime, ShowsErrorSpeedAndTargetsWithTheWrongOnesApart) {
  const MadeUpRun run;
  const Figure figure = gaze_over_time_figure("a", run.tables(), icub_left_2016, 250'000, 0);
  EXPECT_EQ(nesting_problem(figure.svg), "");
  const auto error = rows_of(figure.csv, "fixation error,");
  ASSERT_EQ(error.size(), 1000U);
  EXPECT_NEAR(error[99][1], 10.0, 1e-6);
  EXPECT_NEAR(error[899][1], 1.0, 1e-6);
  const auto speed = rows_of(figure.csv, "eye,");
  ASSERT_EQ(speed.size(), 1000U);
  EXPECT_NEAR(speed[224][2], 180.0, 1e-3);
  EXPECT_NEAR(speed[899][2], 0.0, 1e-3);
  const auto targets = rows_of(figure.csv, "gaze targets,");
  ASSERT_EQ(targets.size(), 2U);
  EXPECT_EQ(targets[0][0], 0.2);
  EXPECT_EQ(targets[1][0], 0.7);
  ASSERT_EQ(rows_of(figure.csv, "wrong ones,").size(), 1U);
  EXPECT_EQ(rows_of(figure.csv, "wrong ones,")[0][0], 0.6);
  EXPECT_THAT(figure.svg, HasSubstr("acquired</text>"));
  // The saccade's band, in both panels.
  const std::string band = "rgb(222, 218, 244)";
  EXPECT_NE(figure.svg.find(band), figure.svg.rfind(band));

  const Figure blind = gaze_over_time_figure("a", run.tables(), std::nullopt, std::nullopt, 0);
  EXPECT_EQ(rows_of(blind.csv, "wrong ones,").size(), 0U) << "without a camera nobody knows";
  EXPECT_THAT(blind.svg, Not(HasSubstr("acquired</text>")));
}

TEST(MainSequence, HasAPointForEverySaccade) {
  const std::vector<Saccade> saccades = {{1'000'000, 1'050'000, 9.0, 180.0},
                                         {3'000'000, 3'020'000, 2.0, 90.0}};
  const auto rows = rows_of(main_sequence_figure("a", saccades, 500'000).csv, "saccades,");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0], (std::vector<double>{9.0, 180.0, 0.5}));
  EXPECT_EQ(rows[1], (std::vector<double>{2.0, 90.0, 2.5}));
}

TEST(GazePaths, HoldBallTargetsAndFixationPointInTheRootFrame) {
  const MadeUpRun run;
  const std::vector<GazePath> gazes = {{"45 cm, near", run.tables(), 0}, {"far", run.tables(), 1000}};
  const Figure figure = gaze_paths_figure("a", gazes);
  EXPECT_EQ(nesting_problem(figure.svg), "");
  EXPECT_THAT(figure.svg, HasSubstr("45 cm, near</text>"));
  const auto ball = rows_of(figure.csv, "ball,\"45 cm, near\",");
  ASSERT_EQ(ball.size(), 1000U);
  EXPECT_NEAR(ball[0][1], -0.5 * std::cos(10.0 * std::numbers::pi / 180.0), 1e-9);
  EXPECT_NEAR(ball[0][2], 0.5 * std::sin(10.0 * std::numbers::pi / 180.0), 1e-9);
  EXPECT_EQ(rows_of(figure.csv, "gaze targets,far,").size(), 3U);
  EXPECT_NEAR(rows_of(figure.csv, "gaze targets,far,")[0][0], 0.199, 1e-9);
  const auto fixation = rows_of(figure.csv, "fixation point,far,");
  ASSERT_EQ(fixation.size(), 900U);
  EXPECT_NEAR(Eigen::Vector3d(fixation[0][1], fixation[0][2], fixation[0][3]).norm(), 0.45, 1e-9);
}

TEST(GazePaths, OfEyesThatDoNotConvergeShowTheAxisAtTheBallsDistance) {
  const MadeUpRun run(false);
  const std::vector<GazePath> gazes = {{"", run.tables(), 0}};
  const std::string csv = gaze_paths_figure("a", gazes).csv;
  EXPECT_EQ(rows_of(csv, "fixation point,").size(), 0U);
  const auto axis = rows_of(csv, "left eye's axis at the ball's distance,,");
  ASSERT_EQ(axis.size(), 1000U);
  const Eigen::Vector3d last(axis.back()[1], axis.back()[2], axis.back()[3]);
  EXPECT_LT((last - 0.5 * direction(9.0)).norm(), 1e-8);
}

TEST(GazeFigures, WithoutDataAreEmptyAxesAndReproducible) {
  for (const Figure& figure :
       {gaze_over_time_figure("a", {}, std::nullopt, std::nullopt, 0), main_sequence_figure("b", {}, 0),
        gaze_paths_figure("c", {}), gaze_paths_figure("d", std::vector<GazePath>{{}}),
        joints_figure("e", {}, JointLimits{}, 0)}) {
    EXPECT_EQ(nesting_problem(figure.svg), "") << figure.name;
  }
  const MadeUpRun run;
  const auto draw = [&] { return gaze_over_time_figure("a", run.tables(), icub_left_2016, 250'000, 0).svg; };
  EXPECT_EQ(draw(), draw());
}

}  // namespace
}  // namespace saccade
