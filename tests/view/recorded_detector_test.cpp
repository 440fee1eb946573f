#include "apps/view/recorded_detector.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/hough/hough_detector.h"
#include "recording/run_files.h"
#include "tests/core/streams.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

constexpr ImageSize image{128, 128};
constexpr streams::MovingDisc disc{30, 50, 200, 60, 20};

std::unique_ptr<Detector> hough() { return std::make_unique<HoughDetector>(HoughDetectorConfig{}, image); }

std::shared_ptr<const RecordedEstimates> recorded() {
  return std::make_shared<RecordedEstimates>(
      RecordedEstimates{{100'000, {1.0, 2.0, 3.0}, 0.5, false}, {102'000, {4.0, 5.0, 6.0}, 0.25, true}});
}

void run(Detector& detector, std::int64_t until_us) {
  const std::vector<Event> events = disc.events(image, 1e-6 * static_cast<double>(until_us));
  detector.process(events, nullptr);
  detector.advance_to(until_us, nullptr);
}

TEST(RecordedDetector, EstimatesWhatTheRunRecordedAtEachInstantAndNothingElsewhere) {
  RecordedDetector detector(recorded(), hough(), 0);
  run(detector, 100'000);
  const Estimate first = detector.estimate();
  EXPECT_TRUE(first.valid);
  EXPECT_FALSE(first.held);
  EXPECT_EQ(first.circle.x_px, 1.0);
  EXPECT_EQ(first.circle.r_px, 3.0);
  EXPECT_EQ(first.score, 0.5);
  detector.advance_to(101'000, nullptr);
  EXPECT_FALSE(detector.estimate().valid);
  const std::unique_ptr<Detector> copy = copy_of(detector);
  for (Detector* each : {static_cast<Detector*>(&detector), copy.get()}) {
    EXPECT_FALSE(each->estimate().valid);
    each->advance_to(102'000, nullptr);
    EXPECT_TRUE(each->estimate().held);
    EXPECT_EQ(each->estimate().circle.y_px, 5.0);
    EXPECT_EQ(each->threshold(), hough()->threshold());
  }
  RecordedDetector none(nullptr, hough(), 0);
  run(none, 100'000);
  EXPECT_FALSE(none.estimate().valid);
}

TEST(RecordedDetector, HasTheHoughSpaceOfTheDetectorThatGotTheEventsSinceThen) {
  std::vector<float> expected(static_cast<std::size_t>(image.pixels()));
  std::vector<float> response(expected.size());
  const std::unique_ptr<Detector> plain = hough();
  RecordedDetector detector(recorded(), hough(), 50'000);
  std::vector<Event> events = disc.events(image, 0.1);
  detector.process(events, nullptr);
  std::erase_if(events, [](const Event& event) { return event.t_us < 50'000; });
  plain->process(events, nullptr);
  for (Detector* each : {static_cast<Detector*>(&detector), plain.get()}) {
    each->advance_to(100'000, nullptr);
    static_cast<void>(each->estimate());
  }
  ASSERT_TRUE(hough_space_of(*plain, expected));
  ASSERT_TRUE(hough_space_of(detector, response));
  EXPECT_EQ(response, expected);
  EXPECT_GT(*std::ranges::max_element(response), 0.0F);
}

TEST(RecordedDetector, EstimatesAreThoseOfEachDetectorInTheTable) {
  const TempFolder folder;
  EXPECT_TRUE(read_estimates(folder / "").empty());
  TableWriter<DetectionRow> table(folder / "detections.csv");
  table.write({1'000, "best", {1.0, 2.0, 3.0}, 0.5, false});
  table.write({1'000, "paper_full", {4.0, 5.0, 6.0}, 0.75, false});
  table.write({2'000, "best", {7.0, 8.0, 9.0}, 1.0, true});
  table.commit();
  const auto estimates = read_estimates(folder / "");
  ASSERT_EQ(estimates.size(), 2U);
  ASSERT_EQ(estimates.at("best")->size(), 2U);
  EXPECT_EQ(estimates.at("best")->back().t_us, 2'000);
  EXPECT_EQ(estimates.at("best")->back().circle.r_px, 9.0);
  EXPECT_TRUE(estimates.at("best")->back().held);
  EXPECT_EQ(estimates.at("paper_full")->front().score, 0.75);
  folder.write("detections.csv", "t_us,detector\n");
  EXPECT_THROW(static_cast<void>(read_estimates(folder / "")), InputError);
}

}  // namespace
}  // namespace saccade
