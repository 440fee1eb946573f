#include "evaluation/report/report.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <charconv>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "core/config.h"
#include "core/error.h"
#include "evaluation/report/run_data.h"
#include "recording/format_registry.h"
#include "tests/evaluation/report/svg_check.h"
#include "tests/evaluation/report/synthetic_run.h"
#include "tests/evaluation/report/text_of.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

void write_report(const fs::path& folder) { saccade::write_report(folder, built_in_formats()); }

/// The numbers in a table's row whose heading holds `name`; none for a dash.
std::vector<std::optional<double>> numbers_of(const std::string& html, const std::string& table,
                                              const std::string& name) {
  const std::size_t start = html.find(name, html.find("<tbody>", html.find("<table id=\"" + table + "\">")));
  const std::string row = html.substr(start, html.find("</tr>", start) - start);
  std::vector<std::optional<double>> numbers;
  for (std::size_t at = 0; (at = row.find("<td", at)) != std::string::npos; ++at) {
    const std::string cell = row.substr(at, row.find('>', at) - at);
    const std::size_t value = cell.find("data-value=\"");
    numbers.push_back(value == std::string::npos ? std::nullopt
                                                 : std::optional(std::stod(cell.substr(value + 12))));
  }
  return numbers;
}

class Report : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::path(testing::TempDir()) / (std::string("saccade_report_") +
                                              testing::UnitTest::GetInstance()->current_test_info()->name());
  }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path folder_;
};

TEST_F(Report, IsSelfContained) {
  write_synthetic_run(folder_, true);
  write_report(folder_);
  const std::string page = contents(folder_ / "report.html");
  EXPECT_LT(page.size(), 5'000'000U);
  EXPECT_EQ(count(page, "<script>"), 3U) << "the library, the plots, and the tables";
  const std::string html = without_scripts(page);
  for (const char* outside :
       {"http:", "https:", "//www", "<script src", "<link", "<iframe", "@import", "file:"}) {
    EXPECT_THAT(html, Not(HasSubstr(outside)));
  }
  EXPECT_EQ(count(html, "src=\""), count(html, "src=\"data:image/"));
  EXPECT_THAT(html, HasSubstr("synthetic square &lt;45 cm&gt;"));
}

TEST_F(Report, HasImagesOfEyeAndSceneForEveryFrameAndACaptionForEveryFigure) {
  write_synthetic_run(folder_, true);
  write_report(folder_);
  const std::string html = without_scripts(contents(folder_ / "report.html"));
  EXPECT_EQ(count(html, "data:image/png"), 8U + 8U);   // eyes, and four gaze shifts
  EXPECT_EQ(count(html, "data:image/jpeg"), 8U + 8U);  // scenes, and four instants of image and Hough space
  EXPECT_EQ(count(html, "<figure>") + count(html, "<figure id="), 11U);
  EXPECT_EQ(count(html, "<figcaption>"), 11U);
}

TEST_F(Report, BeginsWithTheHeadlineFiguresAndWhatMadeThem) {
  write_synthetic_run(folder_, true);
  Metrics metrics = read_metrics(folder_ / "metrics.json");
  metrics.event_count = 1234567;
  metrics.events_dropped = 12;
  metrics.gaze->score.on_target_ratio = 0.9931;
  metrics.gaze->score.acquire_s = 0.714;
  write_metrics(folder_ / "metrics.json", metrics);
  std::ofstream(folder_ / "scenario.yaml")
      << "# saccade 0.1.0 (abc1234); llvmpipe\nname: x\ndescription: A ball <moves>\n";
  write_report(folder_);
  const std::string html = contents(folder_ / "report.html");
  EXPECT_LT(html.find("class=\"card\""), html.find("<figure"));
  EXPECT_THAT(html, HasSubstr("<b>99.3 %</b> of the time from then on the gaze was within 2° of the ball"));
  EXPECT_THAT(html, HasSubstr("<b>0.71 s</b>"));
  EXPECT_THAT(html, HasSubstr("A ball &lt;moves&gt;"));
  EXPECT_THAT(html, HasSubstr("<th>Version and commit</th><td>saccade 0.1.0 (abc1234)</td>"));
  EXPECT_THAT(html, HasSubstr("<th>Drawn by</th><td>llvmpipe</td>"));
  EXPECT_THAT(html, HasSubstr("<td>1\u202f234\u202f567"));
  EXPECT_THAT(html, HasSubstr("; 12 dropped (below 0.1 % of all)</td>"));
  EXPECT_THAT(html, Not(HasSubstr("id=\"dropped\"")));
  EXPECT_THAT(html, HasSubstr("pixels, focal length"));
}

TEST_F(Report, BeginsWithAWarningWhereTheCameraDroppedEvents) {
  write_synthetic_run(folder_, true);
  Metrics metrics = read_metrics(folder_ / "metrics.json");
  metrics.event_count = 900;
  metrics.events_dropped = 100;
  write_metrics(folder_ / "metrics.json", metrics);
  write_report(folder_);
  const std::string html = contents(folder_ / "report.html");
  const std::size_t at = html.find("id=\"dropped\">The event camera dropped 10.0 % of its events");
  ASSERT_NE(at, std::string::npos);
  EXPECT_LT(at, html.find("class=\"card\""));
}

TEST_F(Report, HasTheNumbersOfEveryDrawingForThePlotsAndButtonsToSaveThem) {
  write_synthetic_run(folder_, true);
  write_report(folder_);
  const std::string html = contents(folder_ / "report.html");
  const std::size_t drawings = count(html, "<figure id=");
  EXPECT_GE(drawings, 7U);
  EXPECT_EQ(count(html, "<svg"), drawings);
  EXPECT_EQ(count(html, "<button data-save=\"svg\">"), drawings);
  EXPECT_EQ(count(html, "<button data-save=\"pdf\">"), drawings);
  EXPECT_EQ(count(html, "<button data-save=\"csv\">"), drawings);
  constexpr std::string_view open = "<script type=\"application/json\">";
  std::size_t over_x = 0;
  for (std::size_t at = 0; (at = html.find(open, at)) != std::string::npos; ++at) {
    const std::size_t begin = at + open.size();
    const auto data = nlohmann::json::parse(html.substr(begin, html.find("</script>", begin) - begin));
    over_x += data.at("over_x").get<bool>() ? 1U : 0U;
    for (const auto& panel : data.at("panels")) {
      for (const auto& series : panel.at("series")) EXPECT_EQ(series.at("x").size(), series.at("y").size());
    }
  }
  EXPECT_EQ(over_x, drawings - 1) << "all but the paths of the gaze";
}

TEST_F(Report, WritesEachFigureForAPaperAsSvgPdfAndCsv) {
  write_synthetic_run(folder_, true);
  write_report(folder_, built_in_formats(), folder_ / "paper");
  const std::string html = contents(folder_ / "report.html");
  std::map<std::string, std::size_t> files;
  for (const auto& entry : fs::directory_iterator(folder_ / "paper"))
    ++files[entry.path().extension().string()];
  const std::size_t drawings = count(html, "<figure id=");
  EXPECT_EQ(files,
            (std::map<std::string, std::size_t>{{".csv", drawings}, {".pdf", drawings}, {".svg", drawings}}));
  EXPECT_EQ(contents(folder_ / "paper/precision_recall.csv"),
            contents(folder_ / "figures/precision_recall.csv"));
  EXPECT_TRUE(contents(folder_ / "paper/joints.pdf").starts_with("%PDF"));
  const std::string svg = contents(folder_ / "paper/precision_recall.svg");
  EXPECT_EQ(nesting_problem(svg.substr(svg.find("<svg"))), "");
  EXPECT_THAT(svg, HasSubstr("width=\"88.00mm\"")) << "one column";
  EXPECT_THAT(contents(folder_ / "paper/joints.svg"), HasSubstr("width=\"181.00mm\"")) << "the whole page";
}

TEST_F(Report, HasTheKeyOfAPapersFigureBelowTheLabelsOfItsAxis) {
  if (std::system("command -v pdftotext > /dev/null") != 0) GTEST_SKIP() << "pdftotext is not installed";
  write_synthetic_run(folder_, true);
  write_report(folder_, built_in_formats(), folder_ / "paper");
  for (const char* const figure : {"precision_recall", "rate_over_speed"}) {
    const std::string words = (folder_ / "words.html").string();
    ASSERT_EQ(
        std::system(
            ("pdftotext -bbox '" + (folder_ / "paper" / figure).string() + ".pdf' '" + words + "'").c_str()),
        0);
    const std::string text = contents(words);
    const auto bound = [&](const std::string& word, const std::string& name) {
      const std::size_t end = text.find(">" + word + "<");
      return end == std::string::npos
                 ? -1.0
                 : std::stod(text.substr(text.rfind(name + "=\"", end) + name.size() + 2));
    };
    const double label_ends = bound(std::string(figure) == "precision_recall" ? "recall" : "speed", "yMax");
    ASSERT_GT(label_ends, 0.0) << figure;
    for (const char* const detector : {"paper_full", "paper_directed"})
      EXPECT_GE(bound(detector, "yMin"), label_ends) << figure << " " << detector;
  }
}

TEST_F(Report, OpensInABrowserWithoutAnErrorAndDrawsItsPlots) {
  if (std::system("command -v chromium > /dev/null") != 0) GTEST_SKIP() << "chromium is not installed";
  write_synthetic_run(folder_, true);
  write_report(folder_);
  const std::string command =
      "timeout 120 chromium --headless --no-sandbox --disable-gpu --enable-logging=stderr --dump-dom "
      "'file://" +
      (folder_ / "report.html").string() + "' > '" + (folder_ / "dom").string() + "' 2> '" +
      (folder_ / "log").string() + "'";
  ASSERT_EQ(std::system(command.c_str()), 0) << contents(folder_ / "log");
  EXPECT_THAT(contents(folder_ / "log"), Not(HasSubstr("CONSOLE")));
  EXPECT_GE(count(contents(folder_ / "dom"), "<canvas"), 10U);
}

TEST_F(Report, PrintsADrawingAloneOnAPageOfItsSize) {
  if (std::system("command -v chromium > /dev/null") != 0) GTEST_SKIP() << "chromium is not installed";
  write_synthetic_run(folder_, true);
  write_report(folder_);
  const std::string html = contents(folder_ / "report.html");
  const std::size_t start = html.find("viewBox=\"0 0 ", html.find("<figure id=\"figure_joints\">")) + 13;
  double width_px = 0.0;
  double height_px = 0.0;
  ASSERT_EQ(std::sscanf(html.c_str() + start, "%lf %lf", &width_px, &height_px), 2);
  const std::string command =
      "timeout 120 chromium --headless --no-sandbox --disable-gpu --no-pdf-header-footer --print-to-pdf='" +
      (folder_ / "joints.pdf").string() + "' 'file://" + (folder_ / "report.html").string() +
      "#print=joints' > '" + (folder_ / "log").string() + "' 2>&1";
  ASSERT_EQ(std::system(command.c_str()), 0) << contents(folder_ / "log");
  const std::string pdf = contents(folder_ / "joints.pdf");
  ASSERT_TRUE(pdf.starts_with("%PDF"));
  EXPECT_EQ(count(pdf, "/MediaBox"), 1U) << "one page";
  double width_pt = 0.0;
  double height_pt = 0.0;
  ASSERT_EQ(
      std::sscanf(pdf.c_str() + pdf.find("/MediaBox"), "/MediaBox [%*f %*f %lf %lf", &width_pt, &height_pt),
      2);
  // 96 px are 72 pt; the browser rounds to whole points.
  EXPECT_NEAR(width_pt, 0.75 * width_px, 1.0);
  EXPECT_NEAR(height_pt, 0.75 * height_px, 1.0);
}

TEST_F(Report, PrintsEveryDrawingOnOnePageAndEveryColumnOfItsTables) {
  if (std::system("command -v chromium > /dev/null && command -v pdftotext > /dev/null") != 0)
    GTEST_SKIP() << "chromium or pdftotext is not installed";
  write_synthetic_run(folder_, true);
  write_report(folder_);
  const std::string pdf = (folder_ / "report.pdf").string();
  const std::string command =
      "cd '" + folder_.string() + "' && timeout 120 chromium --headless --no-sandbox --disable-gpu " +
      "--no-pdf-header-footer --print-to-pdf=report.pdf 'file://" + (folder_ / "report.html").string() +
      "' > log 2>&1 && pdftotext -layout report.pdf report.txt";
  ASSERT_EQ(std::system(command.c_str()), 0) << contents(folder_ / "log");
  const std::string text = contents(folder_ / "report.txt");
  std::size_t drawings = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\f', begin), text.size());
    const std::string page = text.substr(begin, end - begin);
    // The panels of x, y and r over time are one drawing.
    EXPECT_EQ(count(page, "x [px]"), count(page, "r [px]")) << page;
    drawings += count(page, "r [px]");
    begin = end + 1;
  }
  EXPECT_EQ(drawings, count(contents(folder_ / "report.html"), "<figure id=\"figure_track_"));
  EXPECT_GT(drawings, 1U);
  // The last column of the widest table.
  EXPECT_THAT(text, HasSubstr("µs"));
}

TEST_F(Report, ShowsTheSavedHoughSpacesAndTheirMaxima) {
  write_synthetic_run(folder_, true);
  write_report(folder_);
  std::string html = contents(folder_ / "report.html");
  EXPECT_EQ(count(html, "alt=\"Hough space of paper_directed at"), 4U);
  EXPECT_EQ(count(html, "strongest 0.75, threshold 0.45"), 4U);
  EXPECT_EQ(count(html, "Hough space of paper_full"), 0U);

  // A maximum without a point in its number, and a picture of a detector that was not in the run.
  for (int t_ms = 500; t_ms <= 4000; t_ms += 500) {
    const std::string start = (folder_ / "frames" / std::to_string(t_ms * 1000)).string();
    fs::copy(start + "_paper_directed_hough_0.75.png", start + "_paper_full_hough_3.png");
    fs::copy(start + "_paper_directed_hough_0.75.png", start + "_stranger_hough_3.png");
  }
  write_report(folder_);
  html = contents(folder_ / "report.html");
  EXPECT_EQ(count(html, "alt=\"Hough space of paper_full at"), 4U);
  EXPECT_EQ(count(html, "strongest 3, threshold 0.45"), 4U);
  EXPECT_THAT(html, Not(HasSubstr("stranger")));
}

TEST_F(Report, ShowsTheHoughSpacesOfThreeDetectorsAndOfTheBestOfTheOthers) {
  write_synthetic_run(folder_, true);
  Metrics metrics = read_metrics(folder_ / "metrics.json");
  for (const auto& [name, average_precision] :
       {std::pair("third", 0.2), {"fourth", 0.3}, {"best", 0.9}, {"sixth", 0.4}}) {
    metrics.detectors.emplace_back(name, DetectorScore{});
    metrics.detectors.back().second.average_precision = average_precision;
    for (int t_ms = 500; t_ms <= 4000; t_ms += 500) {
      const std::string start = (folder_ / "frames" / std::to_string(t_ms * 1000)).string();
      fs::copy(start + "_paper_directed_hough_0.75.png", start + "_" + name + "_hough_3.png");
    }
  }
  write_metrics(folder_ / "metrics.json", metrics);
  write_report(folder_);
  const std::string html = contents(folder_ / "report.html");
  EXPECT_EQ(count(html, "Hough space of paper_directed at"), 4U);
  EXPECT_EQ(count(html, "Hough space of best at"), 4U);
  EXPECT_EQ(count(html, "Hough space of sixth at"), 0U);
}

TEST_F(Report, WritesTheNumbersOfEveryFigureBesideThePage) {
  write_synthetic_run(folder_, false);
  write_report(folder_);
  const std::string html = contents(folder_ / "report.html");
  std::size_t linked = 0;
  const std::string mark = "href=\"figures/";
  for (std::size_t at = 0; (at = html.find(mark, at)) != std::string::npos; ++at, ++linked) {
    const std::string name =
        html.substr(at + mark.size(), html.find('"', at + mark.size()) - at - mark.size());
    const std::string csv = contents(folder_ / "figures" / name);
    EXPECT_TRUE(csv.starts_with("series,")) << name;
    EXPECT_GT(count(csv, "\n"), 2U) << name;
  }
  EXPECT_EQ(linked, count(html, "<svg"));
  for (const auto& entry : fs::directory_iterator(folder_ / "figures")) {
    EXPECT_EQ(entry.path().extension(), ".csv");
  }
  EXPECT_TRUE(fs::exists(folder_ / "figures/track_paper_directed.csv"));
}

TEST_F(Report, ShowsGazeShiftsAtTheTargetsTimeAndAtTheEyesArrival) {
  write_synthetic_run(folder_, false);
  write_report(folder_);
  const std::string html = contents(folder_ / "report.html");
  // The first target comes at 40 ms: of the 17.4 deg to a ball 0.1 m to the left and below, 0.99^40 are left.
  EXPECT_THAT(html, HasSubstr("<p>(a) 0.04 s · target "));
  const std::size_t first = html.find("target ", html.find("<p>(a) 0.04 s")) + 7;
  EXPECT_NEAR(std::stod(html.substr(first)), 17.4 * 0.669, 0.4);
  const std::size_t second = html.find("target ", html.find("<p>(b) 0.")) + 7;
  EXPECT_LT(std::stod(html.substr(second)), 17.4 * 0.669 / 4.0 + 0.1);
  EXPECT_EQ(count(html, "alt=\"gaze shift at"), 8U);
  EXPECT_THAT(html, HasSubstr("window: 1500 events · gate: authors · controller: qp"));
}

TEST_F(Report, OfARunWithoutTheEyesPoseHasNoFiguresThatNeedIt) {
  write_synthetic_run(folder_, false);
  write_report(folder_);
  EXPECT_THAT(contents(folder_ / "report.html"), HasSubstr("<h3>Gaze over time"));
  fs::remove(folder_ / "eye.csv");
  write_report(folder_);
  const std::string html = contents(folder_ / "report.html");
  EXPECT_THAT(html, Not(HasSubstr("<h3>Gaze over time")));
  EXPECT_THAT(html, Not(HasSubstr("<h3>Gaze shifts")));
  EXPECT_THAT(html, HasSubstr("<h3>Gaze in the robot's frame"));
}

TEST_F(Report, NamesRejectedEvents) {
  Metrics metrics = write_synthetic_run(folder_, false);
  metrics.detectors[0].second.rejected_events = RejectedEvents{};
  write_metrics(folder_ / "metrics.json", metrics);
  write_report(folder_);
  EXPECT_THAT(contents(folder_ / "report.html"), Not(HasSubstr("events outside the image")));
  metrics.detectors[0].second.rejected_events = {.outside_image = 12, .back_in_time = 3};
  write_metrics(folder_ / "metrics.json", metrics);
  write_report(folder_);
  EXPECT_THAT(contents(folder_ / "report.html"),
              HasSubstr("paper_full dropped 12 events outside the image and 3 whose time goes back"));
}

TEST_F(Report, HasWellFormedFiguresWithUniqueIds) {
  write_synthetic_run(folder_, true);
  write_report(folder_);
  const std::string html = contents(folder_ / "report.html");
  std::size_t figures = 0;
  std::vector<std::string> ids;
  for (std::size_t at = 0; (at = html.find("<svg", at)) != std::string::npos; ++at) {
    const std::string svg = html.substr(at, html.find("</svg>", at) + 6 - at);
    EXPECT_EQ(nesting_problem(svg), "");
    ++figures;
    for (std::size_t id = 0; (id = svg.find(" id=", id)) != std::string::npos; ++id) {
      ids.push_back(svg.substr(id + 5, svg.find(svg[id + 4], id + 5) - id - 5));
    }
  }
  EXPECT_EQ(figures, 8U);
  std::sort(ids.begin(), ids.end());
  EXPECT_EQ(std::adjacent_find(ids.begin(), ids.end()), ids.end());
}

TEST_F(Report, ShowsTheFiguresOfTheMetrics) {
  write_synthetic_run(folder_, false);
  write_report(folder_);
  const std::string html = contents(folder_ / "report.html");
  const auto json = nlohmann::json::parse(contents(folder_ / "metrics.json"));
  const auto value = [](const nlohmann::json& j) {
    return j.is_null() ? std::nullopt : std::optional(j.get<double>());
  };
  for (const char* name : {"paper_full", "paper_directed"}) {
    const auto& d = json["detectors"][name];
    const auto& streaming = d["streaming"];
    const auto streaming_value = [&](const char* key, const char* part) {
      if (streaming.is_null()) return std::optional<double>();
      return value(*part == '\0' ? streaming[key] : streaming[key][part]);
    };
    const std::vector<std::optional<double>> expected = {value(d["average_precision"]),
                                                         streaming_value("average_precision", ""),
                                                         streaming_value("latency_ms", "median"),
                                                         value(d["threshold"]),
                                                         value(d["precision"]),
                                                         value(d["recall"]),
                                                         value(d["detection_rate_hz"]["mean"]),
                                                         value(d["detection_rate_hz"]["peak"]),
                                                         value(d["position_error_px"]["median"]),
                                                         value(d["position_error_px"]["p95"]),
                                                         value(d["radius_error_px"]["median"]),
                                                         value(d["radius_error_px"]["p95"]),
                                                         value(d["lag_ms"]),
                                                         value(d["us_per_event"])};
    EXPECT_EQ(numbers_of(html, "detectors", name), expected);
  }
  const auto& gaze = json["gaze"];
  const auto row = [&](const char* name) { return numbers_of(html, "gaze", name).at(0); };
  EXPECT_EQ(row("acquired"), value(gaze["acquire_s"]));
  EXPECT_EQ(row("error, median"), value(gaze["fixation_error_deg"]["median"]));
  EXPECT_EQ(row("error, 95"), value(gaze["fixation_error_deg"]["p95"]));
  EXPECT_EQ(row("on target"), value(gaze["on_target_ratio"]));
  EXPECT_EQ(row("in view"), value(gaze["in_view_ratio"]));
  EXPECT_EQ(row("detected while following"), value(gaze["following_rate_hz"]));
  EXPECT_EQ(row("target off"), value(gaze["target_error_m"]["median"]));
  EXPECT_EQ(row(">moves"), value(gaze["moves"]));
  EXPECT_EQ(row("wrong moves"), value(gaze["wrong_moves"]));
  EXPECT_EQ(row("saccades"), value(gaze["saccades"]));
  EXPECT_EQ(row("saccades per s"), gaze["saccades"].get<double>() / 4.0);
  EXPECT_EQ(row("violations"), value(gaze["limit_violations"]));
}

TEST_F(Report, OfARecordingShowsTheTablesThatExist) {
  Metrics metrics = write_synthetic_run(folder_, false);
  fs::remove(folder_ / "gaze.csv");
  metrics.gaze.reset();
  metrics.camera.reset();
  metrics.seed.reset();
  write_metrics(folder_ / "metrics.json", metrics);
  write_report(folder_);
  std::string html = without_scripts(contents(folder_ / "report.html"));
  EXPECT_EQ(count(html, "<svg"), 5U);  // two detectors, precision and recall, rates over time and speed
  EXPECT_EQ(count(html, "data:image/png"), 8U);
  EXPECT_THAT(html, Not(HasSubstr("<h2>Gaze")));

  fs::remove(folder_ / "truth.csv");
  fs::remove(folder_ / "events.csv");
  for (auto& [name, score] : metrics.detectors) {
    score = {};
    score.threshold = 0.45;
  }
  write_metrics(folder_ / "metrics.json", metrics);
  write_report(folder_);
  html = contents(folder_ / "report.html");
  EXPECT_EQ(count(html, "<svg"), 2U);
  EXPECT_THAT(html, HasSubstr("Events are not shown"));
}

TEST_F(Report, IsReproducible) {
  write_synthetic_run(folder_, true);
  write_report(folder_);
  const std::string first = contents(folder_ / "report.html");
  write_report(folder_);
  EXPECT_EQ(first, contents(folder_ / "report.html"));
}

TEST_F(Report, ReadsAFolderOfSchemaOneThatAnEarlierVersionWrote) {
  fs::copy(fs::path(SACCADE_SOURCE_DIR) / "tests/evaluation/report/schema_1_run", folder_);
  write_report(folder_);
  const std::string html = contents(folder_ / "report.html");
  EXPECT_THAT(html, HasSubstr("<h1>gaze_square_45cm</h1>"));
  const auto json = nlohmann::json::parse(contents(folder_ / "metrics.json"));
  EXPECT_EQ(numbers_of(html, "detectors", "best").at(0),
            json["detectors"]["best"]["average_precision"].get<double>());
  EXPECT_THAT(html, HasSubstr("<h3>Gaze over time"));
  EXPECT_THAT(html, HasSubstr("Events are not shown"));  // the folder has no event file
  EXPECT_THAT(html, Not(HasSubstr("approximate")));
}

TEST_F(Report, SaysThatTheFiguresOfAVeryLongRunAreApproximate) {
  Metrics metrics = write_synthetic_run(folder_, false, 1, 1000);
  metrics.detectors[0].second.exact = false;
  write_metrics(folder_ / "metrics.json", metrics);
  EXPECT_THAT(contents(folder_ / "metrics.json"), HasSubstr("\"approximate\": true"));
  write_report(folder_);
  EXPECT_THAT(contents(folder_ / "report.html"), HasSubstr("curves are approximate"));
}

TEST_F(Report, RejectsAMissingMetricsFileAndImagesOfAnotherSize) {
  write_synthetic_run(folder_, true);
  cv::imwrite((folder_ / "frames" / "500000_eye.png").string(), cv::Mat(12, 12, CV_8UC1, cv::Scalar(0)));
  EXPECT_THROW(write_report(folder_), InputError);
  fs::remove(folder_ / "metrics.json");
  EXPECT_THROW(write_report(folder_), InputError);
  EXPECT_FALSE(fs::exists(folder_ / "report.html"));
}

TEST(ReportOfALongRun, KeepsTheSameInstantsOfEveryTableInBoundedMemory) {
  EXPECT_EQ(report_step_ms(12.0), 1);
  EXPECT_EQ(report_step_ms(262.144), 1);
  EXPECT_EQ(report_step_ms(262.2), 2);
  EXPECT_LE(36'000'000 / report_step_ms(36'000.0), 1 << 18) << "ten hours";
  const TempFolder folder;
  constexpr std::int64_t start_us = 12'345;
  TableWriter<TruthRow> truth(folder / "truth.csv");
  TableWriter<EyeRow> eye(folder / "eye.csv");
  for (std::int64_t ms = 0; ms < 100; ++ms) {
    TruthRow row;
    row.t_us = start_us + 1000 * ms;
    truth.write(row);
    if (ms % 2 == 0) eye.write(EyeRow::of(row.t_us, Eigen::Isometry3d::Identity()));
  }
  truth.commit();
  eye.commit();
  const auto truths = read_thinned_table<TruthRow>(folder / "truth.csv", start_us, 7);
  const auto eyes = read_thinned_table<EyeRow>(folder / "eye.csv", start_us, 7);
  ASSERT_EQ(truths.size(), 15u);
  ASSERT_EQ(eyes.size(), 8u);
  for (std::size_t i = 0; i < eyes.size(); ++i) EXPECT_EQ(eyes[i].t_us, truths[2 * i].t_us);
  EXPECT_EQ(read_thinned_table<TruthRow>(folder / "truth.csv", start_us, 1).size(), 100u);
  EXPECT_TRUE(read_thinned_table<TruthRow>(folder / "none.csv", start_us, 1).empty());
}

}  // namespace
}  // namespace saccade
