#include "evaluation/figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include "core/error.h"
#include "evaluation/gnuplot.h"
#include "tests/evaluation/svg_check.h"

namespace saccade {
namespace {

using testing::HasSubstr;
using testing::Not;

std::size_t count(std::string_view text, std::string_view part) {
  std::size_t n = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string_view::npos; at += part.size()) ++n;
  return n;
}

std::vector<TruthRow> sine_truth(int rows) {
  std::vector<TruthRow> truth;
  for (int i = 1; i <= rows; ++i) {
    truth.push_back({.t_us = i * 1000, .circle = {64 + 20 * std::sin(i * 0.01), 64, 20}, .visible = 1.0});
  }
  return truth;
}

std::vector<DetectionRow> dots(int rows, const std::string& detector) {
  std::vector<DetectionRow> detections;
  for (int i = 1; i <= rows; ++i) {
    detections.push_back(
        {.t_us = i * 1000, .detector = detector, .circle = {64, 64, 20}, .score = i % 10 * 1.0});
  }
  return detections;
}

TEST(Figures, AreWellFormedAndTheSameEveryTime) {
  const auto truth = sine_truth(500);
  const auto draw = [&] {
    return tracking_figure("a", truth, dots(500, "d"), "d", 5.0, "#0072b2", false, 0);
  };
  const std::string svg = draw();
  EXPECT_EQ(nesting_problem(svg), "");
  EXPECT_EQ(svg, draw());
  EXPECT_THAT(svg, testing::StartsWith("<svg"));
  EXPECT_THAT(svg, HasSubstr("id=\"a_"));
}

TEST(Figures, ShowTheObservationsAtAndAboveTheThresholdOnly) {
  const auto shown = [](double threshold) {
    const std::string svg =
        tracking_figure("a", sine_truth(200), dots(200, "d"), "d", threshold, "#0072b2", false, 0);
    return count(svg, "<use xlink:href='#a_gpPt6' transform");  // besides the definitions
  };
  EXPECT_EQ(shown(10.0), 0U);
  // Half the dots in each of three panels, and one in the key.
  EXPECT_EQ(shown(5.0), 3U * 100U + 1U);
}

TEST(Figures, ThinLongSeries) {
  const std::string svg =
      tracking_figure("a", sine_truth(100'000), dots(100'000, "d"), "d", 0.0, "#0072b2", false, 0);
  EXPECT_LE(count(svg, "#a_gpPt6"), 3 * max_figure_points + 2);
  EXPECT_LT(svg.size(), 600'000U);
}

TEST(Figures, OfHostileNamesAreTextAndNothingElse) {
  const std::filesystem::path trap = std::filesystem::path(testing::TempDir()) / "saccade_figures_trap";
  const std::string command = "system 'touch " + trap.string() + "'";
  const std::string name = "x' ; " + command + " #\n`date`<script>&\"@a_b";
  const std::string svg =
      tracking_figure("a", sine_truth(50), dots(50, name), name, 0.0, "#0072b2", false, 0);
  EXPECT_EQ(nesting_problem(svg), "");
  EXPECT_THAT(svg, Not(HasSubstr("<script")));
  EXPECT_THAT(svg, HasSubstr("x' ; " + command + " #`date`&lt;script>&amp;"));
  EXPECT_THAT(svg, HasSubstr("@a_b"));
  EXPECT_FALSE(std::filesystem::exists(trap));
}

TEST(Figures, OfNothingAreEmptyAxes) {
  Metrics metrics;
  EXPECT_EQ(nesting_problem(tracking_figure("a", {}, {}, "d", 0.0, "#000000", false, 0)), "");
  EXPECT_EQ(nesting_problem(precision_recall_figure("b", metrics)), "");
  EXPECT_EQ(nesting_problem(rates_figure("c", {}, {}, metrics, 0)), "");
  EXPECT_EQ(nesting_problem(fixation_figure("d", {}, PinholeCamera{}, 0)), "");
  EXPECT_EQ(nesting_problem(gaze_path_figure("e", {}, {})), "");
  EXPECT_EQ(nesting_problem(joints_figure("f", {}, JointLimits{}, 0)), "");
}

TEST(Figures, BreakALineWhereThereIsNoValue) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto strokes = [](std::vector<GnuplotFigure::Point> points) {
    GnuplotFigure figure("a", 300, 200);
    figure.add_panel("unset key\nunset border\nunset tics\nunset grid\n",
                     {{.title = "", .style = "lines lc rgb '#123456'", .points = std::move(points)}});
    const std::string svg = figure.svg();
    const std::size_t path = svg.find("rgb( 18,  52,  86)");
    return count(svg.substr(path, svg.find("/>", path) - path), "M");
  };
  EXPECT_EQ(strokes({{0, 0}, {1, 1}, {2, 0}, {3, 1}}), 1U);
  EXPECT_EQ(strokes({{0, 0}, {1, 1}, {1.5, nan}, {2, 0}, {3, 1}}), 2U);
}

TEST(Figures, WithoutGnuplotNameThePackage) {
  const std::string path = std::getenv("PATH");
  setenv("PATH", "/nonexistent", 1);
  try {
    static_cast<void>(precision_recall_figure("a", Metrics{}));
    ADD_FAILURE() << "drawn without gnuplot";
  } catch (const RunError& error) {
    EXPECT_THAT(error.what(), HasSubstr("gnuplot-nox"));
  }
  setenv("PATH", path.c_str(), 1);
}

TEST(Figures, SayWhatGnuplotDidNotUnderstand) {
  GnuplotFigure figure("a", 300, 200);
  figure.add_panel("set nonsense\n", {});
  EXPECT_THROW(static_cast<void>(figure.svg()), RunError);
}

}  // namespace
}  // namespace saccade
