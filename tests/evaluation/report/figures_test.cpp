#include "evaluation/report/figures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>

#include "core/error.h"
#include "evaluation/report/gnuplot.h"
#include "evaluation/report/report.h"
#include "tests/evaluation/report/svg_check.h"
#include "tests/evaluation/report/text_of.h"

namespace saccade {
namespace {

constexpr Colour blue{0x00, 0x72, 0xb2};
constexpr Colour red{0xd5, 0x5e, 0x00};

using testing::HasSubstr;
using testing::Not;

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

TEST(Figures, AreWellFormedAndReproducible) {
  const auto truth = sine_truth(500);
  const auto draw = [&] { return tracking_figure("a", truth, dots(500, "d"), "d", 5.0, blue, false, 0).svg; };
  const std::string svg = draw();
  EXPECT_EQ(nesting_problem(svg), "");
  EXPECT_EQ(svg, draw());
  EXPECT_THAT(svg, testing::StartsWith("<svg"));
  EXPECT_THAT(svg, HasSubstr("id=\"a_"));
}

TEST(Figures, ShowTheObservationsAtAndAboveTheThresholdOnly) {
  const auto shown = [](double threshold) {
    const std::string svg =
        tracking_figure("a", sine_truth(200), dots(200, "d"), "d", threshold, blue, false, 0).svg;
    return count(svg, "h0");
  };
  EXPECT_EQ(shown(10.0), 0U);
  // Half the dots in each of three panels, and one in the key.
  EXPECT_EQ(shown(5.0), 3U * 100U + 1U);
}

TEST(Figures, HaveNoTruthInTheKeyWhereThereIsNone) {
  const auto draw = [](const std::vector<TruthRow>& truth) {
    return tracking_figure("a", truth, dots(200, "d"), "d", 5.0, blue, false, 0).svg;
  };
  EXPECT_THAT(draw(sine_truth(200)), HasSubstr("truth"));
  EXPECT_THAT(draw({}), Not(HasSubstr("truth")));
}

TEST(Figures, OfADetectorThatEndedEarlyLastAsLongAsThoseOfOthers) {
  std::vector<DetectionRow> detections = dots(2'000, "d");
  detections.push_back({.t_us = 8'000'000, .detector = "other", .circle = {64, 64, 20}, .score = 1.0});
  const std::string svg = tracking_figure("a", {}, detections, "d", 5.0, blue, false, 0).svg;
  EXPECT_THAT(svg, HasSubstr(">7</text>")) << "a label of the time axis";
}

TEST(Figures, ThinLongSeries) {
  const std::string svg =
      tracking_figure("a", sine_truth(100'000), dots(100'000, "d"), "d", 0.0, blue, false, 0).svg;
  EXPECT_LE(count(svg, "h0"), 3 * max_figure_points + 2);
  EXPECT_LT(svg.size(), 200'000U);
}

TEST(Figures, DrawNamesWithGnuplotCommandsAsText) {
  const std::filesystem::path trap = std::filesystem::path(testing::TempDir()) / "saccade_figures_trap";
  const std::string command = "system 'touch " + trap.string() + "'";
  const std::string name = "x' ; " + command + " #\n`date`<script>&\"@a_b";
  const std::string svg = tracking_figure("a", sine_truth(50), dots(50, name), name, 0.0, blue, false, 0).svg;
  EXPECT_EQ(nesting_problem(svg), "");
  EXPECT_THAT(svg, Not(HasSubstr("<script")));
  EXPECT_THAT(svg, HasSubstr("x' ; " + command + " #`date`&lt;script>&amp;"));
  EXPECT_THAT(svg, HasSubstr("@a_b"));
  EXPECT_FALSE(std::filesystem::exists(trap));
}

TEST(Figures, WithoutDataAreEmptyAxes) {
  Metrics metrics;
  for (const Figure& figure :
       {tracking_figure("a", {}, {}, "d", 0.0, Colour{}, false, 0), precision_recall_figure("b", metrics),
        rates_figure("c", nullptr, {}, {}, {}, metrics, 0), rate_over_speed_figure("g", {}),
        precision_recall_spread_figure("h", {}), average_precision_figure("i", {})}) {
    EXPECT_EQ(nesting_problem(figure.svg), "") << figure.name;
  }
}

TEST(Figures, HaveAGapWhereAValueIsMissing) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto strokes = [](std::vector<GnuplotFigure::Point> points) {
    GnuplotFigure figure("a", 300, 200);
    figure.add_panel({.x_label = "",
                      .y_label = "",
                      .z_label = "",
                      .commands = "unset key\nunset border\nunset tics\nunset grid\n",
                      .series = {{.title = "a",
                                  .style = "lines lc rgb '#123456'",
                                  .points = std::move(points),
                                  .in_key = false}}});
    const std::string svg = figure.draw().svg;
    const std::size_t path = svg.find("rgb( 18,  52,  86)");
    return count(svg.substr(path, svg.find("/>", path) - path), "M");
  };
  EXPECT_EQ(strokes({{0, 0}, {1, 1}, {2, 0}, {3, 1}}), 1U);
  EXPECT_EQ(strokes({{0, 0}, {1, 1}, {1.5, nan}, {2, 0}, {3, 1}}), 2U);
}

TEST(Figures, GiveThePlotsOfAPageTheColourWidthAndRangesOfTheDrawing) {
  GnuplotFigure::Series drawn;
  drawn.title = "</script>";
  drawn.style = "linespoints lw 2.2 dt 2 lc rgb '#c0123456'";
  drawn.points = {{1.0, 2.0, 0.0}, {1.5, std::nan(""), 0.0}, {2.0, 3.0, 0.0}};
  GnuplotFigure figure("a", 100, 100);
  figure.add_panel({.x_label = "x",
                    .y_label = "y",
                    .z_label = "",
                    .commands = "set xrange [0.5:2.5]\nset yrange [0:*]\nset logscale x\n",
                    .series = {drawn}});
  const auto panel = nlohmann::json::parse(figure.draw().data).at("panels").at(0);
  EXPECT_EQ(panel.at("x_range").dump(), "[0.5,2.5]");
  EXPECT_TRUE(panel.at("y_range").is_null()) << "one side is free";
  EXPECT_TRUE(panel.at("log_x").get<bool>());
  const auto series = panel.at("series").at(0);
  EXPECT_EQ(series.at("colour"), "#1234563f") << "gnuplot's first two digits are transparency";
  EXPECT_EQ(series.at("width"), 2.2);
  EXPECT_TRUE(series.at("lines").get<bool>() && series.at("points").get<bool>() &&
              series.at("dashed").get<bool>());
  EXPECT_EQ(series.at("y").dump(), "[2,null,3]");
}

TEST(Figures, GiveThePlotsOfAPageTheTitlesAndTheWordsOfAnAxis) {
  GnuplotFigure figure("a", 300, 200);
  figure.add_panel({.x_label = "detector",
                    .y_label = "recall",
                    .z_label = "",
                    .commands = "unset logscale x\nset xrange [-1:2]\n",
                    .series = {{.title = "a", .style = "points pt 7", .points = {{0.0, 0.5, 0.0}}}},
                    .title = "at 30 cm",
                    .x_words = {{0.0, "best"}, {1.0, "it's"}}});
  const Figure drawn = figure.draw();
  const auto panel = nlohmann::json::parse(drawn.data).at("panels").at(0);
  EXPECT_EQ(panel.at("title"), "at 30 cm");
  EXPECT_EQ(panel.at("x_words").dump(), "[[0.0,\"best\"],[1.0,\"it's\"]]");
  EXPECT_FALSE(panel.at("log_x").get<bool>()) << "unset, not set";
  EXPECT_THAT(drawn.svg, HasSubstr("at 30 cm"));
  EXPECT_THAT(drawn.svg, HasSubstr("best"));
  EXPECT_THAT(drawn.csv, HasSubstr("series,detector,\"at 30 cm, recall\"\n"));
}

TEST(Figures, WithoutGnuplotSaySoInTheirPlaceAndKeepTheirNumbers) {
  const std::string path = std::getenv("PATH");
  const Figure drawn = precision_recall_figure("a", Metrics{});
  setenv("PATH", "/nonexistent", 1);
  const Figure undrawn = precision_recall_figure("a", Metrics{});
  const std::string warning = undrawn_warning();
  setenv("PATH", path.c_str(), 1);
  EXPECT_THAT(undrawn.svg, HasSubstr("gnuplot is not installed"));
  EXPECT_THAT(drawn.svg, Not(HasSubstr("gnuplot is not installed")));
  EXPECT_EQ(undrawn.csv, drawn.csv);
  EXPECT_EQ(undrawn.data, drawn.data);
  EXPECT_THAT(warning, HasSubstr("gnuplot-nox"));
  EXPECT_EQ(undrawn_warning(), "");
}

TEST(Figures, ReportTheErrorMessageOfGnuplot) {
  GnuplotFigure figure("a", 300, 200);
  figure.add_panel({.x_label = "", .y_label = "", .z_label = "", .commands = "set nonsense\n", .series = {}});
  EXPECT_THROW(static_cast<void>(figure.draw()), RunError);
}

/// The lines of a CSV text that begin with `start`, without it.
std::vector<std::string> lines_of(const std::string& csv, const std::string& start) {
  std::vector<std::string> lines;
  std::istringstream in(csv);
  for (std::string line; std::getline(in, line);) {
    if (line.starts_with(start)) lines.push_back(line.substr(start.size()));
  }
  return lines;
}

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream in(line + ",");
  for (std::string field; std::getline(in, field, ',');) fields.push_back(field);
  return fields;
}

TEST(FigureNumbers, HoldEveryPointThatIsDrawnBeforeItIsThinned) {
  auto truth = sine_truth(5000);
  truth[99].visible = 0.2;  // no chance, not drawn
  const std::string csv = tracking_figure("a", truth, dots(5000, "d"), "d", 5.0, blue, false, 0).csv;
  EXPECT_TRUE(csv.starts_with("series,time [s],x [px],y [px],r [px]\n")) << csv.substr(0, 80);
  EXPECT_EQ(lines_of(csv, "d,").size(), 2500U);
  EXPECT_EQ(lines_of(csv, "d,").front(), "0.005,64,64,20");
  ASSERT_EQ(lines_of(csv, "truth,").size(), 4999U);
  const auto fields = fields_of(lines_of(csv, "truth,").back());
  ASSERT_EQ(fields.size(), 4U);
  EXPECT_NEAR(std::stod(fields[0]), 5.0, 1e-9);
  EXPECT_NEAR(std::stod(fields[1]), truth.back().circle.x_px, 1e-6);
}

TEST(FigureNumbers, QuoteFieldsWithCommasQuotesAndLineBreaks) {
  EXPECT_EQ(csv_field("plain text"), "plain text");
  EXPECT_EQ(csv_field("a,b"), "\"a,b\"");
  EXPECT_EQ(csv_field("say \"a\""), "\"say \"\"a\"\"\"");
  EXPECT_EQ(file_part("paper_full-2"), "paper_full-2");
  EXPECT_EQ(file_part("../a b"), "___a_b");
}

Metrics metrics_of(std::initializer_list<std::string> detectors, double duration_s) {
  Metrics metrics;
  metrics.duration_s = duration_s;
  for (const std::string& name : detectors) metrics.detectors.emplace_back(name, DetectorScore{});
  return metrics;
}

TEST(RatesFigure, CountsDetectionsInTenthsOfASecondAndTheBallsSpeed) {
  // A ball at 250 px/s, hidden from 0.4 to 0.5 s, that one detector finds every other millisecond and one
  // never.
  std::vector<TruthRow> truth;
  for (int i = 1; i <= 1000; ++i) {
    truth.push_back(
        {.t_us = i * 1000, .circle = {0.25 * i, 64, 20}, .visible = i > 400 && i <= 500 ? 0.0 : 1.0});
  }
  std::vector<DetectionRow> detections;
  for (int i = 2; i <= 1000; i += 2) {
    detections.push_back(
        {.t_us = i * 1000, .detector = "half", .circle = {0.25 * i + 5, 64, 20}, .score = 1.0});
  }
  std::vector<std::vector<std::optional<bool>>> found;
  for (const char* name : {"half", "blind"}) found.push_back(found_at_chances(truth, detections, name, 0.5));
  const Metrics metrics = metrics_of({"half", "blind"}, 1.0);
  const Figure figure = rates_figure("a", nullptr, truth, found, detections, metrics, 0);
  EXPECT_EQ(nesting_problem(figure.svg), "");
  const auto half = lines_of(figure.csv, "half,");
  ASSERT_EQ(half.size(), 9U);  // ten bins, one without a chance
  for (const std::string& line : half) EXPECT_EQ(std::stod(fields_of(line).at(1)), 500.0) << line;
  for (const std::string& line : lines_of(figure.csv, "blind,"))
    EXPECT_EQ(std::stod(fields_of(line).at(1)), 0.0);
  const auto ball = lines_of(figure.csv, "ball,");
  ASSERT_EQ(ball.size(), 900U);
  for (const std::string& line : ball) EXPECT_NEAR(std::stod(fields_of(line).at(2)), 250.0, 1e-6) << line;
}

TEST(RatesFigure, ShowsTheHighestRateOfAFrameCameraUnlessOneIsSimulated) {
  const auto truth = sine_truth(300);
  const auto draw = [&](const Metrics& metrics) {
    const std::vector<std::vector<std::optional<bool>>> found(
        metrics.detectors.size(), std::vector<std::optional<bool>>(truth.size(), false));
    return rates_figure("a", nullptr, truth, found, {}, metrics, 0);
  };
  EXPECT_EQ(lines_of(draw(metrics_of({"d"}, 0.3)).csv, "30 Hz").size(), 2U);
  EXPECT_THAT(draw(metrics_of({"d"}, 0.3)).svg, HasSubstr("30 Hz"));
  EXPECT_EQ(lines_of(draw(metrics_of({"d", "frame_30hz"}, 0.3)).csv, "30 Hz").size(), 0U);
}

TEST(RatesFigure, OfARecordingCountsAcceptedObservations) {
  Metrics metrics = metrics_of({"d"}, 0.2);
  metrics.detectors[0].second.threshold = 5.0;
  const Figure figure = rates_figure("a", nullptr, {}, {}, dots(199, "d"), metrics, 0);
  const auto lines = lines_of(figure.csv, "d,");
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0], "0.05,500");
  EXPECT_EQ(lines[1], "0.15,500");
  EXPECT_THAT(figure.csv, Not(HasSubstr("30 Hz")));
}

TEST(RateOverSpeedFigure, HasNoPointForSpeedsWithFewChances) {
  SpeedCounts counts;
  counts.chances = {100, 49, 50};
  counts.found = {25, 49, 50};
  const std::vector<DetectorSpeeds> detectors = {{{"d", blue}, counts}};
  const auto lines = lines_of(rate_over_speed_figure("a", detectors).csv, "d,");
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(fields_of(lines[0]).at(1), "250");
  EXPECT_EQ(fields_of(lines[0]).at(2), "0.1");
  EXPECT_EQ(fields_of(lines[1]).at(1), "1000");
}

/// A curve of one precision up to a recall.
DetectorScore flat_score(double precision, double recall) {
  DetectorScore score;
  score.average_precision = precision * recall;
  score.precision = precision;
  score.recall = recall;
  score.threshold = 0.5;
  for (int i = 1; i <= 100; ++i) score.pr_curve.push_back({1.0 - 0.005 * i, precision, 0.01 * i * recall});
  return score;
}

TEST(PrecisionRecallSpread, AveragesThePrecisionAtEveryRecallThatAllRunsReach) {
  const std::vector<DetectorRuns> detectors = {
      {{"d", blue}, {flat_score(0.4, 0.505), flat_score(0.8, 0.705)}}};
  const Figure figure = precision_recall_spread_figure("a", detectors);
  const auto mean = lines_of(figure.csv, "d,");
  ASSERT_EQ(mean.size(), 50U);
  for (const std::string& line : mean) EXPECT_NEAR(std::stod(fields_of(line).at(1)), 0.6, 1e-9) << line;
  EXPECT_EQ(lines_of(figure.csv, "\"d, run 1\",").size(), 100U);
  EXPECT_EQ(lines_of(figure.csv, "\"d, run 2\",").size(), 100U);
  EXPECT_EQ(lines_of(figure.csv, "\"d, its threshold\",").at(0), "0.605,0.6,0.5");

  const std::vector<DetectorRuns> alone = {{{"d", blue}, {flat_score(0.4, 0.505)}}};
  EXPECT_EQ(lines_of(precision_recall_spread_figure("a", alone).csv, "d,").size(), 100U);
}

TEST(AveragePrecisionFigure, HasADotForEveryRunAndABarForSeveralRuns) {
  const std::vector<RunGroup> groups = {
      {"one, two", {{{"d", blue}, {flat_score(0.4, 1), flat_score(0.6, 1)}}, {{"e", red}, {{}, {}}}}},
      {"three", {{{"d", blue}, {flat_score(0.9, 1)}}}}};
  const Figure figure = average_precision_figure("a", groups);
  EXPECT_EQ(nesting_problem(figure.svg), "");
  EXPECT_EQ(count(figure.svg, "h0"), 3U);
  EXPECT_THAT(figure.svg, HasSubstr("stroke-width=\"7.00\""));
  EXPECT_THAT(average_precision_figure("a", std::span(groups).last(1)).svg,
              Not(HasSubstr("stroke-width=\"7.00\"")));
  EXPECT_THAT(figure.svg, HasSubstr("average precision</text>"));
  EXPECT_THAT(figure.svg, HasSubstr("one, two</text>"));
  EXPECT_EQ(figure.csv,
            "group,detector,run,average precision\n\"one, two\",d,1,0.4\n\"one, two\",d,2,0.6\n"
            "\"one, two\",e,1,\n\"one, two\",e,2,\nthree,d,1,0.9\n");
}

}  // namespace
}  // namespace saccade
