#include "evaluation/scoring/uncertainty.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"
#include "evaluation/scoring/detector_scorer.h"

namespace saccade {
namespace {

TEST(Reliability, CountsScoresByTenthsAndTheInliersAmongThem) {
  ReliabilityCounter counter;
  counter.add(0.0, false);
  counter.add(0.35, true);
  counter.add(0.31, false);
  counter.add(0.9, true);
  counter.add(1.0, true);
  const Reliability bins = counter.result().value();
  EXPECT_EQ(bins[0].observations, 1);
  EXPECT_EQ(bins[0].inlier_share(), 0.0);
  EXPECT_EQ(bins[3].observations, 2);
  EXPECT_EQ(bins[3].inlier_share(), 0.5);
  EXPECT_NEAR(bins[3].mean_score, 0.33, 1e-15);
  EXPECT_EQ(bins[9].observations, 2);
  EXPECT_EQ(bins[5].inlier_share(), std::nullopt);
}

TEST(Reliability, IsUnknownForScoresThatAreNoProbabilities) {
  for (const double score : {-0.01, 1.01, 17.0}) {
    ReliabilityCounter counter;
    counter.add(0.5, true);
    counter.add(score, true);
    EXPECT_EQ(counter.result(), std::nullopt) << score;
  }
  EXPECT_EQ(ReliabilityCounter().result(), std::nullopt);
}

TEST(Nees, OfErrorsWithTheirOwnCovarianceIsBelowTheBoundInNineteenOfTwentyCases) {
  // x and r are correlated, as where one side of the outline alone is seen.
  Eigen::Matrix3d root;
  root << 1.0, 0.0, 0.0, 0.3, 0.5, 0.0, 0.8, 0.0, 0.4;
  const Eigen::Matrix3d covariance_px2 = root * root.transpose();
  const RandomStream random(5, "nees test");
  NeesCounter counter;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    const Eigen::Vector3d error =
        root * Eigen::Vector3d(random.normal(0, i), random.normal(1, i), random.normal(2, i));
    counter.add(nees_of({50 + error.x(), 60 + error.y(), 20 + error.z()}, covariance_px2, {50, 60, 20}));
  }
  const Nees nees = counter.result().value();
  EXPECT_EQ(nees.count, 20'000);
  EXPECT_NEAR(nees.below_bound, 0.95, 0.005);  // the standard error is 0.0015
  EXPECT_NEAR(nees.median, 2.366, 0.06);       // the median of chi-squared with three degrees of freedom
}

TEST(Nees, IsUnknownWithoutACovarianceThatIsPositiveDefinite) {
  const Circle truth{50, 50, 20};
  EXPECT_EQ(nees_of(truth, Eigen::Matrix3d::Zero(), truth), std::nullopt);
  EXPECT_EQ(nees_of(truth, Eigen::Vector3d(1, 1, -1).asDiagonal(), truth), std::nullopt);
  EXPECT_EQ(nees_of(truth, Eigen::Matrix3d::Constant(std::nan("")), truth), std::nullopt);
  EXPECT_EQ(nees_of({51, 50, 22}, Eigen::Vector3d(1, 1, 4).asDiagonal(), truth), 2.0);
  EXPECT_EQ(NeesCounter().result(), std::nullopt);
}

TEST(DetectorScorer, TakesTheNeesOfTheInliersAtTheThresholdAlone) {
  DetectorScorer scorer("d", 0.5, Chances::simulated);
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  const auto add = [&](std::int64_t t_ms, double x_px, double score, const Eigen::Matrix3d& covariance_px2) {
    scorer.add({.t_us = t_ms * 1000, .circle = {50, 50, 20}, .visible = 1.0},
               Observation{{x_px, 50, 20}, score, covariance_px2});
  };
  add(1, 51, 0.9, one);                      // 1
  add(2, 53, 0.8, one);                      // 9
  add(3, 53, 0.4, one);                      // below the threshold
  add(4, 70, 0.9, one);                      // no inlier
  add(5, 53, 0.9, Eigen::Matrix3d::Zero());  // unknown
  const DetectorScore score = scorer.score();
  EXPECT_EQ(score.inliers, 3);
  EXPECT_EQ(score.nees->count, 2);
  EXPECT_EQ(score.nees->below_bound, 0.5);
  EXPECT_EQ(score.nees->median, 5.0);
  EXPECT_EQ(score.reliability->at(4).observations, 1) << "reliability is of all observations";
  EXPECT_EQ(score.reliability->at(9).observations, 3);
  EXPECT_EQ(score.reliability->at(9).inliers, 2);
}

}  // namespace
}  // namespace saccade
