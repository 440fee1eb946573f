// The window on a virtual display, driven by keyboard and mouse, and its screenshots.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <future>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <optional>
#include <set>
#include <thread>

#include "apps/view/checkpoints.h"
#include "apps/view/layout.h"
#include "apps/view/playback.h"
#include "apps/view/view.h"
#include "config/scenario.h"
#include "core/detectors/built_in_detectors.h"
#include "evaluation/report/palette.h"
#include "recording/run_files.h"
#include "tests/config/built_in.h"
#include "tests/integration/window_test.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::string binary = SACCADE_BINARY;
const std::string scenarios = std::string(SACCADE_SOURCE_DIR) + "/scenarios/";
constexpr ImageSize image{128, 128};
const ViewLayout layout(1280, 720);

class ViewWindow : public WindowTest {
 protected:
  void open(const std::string& arguments) { open_window(arguments, "saccade view"); }
  /// Clicks on the timeline at a share of the recording's time.
  void click_time(double share) const { click_strip(layout.time_strip(), share); }
};

cv::Mat cut(const cv::Mat& shot, const Area& area) {
  return shot({static_cast<int>(area.x), static_cast<int>(area.y), static_cast<int>(area.width),
               static_cast<int>(area.height)});
}

bool same(const cv::Mat& a, const cv::Mat& b, const Area& area) {
  return cv::norm(cut(a, area), cut(b, area), cv::NORM_INF) == 0.0;
}

/// Compares every panel but the bar and the timeline, which also show the name of the last file.
bool same_moment(const cv::Mat& a, const cv::Mat& b) {
  for (const Area& area : {layout.scene, layout.eye, layout.hough, layout.detectors, layout.plots}) {
    if (!same(a, b, area)) return false;
  }
  return true;
}

bool is_event(const cv::Vec3b& bgr) { return std::abs(bgr[2] - bgr[0]) > 60; }

/// The share of the pixels on a circle's outline that show events; of all pixels without a circle.
double share_of_events(const cv::Mat& shot, const std::optional<Circle>& circle) {
  const Area at = ViewLayout::fit(layout.eye, image);
  const float scale = at.width / static_cast<float>(image.width);
  int all = 0;
  int events = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (circle && std::abs(std::hypot(x - circle->x_px, y - circle->y_px) - circle->r_px) > 1.5) continue;
      const auto pixel = shot.at<cv::Vec3b>(static_cast<int>(at.y + scale * (static_cast<float>(y) + 0.5F)),
                                            static_cast<int>(at.x + scale * (static_cast<float>(x) + 0.5F)));
      ++all;
      events += is_event(pixel) ? 1 : 0;
    }
  }
  return static_cast<double>(events) / all;
}

/// Number of pixels in the eye panel with the first detector's colour.
int pixels_of_first_detector(const cv::Mat& shot) {
  const cv::Mat eye = cut(shot, ViewLayout::fit(layout.eye, image));
  const Colour colour = detector_colour("best");
  int count = 0;
  for (auto it = eye.begin<cv::Vec3b>(); it != eye.end<cv::Vec3b>(); ++it)
    count += *it == cv::Vec3b(colour.blue, colour.green, colour.red) ? 1 : 0;
  return count;
}

TEST_F(ViewWindow, ShowsARecordedRunSeeksInItAndAppliesSettings) {
  ASSERT_EQ(run_shell("'" + binary + "' run '" + scenarios +
                      "hand_move.yaml' --set run.duration_s=0.8 --set output.pictures=0 --set expect={} "
                      "--set 'detectors={best: {radius_px: [4, 14], threshold: 0.385542}, paper_directed: "
                      "{radius_px: [4, 14]}}' "
                      "--set frame_30hz.exposure_ms=20 --set render.max_interval_ms=5 "
                      "--out " +
                      path("run"))
                .status,
            0);
  const auto truth = read_table<TruthRow>(path("run") + "/truth.csv");
  open("view '" + path("run") + "' --paused --pictures '" + path("pictures") + "'");

  EXPECT_EQ(screenshot().size(), cv::Size(1280, 720));  // it is there
  click_time(0.75);
  press("c");
  const cv::Mat bare = screenshot();
  ASSERT_EQ(bare.size(), cv::Size(1280, 720));
  const auto now = std::ranges::find(truth, shot_us(), &TruthRow::t_us);
  ASSERT_NE(now, truth.end()) << newest_shot_;
  EXPECT_NEAR(static_cast<double>(shot_us()), 0.75 * 0.8e6, 5e3);
  Circle elsewhere = now->circle;
  elsewhere.x_px += elsewhere.x_px < 64 ? 40 : -40;
  const double on_outline = share_of_events(bare, now->circle);
  std::printf("events on the ball's outline: %.2f of its pixels; in the whole image %.2f, elsewhere %.2f\n",
              on_outline, share_of_events(bare, std::nullopt), share_of_events(bare, elsewhere));
  EXPECT_GT(on_outline, 0.3);
  EXPECT_GT(on_outline, 2.0 * share_of_events(bare, std::nullopt));
  EXPECT_GT(on_outline, 2.0 * share_of_events(bare, elsewhere));

  press("c");
  const cv::Mat first = screenshot();
  EXPECT_GT(pixels_of_first_detector(first), 30) << "the circle that was found";
  EXPECT_EQ(pixels_of_first_detector(bare), 0);

  press("shift+Right shift+Right Right");
  const std::int64_t before_us = shot_us();
  const cv::Mat later = screenshot();
  EXPECT_EQ(shot_us(), before_us + 21'000);
  EXPECT_FALSE(same(first, later, layout.eye));
  EXPECT_FALSE(same(first, later, layout.plots));
  press("Left shift+Left shift+Left");
  EXPECT_TRUE(same_moment(first, screenshot())) << "stepped back";
  click_time(0.2);
  EXPECT_FALSE(same(first, screenshot(), layout.scene)) << "the hand is elsewhere";
  click_time(0.75);
  EXPECT_TRUE(same_moment(first, screenshot())) << "sought back and forth";

  // The wheel enlarges the eye's image around the ball, dragging moves it, a double click shows all of it.
  const Area eye = ViewLayout::fit(layout.eye, image);
  const float scale = eye.width / static_cast<float>(image.width);
  const float x = eye.x + scale * static_cast<float>(now->circle.x_px + 0.5);
  const float y = eye.y + scale * static_cast<float>(now->circle.y_px + 0.5);
  mouse(x, y, "click --repeat 3 --delay 50 4");
  const cv::Mat enlarged = screenshot();
  EXPECT_GT(pixels_of_first_detector(enlarged), 1.3 * pixels_of_first_detector(first))
      << "1.2^3 times as long";
  mouse(x, y, "mousedown 1 sleep 0.1 mousemove_relative 0 30 sleep 0.1 mouseup 1");
  const cv::Mat moved = screenshot();
  const auto row_of_circle = [&](const cv::Mat& shot) {
    const cv::Mat panel = cut(shot, eye);
    const Colour colour = detector_colour("best");
    cv::Mat mask;
    cv::inRange(panel, cv::Scalar(colour.blue, colour.green, colour.red),
                cv::Scalar(colour.blue, colour.green, colour.red), mask);
    return cv::moments(mask, true).m01 / std::max(1.0, cv::moments(mask, true).m00);
  };
  EXPECT_NEAR(row_of_circle(moved) - row_of_circle(enlarged), 30.0, 6.0);
  mouse(x, y, "click --repeat 2 --delay 60 1");
  mouse(layout.plots.x + 5, layout.plots.y + 5, "sleep 0.1");
  EXPECT_TRUE(same(first, screenshot(), layout.eye)) << "all of the image again";

  std::string up;  // to 0.385542 * 1.1^10 = 0.99999, the last step below the largest threshold, 1
  for (int i = 0; i < 30; ++i) up += "bracketright ";
  press(up);
  const cv::Mat strict = screenshot();
  EXPECT_EQ(pixels_of_first_detector(strict), 0) << "no score reaches the threshold";
  EXPECT_FALSE(same(first, strict, layout.settings)) << "the slider follows";

  press("2");
  const cv::Mat other = screenshot();
  EXPECT_FALSE(same(strict, other, layout.hough)) << "the other detector's Hough space";
  EXPECT_TRUE(same(strict, other, layout.scene));
  quit();
  EXPECT_THAT(bytes_of(path("output")), HasSubstr("drew the window"));
}

/// A playback of a run folder with the run's own detectors, of which one that has a Hough space is selected.
std::unique_ptr<Playback> playback_of(const fs::path& run) {
  ReadOptions options;
  options.recording = run;
  options.formats = built_in_formats();
  const auto own = read_recorded_detectors(run, {}, built_in_detectors());
  return make_recording_playback(options, {}, own->detectors, "paper_directed", built_in());
}

Snapshot snapshot_at(Playback& playback, std::int64_t t_us) {
  while (playback.history().now_us() < t_us && playback.tick()) {
  }
  Snapshot snapshot;
  playback.fill(snapshot);
  return snapshot;
}

/// Compares all but the Hough spaces.
void expect_same_instant(const Snapshot& a, const Snapshot& b) {
  EXPECT_EQ(a.now_us, b.now_us);
  EXPECT_EQ(a.events, b.events);
  ASSERT_EQ(a.outputs.size(), b.outputs.size());
  for (std::size_t i = 0; i < a.outputs.size(); ++i) {
    const DetectorTick& left = a.outputs[i].tick;
    const DetectorTick& right = b.outputs[i].tick;
    EXPECT_EQ(a.outputs[i].name, b.outputs[i].name);
    EXPECT_EQ(left.observed, right.observed) << a.outputs[i].name;
    EXPECT_EQ(left.at_threshold, right.at_threshold) << a.outputs[i].name;
    if (!left.observed || !right.observed) continue;
    EXPECT_EQ(left.estimate.score, right.estimate.score) << a.outputs[i].name;
    EXPECT_EQ(left.estimate.circle.x_px, right.estimate.circle.x_px) << a.outputs[i].name;
  }
  ASSERT_EQ(a.samples.size(), b.samples.size());
  const auto same = [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  for (std::size_t i = 0; i < a.samples.size(); ++i) {
    const PlotSample& x = a.samples[i];
    const PlotSample& y = b.samples[i];
    EXPECT_EQ(x.t_us, y.t_us);
    EXPECT_TRUE(same(x.events, y.events) && same(x.truth_px[0], y.truth_px[0]) &&
                same(x.detected_px[1], y.detected_px[1]) && same(x.score, y.score) &&
                same(x.gaze_error_deg, y.gaze_error_deg) && same(x.joints_deg[5], y.joints_deg[5]))
        << x.t_us;
  }
}

TEST(RunPlayback, AJumpShowsWhatPlayingUpToTheInstantShowsFromTheTablesOfTheRun) {
  const TempFolder folder;
  const fs::path run = folder / "run";
  const Outcome made = run_shell("'" + binary + "' run '" + scenarios +
                                 "gaze_square_45cm.yaml' --set run.duration_s=1.6 --set output.pictures=0 "
                                 "--set expect={} --out '" +
                                 run.string() + "'");
  ASSERT_EQ(made.status, 0) << made.text;
  constexpr std::int64_t t_us = 1'500'000;
  const auto played = playback_of(run);
  const Snapshot expected = snapshot_at(*played, t_us);
  ASSERT_TRUE(expected.outputs[0].tick.observed);

  const auto jumped = playback_of(run);
  jumped->restore_before(t_us);
  EXPECT_EQ(jumped->history().now_us(), jumped->history().start_us()) << "4 s before, or the start";
  expect_same_instant(snapshot_at(*jumped, t_us), expected);
  EXPECT_FALSE(snapshot_at(*jumped, t_us).hough.empty());
  expect_same_instant(snapshot_at(*jumped, t_us + 50'000), snapshot_at(*played, t_us + 50'000));
  jumped->restore_before(t_us);  // a step back begins at the checkpoint of the jump
  EXPECT_GE(jumped->history().now_us(), t_us - Checkpoints::first_spacing_us);
  expect_same_instant(snapshot_at(*jumped, t_us), expected);

  // The estimates are the table's, whatever the detectors find.
  std::vector<DetectionRow> rows = read_table<DetectionRow>(run / "detections.csv");
  for (DetectionRow& row : rows) row.score *= 0.5;
  TableWriter<DetectionRow> table(run / "detections.csv");
  for (const DetectionRow& row : rows) table.write(row);
  table.commit();
  const auto halved = playback_of(run);
  halved->restore_before(t_us);
  EXPECT_EQ(snapshot_at(*halved, t_us).outputs[0].tick.estimate.score,
            0.5 * expected.outputs[0].tick.estimate.score);

  // A detector of other settings processes the events.
  ViewSettings settings = halved->settings();
  settings.detectors.pop_back();
  settings.selected = 0;
  halved->apply(settings);
  halved->restore_before(t_us);
  const DetectorOutput live = snapshot_at(*halved, t_us).outputs.at(0);
  EXPECT_TRUE(live.tick.at_threshold);
  EXPECT_NEAR(live.tick.estimate.circle.x_px, expected.outputs[0].tick.estimate.circle.x_px, 1.0);
}

TEST_F(ViewWindow, PlaysAScenarioAndWritesAVideo) {
  open("view '" + scenarios + "look_at_ball.yaml' --paused --pictures '" + path("pictures") + "'");
  press("shift+Right");
  const cv::Mat start = screenshot();
  press("v");
  press("space");
  cv::Mat later;
  // Until the playback has moved on and 5 images of the video are due.
  const auto filming = std::chrono::steady_clock::now();
  ASSERT_TRUE(until([&] {
    later = screenshot();
    return shot_us() > 10'000 && std::chrono::steady_clock::now() - filming > std::chrono::milliseconds(400);
  }));
  press("space");
  press("v");
  later = screenshot();
  EXPECT_FALSE(same(start, later, layout.eye));
  EXPECT_FALSE(same(start, later, layout.plots));
  quit();
  cv::VideoCapture film(path("pictures/look_at_ball.mp4"));
  ASSERT_TRUE(film.isOpened());
  EXPECT_GE(film.get(cv::CAP_PROP_FRAME_COUNT), 5);
  cv::Mat frame;
  ASSERT_TRUE(film.read(frame));
  EXPECT_EQ(frame.size(), cv::Size(1280, 720));
  EXPECT_GT(cv::mean(frame)[0], 10.0);
}

TEST_F(ViewWindow, SavesTheSettingsAsAScenarioThatRunsAndAsksBeforeEscClosesIt) {
  open("view '" + scenarios + "look_at_ball.yaml' --paused --pictures '" + path("pictures") + "'");
  press("shift+Right");
  screenshot();
  press("2 bracketleft w");  // the second detector drives, with a lower threshold
  const std::string saved = path("pictures/look_at_ball_saved.yaml");
  ASSERT_TRUE(until([&] { return fs::exists(saved); })) << bytes_of(path("output"));
  EXPECT_THAT(bytes_of(saved), HasSubstr("detector: paper_full"));
  const Outcome run =
      run_shell("'" + binary + "' run '" + saved +
                "' --set run.duration_s=0.05 --set output.pictures=0 --set expect={} --out " + path("run"));
  EXPECT_EQ(run.status, 0) << run.text;
  press("Escape");
  screenshot();  // the window is still there, and shows the question
  press("Escape Return");
  screenshot();
  press("Escape Return");
  EXPECT_EQ(end_of(child_), 0) << bytes_of(path("output"));
  child_ = 0;
}

TEST_F(ViewWindow, ARunBesideTheWindowWritesTheSameFilesAndOutlivesTheWindow) {
  const std::string run =
      "'" + scenarios +
      "look_at_ball.yaml' --set run.duration_s=1.5 --set output.pictures=0 --set expect={} "
      "--seed 3 --out ";
  ASSERT_EQ(run_shell(display_->in_shell("'" + binary + "' run " + run + path("alone"))).status, 0);
  open("run --view " + run + path("viewed"));
  press("q");
  EXPECT_TRUE(until([&] { return xdotool("search --name 'saccade view'").status != 0; })) << "it closes";
  EXPECT_EQ(end_of(child_), 0) << bytes_of(path("output"));
  child_ = 0;
  for (const char* file :
       {"events.aedat", "detections.csv", "gaze.csv", "truth.csv", "joints.csv", "eye.csv"}) {
    const std::string alone = bytes_of(folder_ / "alone" / file);
    EXPECT_GT(alone.size(), 100U) << file;
    EXPECT_TRUE(alone == bytes_of(folder_ / "viewed" / file)) << file << " differs";
  }
  EXPECT_TRUE(fs::exists(path("viewed/report.html")));
}

TEST_F(ViewWindow, AnOwnDetectorThatDoesNotLoadIsReportedAndTheWindowGoesOn) {
  folder_.write("mine.py",
                "class Raises:\n    def __init__(self, size):\n        raise ValueError('no')\n"
                "class Mine:\n    threshold = 0.5\n    def __init__(self, size): pass\n"
                "    def process(self, events, motion): pass\n    def estimate(self): return None\n");
  open("view '" + scenarios + "look_at_ball.yaml' --paused --set render.supersampling=1 --pictures '" +
       path("pictures") + "'");
  press("shift+Right");
  const cv::Mat before = screenshot();
  const auto enter = [&](const std::string& detector) {
    // A key counts in a field if an image is drawn while it is down; a busy machine draws for half a second.
    mouse(layout.settings.x + 0.5F * layout.settings.width, layout.settings.y + 66.0F, "click 1 sleep 2");
    xdotool("type --delay 5 '" + path(detector) + "'");
    xdotool("sleep 2 keydown Return sleep 1 keyup Return sleep 2");
    mouse(layout.scene.x + 20.0F, layout.scene.y + 40.0F, "sleep 1");
    return screenshot();
  };
  for (const std::string detector : {"mine.py:Mien", "mine.py:Raises"}) {
    const cv::Mat after = enter(detector);
    EXPECT_TRUE(same(before, after, layout.detectors)) << detector << ": the list is as before";
    EXPECT_FALSE(same(before, after, layout.settings)) << detector << ": the reason";
  }
  press("shift+Right");
  const cv::Mat later = screenshot();
  EXPECT_FALSE(same(before, later, layout.plots)) << "it goes on";
  EXPECT_FALSE(same(before, enter("mine.py:Mine"), layout.detectors)) << "one more in the list";
  quit();
  const std::string output = bytes_of(path("output"));
  EXPECT_THAT(output, HasSubstr("drew the window"));
}

TEST_F(ViewWindow, TheShippedScenarioWithoutDetectorsOpensAndAcceptsEveryKey) {
  open("view '" + scenarios + "calibrate_left.yaml' --paused --pictures '" + path("pictures") + "'");
  press("shift+Right bracketright bracketleft 1 2 c i h h");
  EXPECT_EQ(screenshot().size(), cv::Size(1280, 720));
  quit();
}

TEST_F(ViewWindow, AResizedWindowShowsAScenarioAfterTwoRestarts) {
  open("view '" + scenarios + "look_at_ball.yaml' --paused --set render.supersampling=1 --pictures '" +
       path("pictures") + "'");
  for (int i = 0; i < 3; ++i) {
    press("shift+Right");
    screenshot();
    press("Home");
    screenshot();
  }
  ASSERT_EQ(xdotool("search --name 'saccade view' windowsize --sync 1100 660").status, 0);
  ASSERT_TRUE(until([&] { return screenshot().size() == cv::Size(1100, 660); }));
  quit();
}

TEST_F(ViewWindow, ARunThatFailsClosesItsWindowAndReportsTheError) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "the limit of a file's size ends programs with the thread sanitizer";
#endif
  // A file may have 64 blocks of 1024 bytes; writing more fails.
  const std::string command = "run --view '" + scenarios +
                              "look_at_ball.yaml' --set expect={} --set output.pictures=0 "
                              "--set render.supersampling=1 --out '" +
                              path("run") + "'";
  child_ = start("bash -c \"trap '' XFSZ; ulimit -f 64; exec env " +
                 display_->in_shell("'" + binary + "' " + command) + " >'" + path("output") + "' 2>&1\"");
  EXPECT_EQ(end_of(child_), 1) << bytes_of(path("output"));
  child_ = 0;
  EXPECT_THAT(bytes_of(path("output")), HasSubstr("saccade: "));
}

TEST_F(ViewWindow, TheWindowCanBeClosedBeforeThePlaybackHasBeenMade) {
  setenv("DISPLAY", display_->name().c_str(), 1);
  std::promise<void> closed;
  View view("slow", path("pictures"), built_in().detectors);
  PlayerThread player(
      [&]() -> std::unique_ptr<Playback> {
        closed.get_future().wait();
        throw InputError("recording", "this one", "another one");
      },
      true);
  std::thread user([&] {
    EXPECT_TRUE(until([&] { return xdotool("search --name 'saccade view' windowfocus key q").status == 0; }));
  });
  view.show(player);  // returns although the playback is still being made
  user.join();
  closed.set_value();
}

TEST(ViewCommand, WithoutADisplayTheErrorNamesTheRemedy) {
  for (const std::string what : {"view ", "run --view "}) {
    const Outcome outcome = run_shell("env -u DISPLAY -u WAYLAND_DISPLAY '" + binary + "' " + what + "'" +
                                      scenarios + "look_at_ball.yaml'");
    EXPECT_EQ(outcome.status, 2);
    EXPECT_THAT(outcome.text, HasSubstr("DISPLAY: found not set"));
    EXPECT_THAT(outcome.text, HasSubstr("xvfb-run"));
  }
}

}  // namespace
}  // namespace saccade
