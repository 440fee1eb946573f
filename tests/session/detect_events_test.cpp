#include "session/detect_events.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "head/icub_cameras.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::Pair;
using testing::SizeIs;

/// Reports how many events it got in its last call; from `held_from_us` on it holds that.
class CountingDetector final : public Detector {
 public:
  void process(std::span<const Event> events, const CameraMotion*) override {
    count_ = static_cast<double>(events.size());
    for (const Event& event : events) rejected_.outside_image += event.x >= 128 ? 1 : 0;
  }
  void advance_to(std::int64_t now_us, const CameraMotion*) override { now_us_ = now_us; }
  [[nodiscard]] Estimate estimate() override {
    EXPECT_FALSE(worked_ahead_) << "its owner may ask for the estimate at any time";
    return {true, now_us_ >= held_from_us, {64, 64, 20}, count_};
  }
  void work_ahead() override { worked_ahead_ = true; }
  [[nodiscard]] double threshold() const override { return 0.5; }
  [[nodiscard]] RejectedEvents rejected() const override { return rejected_; }

  std::int64_t held_from_us = std::numeric_limits<std::int64_t>::max();

 private:
  double count_ = 0.0;
  std::int64_t now_us_ = 0;
  bool worked_ahead_ = false;
  RejectedEvents rejected_;
};

std::vector<Event> events_at(std::initializer_list<std::int64_t> times_us) {
  std::vector<Event> events;
  for (const std::int64_t t_us : times_us) events.push_back({t_us, 64, 64, true, 0});
  return events;
}

/// Time and score of each estimate.
std::vector<std::pair<std::int64_t, double>> pairs(const std::vector<TimedEstimate>& estimates) {
  std::vector<std::pair<std::int64_t, double>> result;
  for (const auto& [t_us, estimate] : estimates) result.emplace_back(t_us, estimate.score);
  return result;
}

TEST(DetectEvents, ObservesAtWholeMillisecondsWithEvents) {
  CountingDetector detector;
  const auto events = events_at({-1500, -1200, 100, 900, 1000, 1001, 7000});
  EXPECT_THAT(pairs(detect_events(detector, icub_left_2016, events)),
              ElementsAre(Pair(-1000, 2.0), Pair(1000, 3.0), Pair(2000, 1.0), Pair(7000, 1.0)));
  (void)detector.estimate();
}

TEST(DetectEvents, ObservesHeldEstimatesWithoutEvents) {
  CountingDetector detector;
  detector.held_from_us = 3000;
  EXPECT_THAT(pairs(detect_events(detector, icub_left_2016, events_at({1500, 4500}))),
              ElementsAre(Pair(2000, 1.0), Pair(3000, 0.0), Pair(4000, 0.0), Pair(5000, 1.0)));
}

TEST(DetectEvents, RefusesEventsMoreThanADayApartOrAfterTheStart) {
  constexpr std::int64_t years_us = 1'700'000'000'000'000;
  CountingDetector detector;
  EXPECT_THROW((void)detect_events(detector, icub_left_2016, events_at({0, 1000, years_us})), InputError);
  EXPECT_THROW((void)detect_events(detector, icub_left_2016, events_at({years_us}), 0), InputError);
  EXPECT_THROW(
      (void)detect_events_at(detector, icub_left_2016, events_at({0, years_us}), std::array{years_us}),
      InputError);
  EXPECT_THAT(detect_events(detector, icub_left_2016, events_at({years_us, years_us + 1000})), SizeIs(1))
      << "a late clock is no gap";
}

TEST(DetectEvents, BeginsWhereItIsTold) {
  CountingDetector detector;
  detector.held_from_us = 0;
  EXPECT_THAT(pairs(detect_events(detector, icub_left_2016, events_at({2600}), 300)),
              ElementsAre(Pair(1300, 0.0), Pair(2300, 0.0), Pair(3300, 1.0)));
}

TEST(DetectEvents, AtGivenInstantsCountsTheEventsOfTheTenMillisecondsBefore) {
  CountingDetector detector;
  const std::vector<std::int64_t> instants_us = {40'000, 45'000, 80'000, 99'000};
  const auto events = events_at({1000, 20'000, 31'000, 32'000, 41'000, 60'000, 99'000, 120'000});
  EXPECT_THAT(pairs(detect_events_at(detector, icub_left_2016, events, instants_us)),
              ElementsAre(Pair(40'000, 2.0), Pair(45'000, 1.0), Pair(99'000, 1.0)));
}

TEST(DetectEvents, LeavesEventsThatAreWrongToTheDetector) {
  CountingDetector detector;
  auto events = events_at({500, 600});
  events[1].x = 500;
  EXPECT_THAT(pairs(detect_events(detector, icub_left_2016, events)), ElementsAre(Pair(1000, 2.0)));
  EXPECT_EQ(detector.rejected().outside_image, 1);
}

TEST(DetectEvents, OfNoEventsAreNone) {
  CountingDetector detector;
  const std::vector<std::int64_t> instants_us = {1000};
  EXPECT_THAT(detect_events(detector, icub_left_2016, {}), IsEmpty());
  EXPECT_THAT(detect_events_at(detector, icub_left_2016, {}, instants_us), IsEmpty());
}

TEST(DetectEvents, RefusesEventsOfTwoCameras) {
  CountingDetector detector;
  auto events = events_at({500, 600});
  events[1].camera = 1;
  EXPECT_THAT([&] { (void)detect_events(detector, icub_left_2016, events); },
              testing::ThrowsMessage<InputError>(
                  testing::HasSubstr("events: found cameras 0 and 1, expected events of one camera")));
}

}  // namespace
}  // namespace saccade
