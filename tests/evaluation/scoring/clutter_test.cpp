#include "evaluation/scoring/clutter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"

namespace saccade {
namespace {

LabelRow made_by(const std::string& object, const std::string& cause = "signal") {
  LabelRow row;
  row.object = object;
  row.cause = cause;
  return row;
}

TEST(Clutter, SharesAreThoseOfTheLabelsAndSumUpToOne) {
  ClutterCounter counter;
  for (int i = 0; i < 3; ++i) counter.add(made_by("ball"));
  counter.add(made_by("hand"));
  for (int i = 0; i < 4; ++i) counter.add(made_by("background", i == 0 ? "leak" : "signal"));
  const ClutterShare share = counter.share();
  EXPECT_EQ(share.share, 5.0 / 8.0);
  EXPECT_EQ(counter.clutter_events(), 5);
  double objects = 0.0;
  double causes = 0.0;
  for (const auto& [name, part] : share.by_object) objects += *part;
  for (const auto& [name, part] : share.by_cause) causes += *part;
  EXPECT_EQ(objects, 1.0);
  EXPECT_EQ(causes, 1.0);
  EXPECT_EQ(share.by_object.front(), (std::pair<std::string, std::optional<double>>("ball", 3.0 / 8.0)));
  EXPECT_EQ(share.by_cause[1], (std::pair<std::string, std::optional<double>>("leak", 1.0 / 8.0)));
}

TEST(Clutter, WithoutEventsThereIsNoShare) {
  const ClutterCounter counter;
  EXPECT_EQ(counter.share().share, std::nullopt);
  EXPECT_TRUE(std::isnan(counter.share_in_window()));
}

TEST(Clutter, TheWindowHoldsTheNewestEventsAlone) {
  ClutterCounter counter;
  for (std::size_t i = 0; i < 500; ++i) counter.add(made_by("ball"));
  EXPECT_EQ(counter.share_in_window(), 0.0);
  for (std::size_t i = 0; i < 500; ++i) counter.add(made_by("arm"));
  EXPECT_EQ(counter.share_in_window(), 0.5);
  for (std::size_t i = 0; i < ClutterCounter::window_events; ++i) counter.add(made_by("arm"));
  EXPECT_EQ(counter.share_in_window(), 1.0);
}

TEST(Clutter, AnUnknownCauseOrObjectIsRejected) {
  ClutterCounter counter;
  EXPECT_THROW(counter.add(made_by("cat")), InputError);
  EXPECT_THROW(counter.add(made_by("ball", "magic")), InputError);
}

TEST(Clutter, IsAveragedApartForChancesWithAndWithoutADetection) {
  const auto at = [](std::int64_t t_us, double visible) {
    TruthRow row;
    row.t_us = t_us;
    row.visible = visible;
    return row;
  };
  const std::vector<TruthRow> truth = {at(1000, 1), at(2000, 1), at(3000, 0.2), at(4000, 1), at(5000, 0.6)};
  const std::vector<double> share = {std::nan(""), 0.9, 0.1, 0.5, 0.7};
  const std::vector<DetectionRow> detections = {{1000, "a", {}, 0.9, false},
                                                {2000, "a", {}, 0.2, false},
                                                {2000, "b", {}, 0.9, false},
                                                {3000, "a", {}, 0.9, false},
                                                {4000, "a", {}, 0.3, false}};
  const DetectorClutter a = detector_clutter(truth, share, detections, "a", 0.3, 700, 7);
  EXPECT_EQ(a.in_window_detected, 0.5);
  EXPECT_EQ(a.in_window_missed, (0.9 + 0.7) / 2.0);
  EXPECT_EQ(a.per_detection, 100.0);
  const DetectorClutter none = detector_clutter(truth, share, detections, "c", 0.3, 700, 0);
  EXPECT_EQ(none.in_window_detected, std::nullopt);
  EXPECT_EQ(none.per_detection, std::nullopt);
}

}  // namespace
}  // namespace saccade
