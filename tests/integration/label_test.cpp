// The window of `saccade label` on a virtual display: circles placed with mouse and keys, written, and loaded again.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/view/label_layout.h"
#include "recording/event_file.h"
#include "recording/run_files.h"
#include "tests/core/streams.h"
#include "tests/integration/window_test.h"

namespace saccade {
namespace {

using testing::HasSubstr;

class LabelWindowTest : public WindowTest {
 protected:
  static constexpr ImageSize image_{128, 128};
  static constexpr streams::MovingDisc disc_{30, 50, 200, 60, 20};
  const LabelLayout layout_{1280, 720};

  void SetUp() override {
    WindowTest::SetUp();
    const auto writer = create_event_file(path("disc.aedat4"), image_);
    writer->write(std::vector{streams::event_at(0, 127, 127, true)});  // time starts at 0
    writer->write(disc_.events(image_, 0.4));
    writer->commit();
  }
  void open(const std::string& options = "") {
    open_window("label '" + path("disc.aedat4") + "' --out '" + path("truth.csv") + "' --pictures '" +
                    path("pictures") + "' " + options,
                "saccade label");
  }
  /// Does `then` with the mouse at a pixel of the recording's image.
  void at_pixel(double x_px, double y_px, const std::string& then) const {
    const Area at = ViewLayout::fit(layout_.image, image_);
    const float scale = at.width / static_cast<float>(image_.width);
    mouse(at.x + scale * static_cast<float>(x_px + 0.5), at.y + scale * static_cast<float>(y_px + 0.5), then);
  }
  /// Saves, and waits for the rows.
  [[nodiscard]] std::vector<TruthRow> saved() {
    std::filesystem::remove(path("truth.csv"));
    press("w");
    EXPECT_TRUE(until([&] { return std::filesystem::exists(path("truth.csv")); }))
        << bytes_of(path("output"));
    return read_table<TruthRow>(path("truth.csv"));
  }
};

TEST_F(LabelWindowTest, ARecordingBecomesABenchmarkWithTheMouse) {
  open("--step-ms 50");
  for (const std::int64_t t_us : {100'000, 300'000}) {
    press(t_us == 100'000 ? "Right Right" : "Right Right Right Right");
    at_pixel(disc_.x_at(t_us), disc_.y_at(t_us), "mousedown 1 sleep 0.1 mouseup 1");
    screenshot();  // the click has taken effect
  }
  press("Left Left Return");  // the hint halfway becomes a label
  std::vector<TruthRow> rows = saved();
  ASSERT_EQ(rows.size(), 3u);
  for (const TruthRow& row : rows) {
    EXPECT_NEAR(row.circle.x_px, disc_.x_at(row.t_us), 0.5) << row.t_us;
    EXPECT_NEAR(row.circle.y_px, disc_.y_at(row.t_us), 0.5) << row.t_us;
    EXPECT_DOUBLE_EQ(row.circle.r_px, 12.8) << "a tenth of the image, where no circle was before";
    EXPECT_EQ(row.visible, 1.0);
  }
  EXPECT_EQ(rows[1].t_us, 200'000);
  EXPECT_NEAR(rows[1].circle.x_px, 0.5 * (rows[0].circle.x_px + rows[2].circle.x_px), 0.006);

  // The outline is dragged out to the disc's; wheel and keys change the radius too.
  const Circle now = rows[1].circle;
  at_pixel(now.x_px + now.r_px, now.y_px, "mousedown 1 sleep 0.1");
  at_pixel(now.x_px + disc_.r_px, now.y_px, "sleep 0.1 mouseup 1");
  screenshot();
  rows = saved();
  EXPECT_NEAR(rows[1].circle.r_px, disc_.r_px, 0.5);
  const double dragged_px = rows[1].circle.r_px;
  at_pixel(now.x_px, now.y_px, "click 4");  // the wheel upwards
  press("bracketright bracketright shift+bracketleft");
  screenshot();
  rows = saved();
  EXPECT_NEAR(rows[1].circle.r_px, dragged_px + 0.5 + 1.0 - 0.1, 0.006);
  quit();  // all is saved: nothing is asked
  EXPECT_THAT(bytes_of(path("output")), HasSubstr("truth.csv: 3 instants"));

  const Outcome info = run_shell("'" SACCADE_BINARY "' detect '" + path("disc.aedat4") + "' --truth '" +
                                 path("truth.csv") + "' --set radius_px=[8,25] --json");
  EXPECT_EQ(info.status, 0) << info.text;
  EXPECT_THAT(info.text, HasSubstr("\"chances\": 3"));
}

TEST_F(LabelWindowTest, EveryClickPlacesTheCircleAlsoInsideTheHint) {
  open("--step-ms 20");
  for (std::int64_t t_us = 20'000; t_us <= 100'000; t_us += 20'000) {
    // The ball moves by 4.2 px in 20 ms; the hint has a radius of 12.8 px.
    press("Right");
    screenshot();  // the instant is there
    at_pixel(disc_.x_at(t_us), disc_.y_at(t_us),
             t_us == 40'000 ? "click 1" : "mousedown 1 sleep 0.1 mouseup 1");
    screenshot();
  }
  const std::vector<TruthRow> rows = saved();
  ASSERT_EQ(rows.size(), 5u);
  for (const TruthRow& row : rows) {
    EXPECT_NEAR(row.circle.x_px, disc_.x_at(row.t_us), 0.5) << row.t_us;
    EXPECT_NEAR(row.circle.y_px, disc_.y_at(row.t_us), 0.5) << row.t_us;
    EXPECT_DOUBLE_EQ(row.circle.r_px, 12.8) << row.t_us;
  }
  quit();
}

TEST_F(LabelWindowTest, PlaysAndFitsTheCircleToTheEdges) {
  open("--step-ms 50");
  press("space");
  EXPECT_TRUE(until([&] {
    screenshot();
    return shot_us() > 20'000;
  }));
  press("space");
  screenshot();
  const std::int64_t paused_us = shot_us();
  screenshot();
  EXPECT_EQ(shot_us(), paused_us);

  press("Home Right Right Right Right");
  at_pixel(disc_.x_at(200'000) + 3.0, disc_.y_at(200'000) - 2.0, "mousedown 1 sleep 0.1 mouseup 1");
  press(std::string("bracketright bracketright bracketright bracketright bracketright bracketright ") +
        "bracketright bracketright bracketright bracketright bracketright bracketright f");
  screenshot();
  const std::vector<TruthRow> rows = saved();
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].t_us, 200'000);
  EXPECT_NEAR(rows[0].circle.x_px, disc_.x_at(200'000), 0.3);
  EXPECT_NEAR(rows[0].circle.y_px, disc_.y_at(200'000), 0.3);
  EXPECT_NEAR(rows[0].circle.r_px, disc_.r_px, 0.3);
  quit();
}

TEST_F(LabelWindowTest, ATableThatExistsIsRefusedAndWithForceTheWorkGoesOn) {
  TableWriter<TruthRow> table(path("truth.csv"));
  table.write({100'000, {40.0, 60.0, 15.0}, 1.0, Eigen::Vector3d::Zero()});
  table.commit();
  const Outcome refused = run_shell(display_->in_shell("'" SACCADE_BINARY "' label '" + path("disc.aedat4") +
                                                       "' --out '" + path("truth.csv") + "'"));
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.text, HasSubstr("--force to go on with its circles"));

  open("--force --step-ms 10");
  press("Right Right Return x");  // at 120 ms; the ball is hidden there
  press("Right Return");
  screenshot();
  press("Escape");  // asks
  screenshot();
  press("Return");  // saves and closes
  EXPECT_EQ(end_of(child_), 0) << bytes_of(path("output"));
  child_ = 0;
  const auto rows = read_table<TruthRow>(path("truth.csv"));
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].circle.r_px, 15.0);
  EXPECT_EQ(rows[1].t_us, 120'000);
  EXPECT_EQ(rows[1].visible, 0.0);
}

TEST_F(LabelWindowTest, QuittingAsksWhereAChangeIsNotSavedAndAnInterruptSavesIt) {
  open();
  at_pixel(60, 60, "mousedown 1 sleep 0.1 mouseup 1");
  screenshot();
  press("q");
  screenshot();  // the window is still there
  EXPECT_FALSE(std::filesystem::exists(path("truth.csv")));
  press("Escape");
  screenshot();
  kill(child_, SIGINT);
  EXPECT_EQ(end_of(child_), 0) << bytes_of(path("output"));
  child_ = 0;
  EXPECT_EQ(read_table<TruthRow>(path("truth.csv")).size(), 1u);
}

}  // namespace
}  // namespace saccade
