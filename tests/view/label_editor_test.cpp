// Circles that a person places at instants of a recording, without the window.
#include "apps/view/label_editor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "apps/view/circle_labels.h"
#include "core/error.h"
#include "tests/core/streams.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

CircleLabels labels_at_10_and_20_ms() {
  CircleLabels labels;
  labels.place(20'000, {50.0, 40.0, 8.0});
  labels.place(10'000, {30.0, 20.0, 4.0});
  return labels;
}

void expect_circle(const std::optional<Circle>& circle, double x_px, double y_px, double r_px) {
  ASSERT_TRUE(circle.has_value());
  EXPECT_DOUBLE_EQ(circle->x_px, x_px);
  EXPECT_DOUBLE_EQ(circle->y_px, y_px);
  EXPECT_DOUBLE_EQ(circle->r_px, r_px);
}

TEST(CircleLabels, TheHintBetweenTwoInstantsIsOnTheLineBetweenTheirCircles) {
  const CircleLabels labels = labels_at_10_and_20_ms();
  expect_circle(labels.hint(10'000), 30.0, 20.0, 4.0);
  expect_circle(labels.hint(12'500), 35.0, 25.0, 5.0);
  EXPECT_FALSE(CircleLabels().hint(0).has_value());
}

TEST(CircleLabels, BeyondTheLastInstantTheMotionGoesOnForOneIntervalAndThenStays) {
  const CircleLabels labels = labels_at_10_and_20_ms();
  expect_circle(labels.hint(25'000), 60.0, 50.0, 10.0);
  expect_circle(labels.hint(30'000), 70.0, 60.0, 12.0);
  expect_circle(labels.hint(90'000), 70.0, 60.0, 12.0);
  expect_circle(labels.hint(5'000), 20.0, 10.0, 2.0);
  expect_circle(labels.hint(0), 10.0, 0.0, 0.5);  // a radius stays positive
}

TEST(CircleLabels, ThereIsNoHintNextToAnInstantAtWhichTheBallIsHidden) {
  CircleLabels labels = labels_at_10_and_20_ms();
  labels.hide(30'000);
  EXPECT_FALSE(labels.hint(25'000).has_value());
  EXPECT_FALSE(labels.hint(30'000).has_value());
  EXPECT_FALSE(labels.hint(35'000).has_value());
  expect_circle(labels.hint(15'000), 40.0, 30.0, 6.0);
}

TEST(CircleLabels, AreReadBackAsTheyWereWritten) {
  const TempFolder folder;
  CircleLabels labels = labels_at_10_and_20_ms();
  labels.hide(30'000);
  labels.write(folder / "truth.csv");
  EXPECT_EQ(
      bytes_of(folder / "truth.csv"),
      "t_us,x_px,y_px,r_px,visible,x_m,y_m,z_m\n10000,30,20,4,1,,,\n20000,50,40,8,1,,,\n30000,,,,0,,,\n");
  CircleLabels::read(folder / "truth.csv").write(folder / "again.csv");
  EXPECT_EQ(bytes_of(folder / "again.csv"), bytes_of(folder / "truth.csv"));
}

TEST(CircleLabels, OfATableWithFourColumnsAreReadAndTwoRowsOfOneInstantAreRejected) {
  const TempFolder folder;
  const std::string head = "t_us,x_px,y_px,r_px\n";
  const CircleLabels labels = CircleLabels::read(folder.write("a.csv", head + "5,1,2,3\n9,1,2,3.5\n"));
  ASSERT_EQ(labels.rows().size(), 2u);
  EXPECT_EQ(labels.rows()[1].visible, 1.0);
  EXPECT_THAT([&] { (void)CircleLabels::read(folder.write("b.csv", head + "5,1,2,3\n5,1,2,3\n")); },
              ThrowsMessage<InputError>(HasSubstr("found two rows at 5 us")));
}

class LabelEditorTest : public testing::Test {
 protected:
  static constexpr ImageSize image{128, 100};
  LabelEditor editor_{streams::random(image, 20'000, 1), image, {}};
};

TEST_F(LabelEditorTest, AClickOutsideTheCircleMovesItThereAndKeepsItsRadius) {
  editor_.press(40.0, 30.0);
  editor_.release();
  expect_circle(editor_.circle(), 40.0, 30.0, 10.0);  // a tenth of the image
  editor_.grow(-3.0);
  editor_.press(80.0, 60.0);
  expect_circle(editor_.circle(), 80.0, 60.0, 7.0);
  EXPECT_EQ(editor_.labels().rows().size(), 1u);
}

TEST_F(LabelEditorTest, ADragInsideMovesTheCentreAndADragOfTheOutlineChangesTheRadius) {
  editor_.press(40.0, 30.0);
  editor_.release();
  editor_.press(42.0, 31.0);  // 2.2 px from the centre
  editor_.drag(52.0, 41.0);
  editor_.release();
  expect_circle(editor_.circle(), 50.0, 40.0, 10.0);
  editor_.press(60.0, 40.0);  // on the outline
  editor_.drag(65.0, 40.0);
  editor_.drag(66.0, 40.0);
  editor_.release();
  expect_circle(editor_.circle(), 50.0, 40.0, 16.0);
  editor_.drag(90.0, 90.0);  // nothing is held
  expect_circle(editor_.circle(), 50.0, 40.0, 16.0);
}

TEST_F(LabelEditorTest, AClickInsideACircleOrOnItsOutlineMovesTheCentreToTheClick) {
  editor_.press(40.0, 30.0);
  editor_.release();
  editor_.press(43.0, 28.0);
  editor_.release();
  expect_circle(editor_.circle(), 43.0, 28.0, 10.0);
  editor_.press(53.0, 28.0);  // on the outline
  editor_.release();
  expect_circle(editor_.circle(), 53.0, 28.0, 10.0);
  editor_.undo();
  expect_circle(editor_.circle(), 43.0, 28.0, 10.0);
  editor_.undo();
  expect_circle(editor_.circle(), 40.0, 30.0, 10.0);
}

TEST_F(LabelEditorTest, ClicksInsideTheHintPlaceTheCirclesWhereTheyAre) {
  // A ball that moves by less than its radius from one instant to the next.
  for (int i = 0; i < 6; ++i) {
    editor_.seek(2'000 * (i + 1));
    editor_.press(40.0 + 3.0 * i, 30.0 + i);
    editor_.release();
    EXPECT_TRUE(editor_.labelled());
  }
  ASSERT_EQ(editor_.labels().rows().size(), 6u);
  for (int i = 0; i < 6; ++i)
    expect_circle(editor_.labels().rows()[static_cast<std::size_t>(i)].circle, 40.0 + 3.0 * i, 30.0 + i,
                  10.0);
}

TEST_F(LabelEditorTest, ADragInsideTheHintMovesItByAsMuchAsTheMouse) {
  editor_.press(40.0, 30.0);
  editor_.release();
  editor_.seek(20'000);
  editor_.press(43.0, 28.0);
  EXPECT_FALSE(editor_.labelled());
  editor_.drag(53.0, 48.0);
  editor_.release();
  EXPECT_TRUE(editor_.labelled());
  expect_circle(editor_.circle(), 50.0, 50.0, 10.0);
}

TEST_F(LabelEditorTest, APressThatASeekEndsPlacesNothing) {
  editor_.press(40.0, 30.0);
  editor_.release();
  editor_.press(42.0, 30.0);
  editor_.seek(20'000);
  editor_.release();
  EXPECT_FALSE(editor_.labelled());
  ASSERT_EQ(editor_.labels().rows().size(), 1u);
  expect_circle(editor_.labels().rows().front().circle, 40.0, 30.0, 10.0);
}

TEST_F(LabelEditorTest, AtAnotherInstantTheCircleIsAHintUntilItIsAccepted) {
  editor_.press(40.0, 30.0);
  editor_.seek(20'000);
  expect_circle(editor_.circle(), 40.0, 30.0, 10.0);
  EXPECT_FALSE(editor_.labelled());
  editor_.accept_hint();
  EXPECT_TRUE(editor_.labelled());
  editor_.move(4.0, 0.0);
  editor_.seek(10'000);
  ASSERT_TRUE(editor_.circle());
  EXPECT_NEAR(editor_.circle()->x_px, 42.0, 0.01) << "halfway, but for the first event's few us";
  EXPECT_EQ(editor_.labels().rows().size(), 2u);
  editor_.seek_next_label();
  EXPECT_EQ(editor_.now_us(), 20'000);
  editor_.seek_previous_label();
  EXPECT_EQ(editor_.now_us(), editor_.first_us());
}

TEST_F(LabelEditorTest, UndoTakesBackDragsMarksAndRemovalsOneByOne) {
  editor_.press(40.0, 30.0);
  editor_.drag(41.0, 30.0);
  editor_.drag(44.0, 30.0);
  editor_.release();
  editor_.toggle_hidden();
  EXPECT_TRUE(editor_.hidden());
  editor_.toggle_hidden();
  EXPECT_FALSE(editor_.labelled());
  editor_.undo();
  EXPECT_TRUE(editor_.hidden());
  editor_.undo();
  expect_circle(editor_.circle(), 44.0, 30.0, 10.0);
  editor_.remove();
  editor_.seek(15'000);
  editor_.undo();
  EXPECT_EQ(editor_.now_us(), editor_.first_us());  // where the change was
  expect_circle(editor_.circle(), 44.0, 30.0, 10.0);
  editor_.undo();
  EXPECT_TRUE(editor_.labels().rows().empty());
  editor_.undo();  // nothing is left
}

TEST_F(LabelEditorTest, IsUnsavedFromAChangeUntilItIsMarkedAsSaved) {
  EXPECT_FALSE(editor_.unsaved());
  editor_.seek(9'000);
  editor_.grow(1.0);  // no circle to grow
  EXPECT_FALSE(editor_.unsaved());
  editor_.press(40.0, 30.0);
  EXPECT_TRUE(editor_.unsaved());
  editor_.mark_saved();
  EXPECT_FALSE(editor_.unsaved());
  editor_.undo();
  EXPECT_TRUE(editor_.unsaved());
}

TEST_F(LabelEditorTest, TimeAndRadiusStayInTheirRanges) {
  editor_.seek(-5);
  EXPECT_EQ(editor_.now_us(), editor_.first_us());
  editor_.seek(std::int64_t{1} << 60);
  EXPECT_EQ(editor_.now_us(), editor_.last_us());
  editor_.press(40.0, 30.0);
  editor_.grow(-1000.0);
  EXPECT_DOUBLE_EQ(editor_.circle()->r_px, 0.5);
  editor_.grow(1000.0);
  EXPECT_DOUBLE_EQ(editor_.circle()->r_px, 128.0);
}

TEST_F(LabelEditorTest, PlaybackGoesOnByTheWallClockTimesTheSpeedUntilTheLastEvent) {
  editor_.advance(1.0);
  EXPECT_EQ(editor_.now_us(), editor_.first_us()) << "paused";
  editor_.toggle_playing();
  EXPECT_DOUBLE_EQ(editor_.speed(), 0.1);
  editor_.advance(0.05);
  EXPECT_EQ(editor_.now_us(), editor_.first_us() + 5'000);
  EXPECT_TRUE(editor_.playing());
  for (int i = 0; i < 9; ++i) editor_.change_speed(1);
  EXPECT_DOUBLE_EQ(editor_.speed(), 2.0);
  EXPECT_EQ(editor_.speed_text(), "2");
  editor_.advance(0.001);
  EXPECT_EQ(editor_.now_us(), editor_.first_us() + 7'000);
  for (int i = 0; i < 9; ++i) editor_.change_speed(-1);
  EXPECT_DOUBLE_EQ(editor_.speed(), 0.05);
  EXPECT_EQ(editor_.speed_text(), "1/20");
  editor_.advance(1e3);
  EXPECT_EQ(editor_.now_us(), editor_.last_us());
  EXPECT_FALSE(editor_.playing());
  editor_.toggle_playing();
  EXPECT_EQ(editor_.now_us(), editor_.first_us()) << "once more from the start";
  EXPECT_TRUE(editor_.playing());
}

TEST_F(LabelEditorTest, WhateverPlacesACircleOrGoesElsewherePauses) {
  const auto expect_pauses = [&](const auto& act) {
    editor_.toggle_playing();
    EXPECT_TRUE(editor_.playing());
    act();
    EXPECT_FALSE(editor_.playing());
  };
  expect_pauses([&] { editor_.press(40.0, 30.0); });
  editor_.release();
  expect_pauses([&] { editor_.grow(1.0); });
  expect_pauses([&] { editor_.seek(20'000); });
  expect_pauses([&] { editor_.accept_hint(); });
  expect_pauses([&] { editor_.toggle_hidden(); });
  expect_pauses([&] { editor_.undo(); });
  expect_pauses([&] { editor_.seek_previous_label(); });
  expect_pauses([&] { editor_.toggle_playing(); });
  const std::int64_t now_us = editor_.now_us();
  editor_.advance(1.0);
  EXPECT_EQ(editor_.now_us(), now_us);
}

TEST(LabelEditor, SnapsTheCircleOrTheHintToTheEdgesAndUndoTakesItBack) {
  const streams::MovingDisc disc{30, 40, 200, 60, 12};
  LabelEditor editor(disc.events({128, 100}, 0.2), {128, 100}, {});
  editor.seek(100'000);
  EXPECT_FALSE(editor.snap()) << "no circle";
  EXPECT_FALSE(editor.unsaved());
  const auto expect_disc = [&] {
    ASSERT_TRUE(editor.circle());
    EXPECT_TRUE(editor.labelled());
    EXPECT_NEAR(editor.circle()->x_px, disc.x_at(editor.now_us()), 0.3);
    EXPECT_NEAR(editor.circle()->y_px, disc.y_at(editor.now_us()), 0.3);
    EXPECT_NEAR(editor.circle()->r_px, disc.r_px, 0.3);
  };
  editor.press(disc.x_at(100'000) + 2.0, disc.y_at(100'000) - 1.0);
  editor.release();
  const std::optional<Circle> placed = editor.circle();
  EXPECT_TRUE(editor.snap());
  expect_disc();
  editor.undo();
  expect_circle(editor.circle(), placed->x_px, placed->y_px, placed->r_px);
  EXPECT_TRUE(editor.snap());
  editor.seek(110'000);  // the hint is 2.1 px beside the disc
  EXPECT_TRUE(editor.snap());
  expect_disc();
  editor.press(110.0, 90.0);
  editor.release();
  editor.mark_saved();
  EXPECT_FALSE(editor.snap()) << "no edge is there";
  EXPECT_FALSE(editor.unsaved());
}

TEST(LabelEditor, ShowsTheEventsAroundTheInstantEachPixelInThePolarityOfTheNearestOne) {
  LabelEditor editor({streams::event_at(0, 1, 1, true), streams::event_at(9'900, 2, 0, true),
                      streams::event_at(10'050, 2, 0, false), streams::event_at(90'000, 0, 0, true)},
                     {4, 2}, {});
  editor.seek(10'000);
  EXPECT_EQ(editor.shown_events().size(), 2u);
  RgbImage rgb;
  paint_instant(editor, rgb);
  ASSERT_EQ(rgb.size(), 24u);
  const auto pixel = [&](std::size_t i) { return Rgb{rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]}; };
  const Rgb ground = pixel(0);
  for (const std::size_t i : {1, 3, 4, 5, 6, 7}) EXPECT_EQ(pixel(i), ground) << i;
  for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(pixel(2)[c], off_rgb[c], 5) << "the OFF event is nearer";
  editor.scale_reach(3.0);
  EXPECT_EQ(editor.shown_events().size(), 3u);
}

}  // namespace
}  // namespace saccade
