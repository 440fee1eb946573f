#include "evaluation/scoring/scoring.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
#include <set>

#include "core/error.h"
#include "core/random.h"
#include "evaluation/scoring/detector_scorer.h"

namespace saccade {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

TruthRow truth_at(std::int64_t t_us, double x_px, double y_px, double r_px = 20.0, double visible = 1.0) {
  return {.t_us = t_us, .circle = {x_px, y_px, r_px}, .visible = visible};
}

DetectionRow seen_at(std::int64_t t_us, double x_px, double y_px, double r_px, double score) {
  return {.t_us = t_us, .detector = "d", .circle = {x_px, y_px, r_px}, .score = score};
}

/// Truth every millisecond from 1 ms on, along a path in pixels over seconds.
std::vector<TruthRow> truth_along(int count, const std::function<Eigen::Vector2d(double)>& path_px) {
  std::vector<TruthRow> truth;
  for (int i = 1; i <= count; ++i) {
    const Eigen::Vector2d p = path_px(i * 1e-3);
    truth.push_back(truth_at(i * 1000, p.x(), p.y()));
  }
  return truth;
}

Eigen::Vector2d circling(double t_s) {
  const double phase = 2.0 * std::numbers::pi * 2.5 * t_s;
  return {64.0 + 30.0 * std::cos(phase), 64.0 + 20.0 * std::sin(phase)};
}

/// The definitions of the header, spelled out the slow way.
class PlainScorer {
 public:
  PlainScorer(const std::vector<TruthRow>& truth, const std::vector<DetectionRow>& detections)
      : truth_(truth), detections_(detections) {
    for (const TruthRow& row : truth) by_time_[row.t_us] = row;
  }

  [[nodiscard]] bool chance(std::int64_t t_us) const {
    const auto row = by_time_.find(t_us);
    return row != by_time_.end() && row->second.visible >= 0.5 && std::isfinite(row->second.circle.x_px);
  }
  /// A ball that is partly hidden: an observation there is neither right nor wrong.
  [[nodiscard]] bool ignored(std::int64_t t_us) const {
    const auto row = by_time_.find(t_us);
    return row != by_time_.end() && row->second.visible > 0.0 && row->second.visible < 0.5;
  }
  [[nodiscard]] double distance(const DetectionRow& d) const {
    const Circle& c = by_time_.at(d.t_us).circle;
    return std::sqrt(std::pow(c.x_px - d.circle.x_px, 2) + std::pow(c.y_px - d.circle.y_px, 2));
  }
  [[nodiscard]] bool inlier(const DetectionRow& d) const {
    return chance(d.t_us) && distance(d) <= 6.0 &&
           std::abs(by_time_.at(d.t_us).circle.r_px - d.circle.r_px) <= 2.0;
  }
  [[nodiscard]] int chances() const {
    int n = 0;
    for (const TruthRow& row : truth_) n += chance(row.t_us);
    return n;
  }
  [[nodiscard]] double precision(double threshold) const {
    double inliers = 0;
    double all = 0;
    for (const DetectionRow& d : detections_) {
      if (d.score < threshold || ignored(d.t_us)) continue;
      ++all;
      inliers += inlier(d);
    }
    return inliers / all;
  }
  [[nodiscard]] double recall(double threshold) const {
    double inliers = 0;
    for (const DetectionRow& d : detections_) inliers += d.score >= threshold && inlier(d);
    return inliers / chances();
  }
  [[nodiscard]] double average_precision() const {
    double area = 0;
    double last_recall = 0;
    for (const double score : scores()) {
      area += precision(score) * (recall(score) - last_recall);
      last_recall = recall(score);
    }
    return area;
  }
  [[nodiscard]] std::optional<double> precision_at(double wanted) const {
    for (const double score : scores()) {
      if (recall(score) >= wanted) return precision(score);
    }
    return std::nullopt;
  }
  [[nodiscard]] double lag_ms(double threshold) const {
    double best = std::numeric_limits<double>::infinity();
    int best_step = 0;
    for (int step = -500; step <= 2000; ++step) {
      std::vector<double> distances;
      for (const DetectionRow& d : detections_) {
        if (d.score < threshold || !chance(d.t_us) || d.t_us - 200'000 < truth_.front().t_us ||
            d.t_us + 50'000 > truth_.back().t_us) {
          continue;
        }
        const Eigen::Vector2d p = truth_px(d.t_us - step * 100);
        distances.push_back(std::hypot(d.circle.x_px - p.x(), d.circle.y_px - p.y()));
      }
      std::sort(distances.begin(), distances.end());
      const double median = 0.5 * (distances[(distances.size() - 1) / 2] + distances[distances.size() / 2]);
      if (median < best - 1e-12) {
        best = median;
        best_step = step;
      }
    }
    return best_step * 0.1;
  }

 private:
  [[nodiscard]] std::set<double, std::greater<>> scores() const {
    std::set<double, std::greater<>> all;
    for (const DetectionRow& d : detections_) {
      if (!ignored(d.t_us)) all.insert(d.score);
    }
    return all;
  }
  [[nodiscard]] Eigen::Vector2d truth_px(std::int64_t t_us) const {
    const auto after = by_time_.lower_bound(t_us);
    const Eigen::Vector2d b(after->second.circle.x_px, after->second.circle.y_px);
    if (after->first == t_us) return b;
    const auto before = std::prev(after);
    const Eigen::Vector2d a(before->second.circle.x_px, before->second.circle.y_px);
    return a + (b - a) * static_cast<double>(t_us - before->first) /
                   static_cast<double>(after->first - before->first);
  }

  const std::vector<TruthRow>& truth_;
  const std::vector<DetectionRow>& detections_;
  std::map<std::int64_t, TruthRow> by_time_;
};

TEST(Scoring, MatchesAHandMadeCase) {
  // Four chances; observations by falling score: inlier, outlier, inlier, inlier.
  const std::vector<TruthRow> truth = {truth_at(1000, 50, 50), truth_at(2000, 50, 50), truth_at(3000, 50, 50),
                                       truth_at(4000, 50, 50)};
  const std::vector<DetectionRow> seen = {seen_at(1000, 53, 54, 21, 0.9), seen_at(2000, 56.1, 50, 20, 0.8),
                                          seen_at(3000, 50, 44, 18, 0.7), seen_at(4000, 51, 50, 22, 0.6)};
  const DetectorScore score = score_detector(truth, seen, "d", 0.65, Chances::simulated);

  EXPECT_EQ(score.chances, 4);
  EXPECT_DOUBLE_EQ(*score.average_precision, 0.25 * (1.0 + 2.0 / 3.0 + 3.0 / 4.0));
  EXPECT_DOUBLE_EQ(*score.precision_at_recall[0], 1.0);        // 0.1
  EXPECT_DOUBLE_EQ(*score.precision_at_recall[2], 2.0 / 3.0);  // 0.3 needs two inliers
  EXPECT_DOUBLE_EQ(*score.precision_at_recall[3], 2.0 / 3.0);  // 0.5 is reached exactly
  EXPECT_DOUBLE_EQ(*score.precision_at_recall[4], 3.0 / 4.0);  // 0.7
  EXPECT_EQ(score.precision_at_recall[5], std::nullopt);       // 0.9 never
  ASSERT_EQ(score.pr_curve.size(), 4U);
  EXPECT_EQ(score.pr_curve[1].threshold, 0.8);
  EXPECT_EQ(score.pr_curve[1].precision, 0.5);
  EXPECT_EQ(score.pr_curve[1].recall, 0.25);
  EXPECT_EQ(score.observations, 3);
  EXPECT_EQ(score.inliers, 2);
  EXPECT_DOUBLE_EQ(*score.precision, 2.0 / 3.0);
  EXPECT_DOUBLE_EQ(*score.recall, 0.5);
  EXPECT_DOUBLE_EQ(*score.position_error_px.median, 6.0);  // of 5, 6.1 and 6
  EXPECT_NEAR(*score.position_error_px.p95, 6.09, 1e-9);
  EXPECT_DOUBLE_EQ(*score.radius_error_px.median, 1.0);  // of 1, 0 and 2
  EXPECT_NEAR(*score.radius_error_px.p95, 1.9, 1e-9);
  EXPECT_DOUBLE_EQ(*score.mean_rate_hz, 500.0);  // two inliers in four milliseconds
  EXPECT_EQ(score.peak_rate_hz, std::nullopt);   // no full bin
  EXPECT_EQ(score.lag_ms, std::nullopt);         // the ball does not move
  EXPECT_EQ(score.us_per_event, std::nullopt);
}

TEST(Scoring, CountsEqualScoresAsOneThreshold) {
  const std::vector<TruthRow> truth = {truth_at(1000, 50, 50), truth_at(2000, 50, 50)};
  const std::vector<DetectionRow> right_first = {seen_at(1000, 50, 50, 20, 1.0),
                                                 seen_at(2000, 90, 50, 20, 1.0)};
  const std::vector<DetectionRow> wrong_first = {seen_at(1000, 90, 50, 20, 1.0),
                                                 seen_at(2000, 50, 50, 20, 1.0)};
  for (const auto& seen : {right_first, wrong_first}) {
    const DetectorScore score = score_detector(truth, seen, "d", 1.0, Chances::simulated);
    EXPECT_EQ(score.pr_curve.size(), 1U);
    EXPECT_EQ(*score.average_precision, 0.25);
    EXPECT_EQ(*score.precision, 0.5);  // the threshold itself is above the threshold
  }
}

TEST(Scoring, WithoutDetectionsHasZeroRecallAndNoPrecision) {
  const auto truth = truth_along(500, circling);
  const DetectorScore score = score_detector(truth, {}, "d", 0.5, Chances::simulated);
  EXPECT_EQ(score.chances, 500);
  EXPECT_EQ(score.average_precision, 0.0);
  EXPECT_EQ(score.recall, 0.0);
  EXPECT_EQ(score.mean_rate_hz, 0.0);
  EXPECT_EQ(score.peak_rate_hz, 0.0);
  EXPECT_EQ(score.precision, std::nullopt);
  EXPECT_EQ(score.precision_at_recall[0], std::nullopt);
  EXPECT_EQ(score.position_error_px.median, std::nullopt);
  EXPECT_EQ(score.lag_ms, std::nullopt);
  EXPECT_TRUE(score.pr_curve.empty());
}

TEST(Scoring, WithoutChancesEveryObservationIsFalseAndNothingElseIsDefined) {
  const std::vector<TruthRow> truth = {truth_at(1000, 50, 50, 20, 0.0), truth_at(2000, nan, nan, nan, 0.0)};
  const std::vector<DetectionRow> seen = {seen_at(1000, 50, 50, 20, 1.0), seen_at(2000, 50, 50, 20, 1.0)};
  const DetectorScore score = score_detector(truth, seen, "d", 0.5, Chances::simulated);
  EXPECT_EQ(score.chances, 0);
  EXPECT_EQ(score.precision, 0.0);
  EXPECT_EQ(score.average_precision, std::nullopt);
  EXPECT_EQ(score.recall, std::nullopt);
  EXPECT_EQ(score.mean_rate_hz, std::nullopt);
  EXPECT_EQ(score.position_error_px.median, std::nullopt);
}

TEST(Scoring, IgnoresObservationsOfABallThatIsMoreThanHalfHiddenAndCountsThoseOfNoBallAsFalse) {
  const std::vector<TruthRow> truth = {truth_at(1000, 50, 50), truth_at(2000, 50, 50, 20, 0.49),
                                       truth_at(3000, 50, 50, 20, 0.01), truth_at(4000, 50, 50, 20, 0.0)};
  std::vector<DetectionRow> seen;
  for (const TruthRow& row : truth) seen.push_back(seen_at(row.t_us, 50, 50, 20, 1.0));
  for (const Chances chances : {Chances::simulated, Chances::annotated}) {
    const DetectorScore score = score_detector(truth, seen, "d", 0.5, chances);
    EXPECT_EQ(score.chances, 1);
    EXPECT_EQ(score.observations, 2);
    EXPECT_EQ(score.inliers, 1);
    EXPECT_EQ(score.precision, 0.5);
    EXPECT_EQ(score.average_precision, 0.5);
  }
}

TEST(Scoring, WithoutAnyBallTheAlarmRatioIsTheShareOfTheInstantsWithAnObservation) {
  std::vector<TruthRow> truth;
  for (int i = 1; i <= 10; ++i) truth.push_back(truth_at(i * 1000, nan, nan, nan, 0.0));
  const std::vector<DetectionRow> seen = {seen_at(1000, 50, 50, 20, 0.9), seen_at(2000, 50, 50, 20, 0.4),
                                          seen_at(3000, 50, 50, 20, 0.5)};
  EXPECT_EQ(score_detector(truth, seen, "d", 0.5, Chances::simulated).alarm_ratio, 0.2);
  EXPECT_EQ(score_detector(truth, {}, "d", 0.5, Chances::simulated).alarm_ratio, 0.0);
  EXPECT_EQ(score_detector(truth, seen, "d", 0.5, Chances::annotated).alarm_ratio, std::nullopt);
  truth[5] = truth_at(6000, 50, 50, 20, 0.0);  // a ball, if a hidden one
  EXPECT_EQ(score_detector(truth, seen, "d", 0.5, Chances::simulated).alarm_ratio, std::nullopt);
}

TEST(Scoring, WithoutARowOfTruthTheInstantsOfARunAreThoseOfTheScorer) {
  DetectorScorer scorer("d", 0.5, Chances::simulated);
  for (int i = 1; i <= 8; ++i)
    scorer.add(i * 1000, i == 3 ? std::optional(Observation{{50, 50, 20}, 0.7}) : std::nullopt);
  EXPECT_EQ(scorer.score().alarm_ratio, 0.125);
  EXPECT_EQ(scorer.score().observations, 1);
}

TEST(Scoring, AlarmsAreObservationsAtLeastATenthOfASecondApart) {
  std::vector<TruthRow> truth;
  std::vector<DetectionRow> seen;
  for (int t_ms = 1; t_ms <= 2000; ++t_ms) truth.push_back(truth_at(t_ms * 1000, nan, nan, nan, 0.0));
  for (const int t_ms : {5, 6, 104, 203, 303, 1500}) seen.push_back(seen_at(t_ms * 1000, 50, 50, 20, 0.9));
  // 5, 6, 104 and 203 ms are one alarm, 303 ms is 100 ms later, 1500 ms much later: three in two seconds.
  const DetectorScore score = score_detector(truth, seen, "d", 0.5, Chances::simulated);
  EXPECT_DOUBLE_EQ(*score.alarms_per_min, 90.0);
  EXPECT_DOUBLE_EQ(*score.alarm_ratio, 6 / 2000.0);
}

TEST(Scoring, WithoutAThresholdKeepsTheCurveAndHasNoFigureAtIt) {
  const auto truth = truth_along(1000, circling);
  std::vector<DetectionRow> seen;
  for (const TruthRow& row : truth)
    seen.push_back(seen_at(row.t_us, row.circle.x_px, row.circle.y_px, 20, 0.7));
  const DetectorScore score = score_detector(truth, seen, "d", nan, Chances::simulated);
  EXPECT_EQ(score.average_precision, 1.0);
  EXPECT_EQ(score.pr_curve.size(), 1U);
  EXPECT_EQ(score.precision, std::nullopt);
  EXPECT_EQ(score.recall, std::nullopt);
  EXPECT_EQ(score.mean_rate_hz, std::nullopt);
  EXPECT_EQ(score.position_error_px.median, std::nullopt);
  EXPECT_EQ(score.lag_ms, std::nullopt);
  EXPECT_EQ(score.reliability->at(7).observations, 1000);
}

TEST(Scoring, TakesTruthAsASimulationsWhereItsRowsAreAMillisecondApart) {
  EXPECT_EQ(chances_of(truth_along(100, circling)), Chances::simulated);
  auto gap = truth_along(100, circling);
  gap.erase(gap.begin() + 50);
  EXPECT_EQ(chances_of(gap), Chances::annotated);
  EXPECT_EQ(chances_of(truth_along(1, circling)), Chances::annotated);
}

TEST(Scoring, OfARecordingUsesTheAnnotatedInstantsOnly) {
  std::vector<TruthRow> truth = {truth_at(10'000, 50, 50), truth_at(510'000, 80, 50)};
  const std::vector<DetectionRow> seen = {seen_at(9'000, 0, 0, 10, 1.0), seen_at(10'000, 50, 50, 20, 1.0),
                                          seen_at(11'000, 0, 0, 10, 1.0)};
  const DetectorScore score = score_detector(truth, seen, "d", 0.5, Chances::annotated);
  EXPECT_EQ(score.chances, 2);
  EXPECT_EQ(score.observations, 1);
  EXPECT_EQ(score.precision, 1.0);
  EXPECT_EQ(score.recall, 0.5);
  EXPECT_EQ(score.mean_rate_hz, std::nullopt);
}

TEST(Scoring, SkipsTheRowsOfOtherDetectors) {
  const std::vector<TruthRow> truth = {truth_at(1000, 50, 50)};
  std::vector<DetectionRow> seen = {seen_at(1000, 0, 0, 10, 1.0), seen_at(1000, 50, 50, 20, 1.0)};
  seen[0].detector = "other";
  EXPECT_EQ(score_detector(truth, seen, "d", 0.5, Chances::simulated).precision, 1.0);
  EXPECT_EQ(score_detector(truth, seen, "other", 0.5, Chances::simulated).precision, 0.0);
}

TEST(Scoring, RejectsTwoObservationsOfOneInstantAndNumbersThatAreNotFinite) {
  const std::vector<TruthRow> truth = {truth_at(1000, 50, 50)};
  const std::vector<DetectionRow> twice(2, seen_at(1000, 50, 50, 20, 1.0));
  EXPECT_THROW(static_cast<void>(score_detector(truth, twice, "d", 0.5, Chances::simulated)), InputError);
  const std::vector<DetectionRow> broken = {seen_at(1000, nan, 50, 20, 1.0)};
  EXPECT_THROW(static_cast<void>(score_detector(truth, broken, "d", 0.5, Chances::simulated)), InputError);
}

TEST(Scoring, RatesAreInliersPerSecondOfTheBinsWithAChance) {
  auto truth = truth_along(350, circling);
  std::vector<DetectionRow> seen;
  for (const TruthRow& row : truth) {
    const std::int64_t bin = (row.t_us - 1000) / 100'000;
    // 50 inliers in the first bin, none in the second, every instant of the half bin at the end.
    if ((bin == 0 && row.t_us % 2000 == 0) || bin == 3) {
      seen.push_back(seen_at(row.t_us, row.circle.x_px, row.circle.y_px, row.circle.r_px, 1.0));
    }
  }
  for (TruthRow& row : truth) {
    if ((row.t_us - 1000) / 100'000 == 2) row.visible = 0.0;
  }
  const DetectorScore score = score_detector(truth, seen, "d", 0.5, Chances::simulated);
  EXPECT_DOUBLE_EQ(*score.mean_rate_hz, 100.0 / 0.25);
  EXPECT_DOUBLE_EQ(*score.peak_rate_hz, 500.0);
}

TEST(Scoring, AgreesWithThePlainDefinitionsOnRandomRuns) {
  const RandomStream random(7, "scoring test");
  for (std::uint64_t run = 0; run < 20; ++run) {
    std::vector<TruthRow> truth = truth_along(600, circling);
    std::vector<DetectionRow> seen;
    for (std::uint64_t i = 0; i < truth.size(); ++i) {
      if (random.uniform(4 * run, i) < 0.2) truth[i].visible = random.uniform(4 * run + 1, i);
      if (random.uniform(4 * run + 2, i) < 0.3) continue;
      const double spread = random.uniform(100 + run, i) < 0.3 ? 30.0 : 3.0;
      const Circle& c = truth[i].circle;
      // Coarse scores, so that many are equal.
      const double score = std::round(random.uniform(200 + run, i) * 20.0 + (spread < 5.0 ? 5.0 : 0.0));
      seen.push_back(seen_at(truth[i].t_us, c.x_px + spread * random.normal(300 + run, i),
                             c.y_px + spread * random.normal(400 + run, i),
                             c.r_px + random.normal(500 + run, i), score));
    }
    const double threshold = 8.0;
    const DetectorScore score = score_detector(truth, seen, "d", threshold, Chances::simulated);
    const PlainScorer plain(truth, seen);
    EXPECT_EQ(score.chances, plain.chances());
    EXPECT_NEAR(*score.average_precision, plain.average_precision(), 1e-12);
    for (std::size_t i = 0; i < reported_recalls.size(); ++i) {
      EXPECT_EQ(score.precision_at_recall[i], plain.precision_at(reported_recalls[i])) << reported_recalls[i];
    }
    EXPECT_EQ(score.precision, plain.precision(threshold));
    EXPECT_EQ(score.recall, plain.recall(threshold));
    for (const CurvePoint& point : score.pr_curve) {
      EXPECT_EQ(point.precision, plain.precision(point.threshold));
      EXPECT_EQ(point.recall, plain.recall(point.threshold));
    }
    EXPECT_NEAR(*score.lag_ms, plain.lag_ms(threshold), 1e-9);
  }
}

TEST(Scoring, ThinsLongCurvesToTwoHundredPointsWithBothEnds) {
  const auto truth = truth_along(3000, circling);
  std::vector<DetectionRow> seen;
  for (const TruthRow& row : truth) {
    seen.push_back(
        seen_at(row.t_us, row.circle.x_px, row.circle.y_px, row.circle.r_px, static_cast<double>(row.t_us)));
  }
  const DetectorScore score = score_detector(truth, seen, "d", 0.0, Chances::simulated);
  ASSERT_EQ(score.pr_curve.size(), 200U);
  EXPECT_EQ(score.pr_curve.front().threshold, 3'000'000.0);
  EXPECT_EQ(score.pr_curve.back().threshold, 1000.0);
  EXPECT_EQ(score.pr_curve.back().recall, 1.0);
}

class Lag : public testing::TestWithParam<double> {};

TEST_P(Lag, IsFoundToATenthOfAMillisecond) {
  const double lag_ms = GetParam();
  const auto truth = truth_along(2000, circling);
  const RandomStream random(3, "lag test");
  std::vector<DetectionRow> seen;
  for (std::size_t i = 0; i < truth.size(); i += 3) {
    Eigen::Vector2d p = circling(static_cast<double>(truth[i].t_us) * 1e-6 - lag_ms * 1e-3);
    if (random.uniform(0, i) < 0.2) p += Eigen::Vector2d(40.0, -30.0);  // clutter does not move the median
    seen.push_back(seen_at(truth[i].t_us, p.x(), p.y(), 20, 1.0));
  }
  const DetectorScore score = score_detector(truth, seen, "d", 0.5, Chances::simulated);
  EXPECT_NEAR(*score.lag_ms, lag_ms, 0.1 + 1e-9);
}

INSTANTIATE_TEST_SUITE_P(Scoring, Lag, testing::Values(-50.0, -3.7, 0.0, 0.1, 12.3, 87.6, 200.0));

TEST(Scoring, LagOfEqualShiftsIsTheOneNearestZero) {
  // The ball moves at first and stands still from then on: where nothing moves every shift is as good.
  const auto truth =
      truth_along(2000, [](double t_s) { return Eigen::Vector2d(t_s < 1.1 ? 60.0 * t_s : 66.0, 50.0); });
  std::vector<DetectionRow> seen;
  for (int t_ms = 1400; t_ms < 1800; ++t_ms) seen.push_back(seen_at(t_ms * 1000, 66, 50, 20, 1.0));
  EXPECT_EQ(score_detector(truth, seen, "d", 0.5, Chances::simulated).lag_ms, 0.0);
}

TEST(Scoring, LagIsNoneWhenTheBallMovesLessThanSixPixels) {
  for (const double swing_px : {2.9, 3.1}) {
    const auto truth = truth_along(2000, [&](double t_s) {
      return Eigen::Vector2d(64.0 + swing_px * std::sin(10.0 * std::numbers::pi * t_s), 64.0);
    });
    std::vector<DetectionRow> seen;
    for (const TruthRow& row : truth)
      seen.push_back(seen_at(row.t_us, row.circle.x_px, row.circle.y_px, 20, 1.0));
    EXPECT_EQ(score_detector(truth, seen, "d", 0.5, Chances::simulated).lag_ms.has_value(), swing_px > 3.0);
  }
}

TEST(Scoring, LagIsNoneWhereTheBallIsSlowerThanThirtyPixelsPerSecondInTheMedian) {
  for (const double speed_px_s : {29.0, 31.0}) {
    const auto truth =
        truth_along(2000, [&](double t_s) { return Eigen::Vector2d(20.0 + speed_px_s * t_s, 50.0); });
    std::vector<DetectionRow> seen;
    for (const TruthRow& row : truth) seen.push_back(seen_at(row.t_us, row.circle.x_px, 50, 20, 1.0));
    EXPECT_EQ(score_detector(truth, seen, "d", 0.5, Chances::simulated).lag_ms.has_value(),
              speed_px_s > 30.0);
  }
}

TEST(Scoring, LagUsesNoObservationsNextToTimesWithoutACircle) {
  auto truth = truth_along(1000, circling);
  for (std::size_t i = 400; i < 500; ++i) truth[i] = truth_at(truth[i].t_us, nan, nan, nan, 0.0);
  std::vector<DetectionRow> seen;
  for (const TruthRow& row : truth) {
    const Eigen::Vector2d p = circling(static_cast<double>(row.t_us) * 1e-6 - 0.02);
    seen.push_back(seen_at(row.t_us, p.x(), p.y(), 20, 1.0));
  }
  EXPECT_NEAR(*score_detector(truth, seen, "d", 0.5, Chances::simulated).lag_ms, 20.0, 1e-9);
}

TEST(Scoring, LagIsNoneWhereAnnotationsAreTooFarApart) {
  for (const int period_ms : {20, 21}) {
    std::vector<TruthRow> truth;
    std::vector<DetectionRow> seen;
    for (int t_ms = period_ms; t_ms < 3000; t_ms += period_ms) {
      const Eigen::Vector2d p(20.0 + 0.04 * t_ms, 64.0);
      truth.push_back(truth_at(t_ms * 1000, p.x(), p.y()));
      seen.push_back(seen_at(t_ms * 1000, p.x() - 0.6, p.y(), 20, 1.0));  // 15 ms late
    }
    const DetectorScore score = score_detector(truth, seen, "d", 0.5, Chances::annotated);
    EXPECT_EQ(score.lag_ms.has_value(), period_ms == 20);
    EXPECT_NEAR(score.lag_ms.value_or(15.0), 15.0, 1e-9);
  }
}

TEST(FoundRate, IsTheShareOfTheChancesFromAnInstantOn) {
  std::vector<TruthRow> truth;
  std::vector<std::optional<bool>> found;
  for (int i = 1; i <= 100; ++i) {
    truth.push_back({.t_us = i * 1000, .circle = {64, 64, 20}, .visible = 1.0});
    found.emplace_back(i <= 50 || i % 5 == 0);
  }
  for (int i = 90; i < 100; ++i) found[static_cast<std::size_t>(i)].reset();  // out of sight
  EXPECT_NEAR(*found_rate_hz(truth, found, 51'000), 1000.0 * 8 / 40, 1e-9);
  EXPECT_NEAR(*found_rate_hz(truth, found, 0), 1000.0 * 58 / 90, 1e-9);
  EXPECT_EQ(found_rate_hz(truth, found, 95'000), std::nullopt);
}

TEST(Instants, DetectionsBetweenThoseOfTheTruthAreAnErrorThatNamesBoth) {
  const std::vector<TruthRow> truth = truth_along(100, circling);
  std::vector<DetectionRow> detections;
  for (const TruthRow& row : truth)
    detections.push_back(seen_at(row.t_us + 6, row.circle.x_px, row.circle.y_px, row.circle.r_px, 0.9));
  try {
    check_instants(truth, detections, "d", "mine.csv");
    ADD_FAILURE() << "accepted";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(),
                testing::HasSubstr("mine.csv: found 99 detections of d in the time of the truth"));
    EXPECT_THAT(error.what(), testing::HasSubstr("the truth has t_us = 1000, 2000, 3000, ..., the detections "
                                                 "1006, 2006, 3006, ..."));
  }
  detections[40].t_us = truth[40].t_us;
  const SharedInstants instants = check_instants(truth, detections, "d", "mine.csv");
  EXPECT_EQ(instants.detections, 99);
  EXPECT_EQ(instants.shared, 1);
  EXPECT_EQ(check_instants(truth, detections, "other", "mine.csv").detections, 0);
}

TEST(Instants, DetectionsInAnotherTimeThanTheTruthAreAnErrorThatNamesBothSpans) {
  const std::vector<TruthRow> truth = truth_along(10, circling);
  const std::vector<DetectionRow> late = {seen_at(9'000'000, 64, 64, 20, 0.5)};
  EXPECT_THAT([&] { check_instants(truth, late, "d", "mine.csv"); },
              testing::ThrowsMessage<InputError>(
                  testing::HasSubstr("detections from 9.000 to 9.000 s, truth from 0.001 to 0.010 s")));
}

}  // namespace
}  // namespace saccade
