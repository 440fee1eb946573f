#include "control/gate_registry.h"

#include <gtest/gtest.h>
#include <algorithm>

#include <functional>
#include <limits>

#include "control/continuity_gate.h"
#include "control/gaze_gate.h"
#include "control/median_gate.h"
#include "core/error.h"
#include "core/random.h"
#include "core/units.h"
#include "head/icub_cameras.h"

namespace saccade {
namespace {

const Camera camera = icub_left_2016;
constexpr double threshold = 0.5;

/// A camera that looks ahead from the root's origin, upright.
Eigen::Isometry3d looking_ahead() {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() << 0, 0, -1, 1, 0, 0, 0, -1, 0;
  return pose;
}

Estimate sure(double x_px, double y_px, double r_px) { return {true, false, {x_px, y_px, r_px}, 1.0}; }

std::optional<Eigen::Vector3d> update(GazeGate& gate, std::int64_t now_us, const Estimate& estimate) {
  return gate.update(now_us, estimate, threshold, camera, looking_ahead());
}

std::unique_ptr<GazeGate> gate(const char* name, DepthModel depth = DepthModel::pinhole) {
  GateConfig config = built_in_gates().config();
  config.gate = name;
  config.target.depth = depth;
  return make_gate(config);
}

/// One detection per ms for `count` ms; the last answer.
std::optional<Eigen::Vector3d> feed(GazeGate& g, int count, const std::function<Estimate(int)>& at) {
  std::optional<Eigen::Vector3d> last;
  for (int i = 1; i <= count; ++i) last = update(g, i * 1000, at(i));
  return last;
}

TEST(OpenGate, TurnsEveryEstimateAtTheThresholdIntoItsPoint) {
  const auto g = gate("none");
  const Eigen::Vector3d ball(-0.45, 0.06, 0.03);
  const Circle circle = *camera.project_sphere(looking_ahead().inverse() * ball, 0.0475);
  for (const bool held : {false, true}) {
    const auto target = update(*g, 1000, {true, held, circle, threshold});
    ASSERT_TRUE(target);
    EXPECT_LT((*target - ball).norm(), 1e-9);
  }
}

TEST(OpenGate, GivesNoTargetForAnEstimateBelowTheThresholdOrNone) {
  const auto g = gate("none");
  EXPECT_FALSE(update(*g, 1000, {true, false, {60, 60, 12}, 0.499}));
  EXPECT_FALSE(update(*g, 2000, {false, false, {60, 60, 12}, 1.0}));
  EXPECT_FALSE(update(*g, 3000, {true, false, {60, 60, 12}, std::numeric_limits<double>::quiet_NaN()}));
}

TEST(Gates, CountRejectedTargetsByReason) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const char* name : {"none", "authors", "continuity"}) {
    GateConfig config = built_in_gates().config();
    config.gate = name;
    config.get<MedianGateConfig>().min_detections = 1;
    config.get<ContinuityGateConfig>().min_agreeing = 1;
    config.get<MedianGateConfig>().max_radius_px = 1000;
    config.target.depth = DepthModel::authors_linear;
    for (const auto& [circle, counter] : {std::pair{Circle{nan, 60, 12}, &RejectedTargets::not_finite},
                                          {Circle{60, 60, -1}, &RejectedTargets::bad_radius},
                                          {Circle{60, 60, 27}, &RejectedTargets::too_near},
                                          {Circle{60, 60, 40}, &RejectedTargets::behind}}) {
      const auto g = make_gate(config);
      EXPECT_FALSE(update(*g, 1000, {true, false, circle, 1.0})) << name;
      EXPECT_EQ(g->rejected().*counter, 1) << name;
    }
  }
}

TEST(MedianGate, WaitsForMoreThanEightyDetections) {
  const auto g = gate("authors");
  EXPECT_FALSE(feed(*g, 80, [](int) { return sure(60, 60, 12); }));
  EXPECT_TRUE(update(*g, 81000, sure(60, 60, 12)));
}

TEST(MedianGate, IgnoresDetectionsOlderThanAQuarterOfASecond) {
  const auto g = gate("authors");
  EXPECT_TRUE(feed(*g, 81, [](int) { return sure(60, 60, 12); }));
  // At 251 ms the detection of 1 ms is out: the 80 others and this one are 81 still.
  EXPECT_TRUE(update(*g, 251000, sure(60, 60, 12)));
  // At 260 ms those up to 10 ms are out.
  EXPECT_FALSE(update(*g, 260000, sure(60, 60, 12)));
}

TEST(MedianGate, IgnoresEstimatesBelowTheThresholdAndHeldOnes) {
  const auto g = gate("authors");
  EXPECT_FALSE(feed(*g, 200, [](int i) {
    Estimate e = sure(60, 60, 12);
    if (i % 2 == 0) e.score = 0.1;
    if (i % 3 == 0) e.held = true;
    return e;  // 67 of 200 count
  }));
}

TEST(MedianGate, TargetsTheMedianAndIgnoresOutliers) {
  const auto g = gate("authors", DepthModel::authors_linear);
  // A fifth of the detections is far off; the newest is good.
  const auto target = feed(*g, 201, [](int i) { return i % 5 == 0 ? sure(90, 95, 10) : sure(60, 62, 10); });
  ASSERT_TRUE(target);
  const Eigen::Vector2d pixel = *camera.project(looking_ahead().inverse() * *target);
  EXPECT_NEAR(pixel.x(), 60, 1e-9);
  EXPECT_NEAR(pixel.y(), 62, 1e-9);
}

TEST(MedianGate, GivesNoTargetIfTheNewestDetectionIsAnOutlier) {
  const auto g = gate("authors");
  EXPECT_TRUE(feed(*g, 202, [](int i) { return sure(60 + i % 3, 62, 12); }));
  EXPECT_FALSE(update(*g, 203000, sure(75, 62, 12)));
  EXPECT_FALSE(update(*g, 204000, sure(61, 80, 12)));
}

TEST(MedianGate, GivesNoTargetIfTheDetectionsAreSpread) {
  // Three values at -w, 0, w have a standard deviation of 0.816 w; the last detection is the median.
  const auto spread_over = [](double w_px, double Circle::*coordinate) {
    const auto g = gate("authors");
    return feed(*g, 241, [&](int i) {
      Estimate e = sure(60, 60, 12);
      e.circle.*coordinate += (i % 3 - 1) * w_px;
      return e;
    });
  };
  for (const auto coordinate : {&Circle::x_px, &Circle::y_px}) {
    EXPECT_TRUE(spread_over(24.0, coordinate));
    EXPECT_FALSE(spread_over(25.0, coordinate));
  }
}

TEST(MedianGate, UsesTheLargestRadiusUpToSixteen) {
  const auto depth = [](double largest_px) {
    const auto g = gate("authors", DepthModel::authors_linear);
    const auto target = feed(*g, 150, [&](int i) { return sure(60, 60, i == 100 ? largest_px : 10.0); });
    return target ? -target->x() : -1.0;
  };
  EXPECT_NEAR(depth(12.0), 0.40, 1e-12);
  EXPECT_NEAR(depth(24.0), 0.30, 1e-12);
}

TEST(MedianGate, KeepsTheTargetTenCentimetresInFrontOfTheWaist) {
  const auto g = gate("authors");
  Eigen::Isometry3d behind_the_waist = looking_ahead();
  behind_the_waist.translation().x() = 0.5;
  std::optional<Eigen::Vector3d> target;
  for (int i = 1; i <= 81; ++i) {
    target = g->update(i * 1000, sure(64, 69, 15), threshold, camera, behind_the_waist);
  }
  ASSERT_TRUE(target);
  EXPECT_EQ(target->x(), -0.10);
}

TEST(MedianGate, EqualsAPlainReferenceOnRandomStreams) {
  const RandomStream random(7, "gate");
  const auto g = gate("authors", DepthModel::authors_linear);
  std::vector<std::pair<std::int64_t, Circle>> all;
  std::int64_t now_us = 0;
  int targets = 0;
  for (std::uint64_t i = 0; i < 20000; ++i) {
    now_us += 1000 + static_cast<std::int64_t>(random.uniform(0.0, 3000.0, 0, i / 500));
    const double width = random.uniform(0.0, 40.0, 1, i / 300);
    const Circle c{64 + width * random.normal(2, i) * 0.7, 64 + width * random.normal(3, i) * 0.7,
                   random.uniform(8.0, 14.0, 4, i)};
    const auto target = update(*g, now_us, {true, false, c, 1.0});
    all.push_back({now_us, c});
    std::vector<double> x, y;
    double r = 0.0;
    for (const auto& [t, d] : all) {
      if (now_us - t >= 250000) continue;
      x.push_back(d.x_px);
      y.push_back(d.y_px);
      r = std::max(r, d.r_px);
    }
    const auto median = [](std::vector<double> v) {
      std::sort(v.begin(), v.end());
      return v[v.size() / 2];
    };
    const auto deviation = [](const std::vector<double>& v) {
      double mean = 0.0, squares = 0.0;
      for (const double value : v) mean += value / static_cast<double>(v.size());
      for (const double value : v) squares += (value - mean) * (value - mean) / static_cast<double>(v.size());
      return std::sqrt(squares);
    };
    const bool wanted = x.size() > 80 && deviation(x) < 20 && deviation(y) < 20 &&
                        std::abs(c.x_px - median(x)) <= deviation(x) &&
                        std::abs(c.y_px - median(y)) <= deviation(y);
    ASSERT_EQ(target.has_value(), wanted) << i;
    if (!wanted) continue;
    ++targets;
    const Eigen::Vector3d in_camera = looking_ahead().inverse() * *target;
    ASSERT_NEAR(in_camera.z(), (70.0 - 2.5 * std::min(r, 16.0)) / 100.0, 1e-12);
    ASSERT_NEAR(camera.project(in_camera)->x(), median(x), 1e-9);
    if (all.size() > 400) all.erase(all.begin());
  }
  EXPECT_GT(targets, 500);
}

TEST(Gates, ABadConfigurationIsAnInputError) {
  GateConfig config = built_in_gates().config();
  config.gate = "sometimes";
  config.get<MedianGateConfig>().window_s = 9.0;
  config.target.ball_diameter_m = 0.0;
  try {
    (void)make_gate(config);
    FAIL() << "taken";
  } catch (const InputError& error) {
    EXPECT_EQ(error.problems().size(), 3u);
  }
}

TEST(ContinuityGate, StartsWhenEnoughDetectionsAgreeAndThenPassesEachAtOnce) {
  const auto g = gate("continuity");
  const auto enough = static_cast<int>(ContinuityGateConfig{}.min_agreeing);
  EXPECT_FALSE(feed(*g, enough - 1, [](int) { return sure(60, 60, 12); }));
  EXPECT_TRUE(update(*g, enough * 1000, sure(60, 60, 12)));
  EXPECT_TRUE(update(*g, enough * 1000 + 1000, sure(62, 61, 12)));
}

TEST(MedianGate, UsesTheMedianInTheCurrentImageAfterTheCameraHasTurned) {
  // A ball at rest, found 100 times; then the camera turns by 10 deg and sees it elsewhere.
  const auto g = gate("authors");
  const Eigen::Vector3d ball_m(-0.45, 0.02, 0.03);
  Eigen::Isometry3d pose = looking_ahead();
  std::optional<Eigen::Vector3d> target_m;
  for (int i = 1; i <= 120; ++i) {
    if (i == 101) pose.rotate(Eigen::AngleAxisd(10.0 * rad_per_deg, Eigen::Vector3d::UnitY()));
    const auto at_px = camera.project(pose.inverse() * ball_m).value();
    target_m = g->update(i * 1000, sure(at_px.x(), at_px.y(), 10.6), threshold, camera, pose);
    if (i <= 100) continue;
    ASSERT_TRUE(target_m) << i;
    const double off_deg = std::acos(target_m->normalized().dot(ball_m.normalized())) / rad_per_deg;
    EXPECT_LT(off_deg, 0.1) << "a median of pixels of both images would be up to 10 deg off";
  }
}

TEST(ContinuityGate, DoesNotStartOnScatteredDetections) {
  const auto g = gate("continuity");
  const RandomStream random(3, "gate");
  const auto anywhere = [&](int i) {
    const auto n = static_cast<std::uint64_t>(i);
    return sure(random.uniform(0, 127, n, 0), random.uniform(0, 127, n, 1), random.uniform(10, 35, n, 2));
  };
  for (int i = 1; i <= 2000; ++i) EXPECT_FALSE(update(*g, i * 1000, anywhere(i))) << i;
}

TEST(ContinuityGate, RejectsDetectionsElsewhereUntilTheBallIsLostAndThenNeedsConfirmation) {
  GateConfig slow = built_in_gates().config();
  slow.gate = "continuity";
  slow.get<ContinuityGateConfig>().growth_deg_s = 15.0;
  const ContinuityGateConfig config = slow.get<ContinuityGateConfig>();
  const auto g = make_gate(slow);
  ASSERT_TRUE(feed(*g, 100, [](int) { return sure(20, 20, 12); }));
  // The far corner, 49 deg away: beyond the tolerance at any time before the ball counts as lost.
  const auto lost_ms = static_cast<int>(config.forget_s * 1000);
  for (int i = 1; i <= lost_ms; ++i) EXPECT_FALSE(update(*g, (100 + i) * 1000, sure(110, 110, 12))) << i;
  // Those just refused confirm it at once.
  EXPECT_TRUE(update(*g, (100 + lost_ms + 1) * 1000, sure(110, 110, 12)));
}

TEST(ContinuityGate, RejectsADetectionAtAnotherDepth) {
  const auto g = gate("continuity");
  ASSERT_TRUE(feed(*g, 100, [](int) { return sure(60, 60, 12); }));
  EXPECT_FALSE(update(*g, 101'000, sure(60, 60, 24)));
  EXPECT_TRUE(update(*g, 102'000, sure(60, 60, 13)));
}

TEST(ContinuityGate, AfterAGapAcceptsDetectionsAsFarAsTheBallCanHaveMoved) {
  const auto g = gate("continuity");
  ASSERT_TRUE(feed(*g, 100, [](int) { return sure(60, 60, 12); }));
  // 13 px are 7.4 deg: too far after a millisecond, not after half a second (3 deg + 60 deg/s).
  EXPECT_FALSE(update(*g, 101'000, sure(73, 60, 12)));
  EXPECT_TRUE(update(*g, 600'000, sure(73, 60, 12)));
  // Lost after forget_s: one detection does not find it again.
  EXPECT_FALSE(update(*g, 3'000'000, sure(73, 60, 12)));
}

TEST(ContinuityGate, AfterAGapAcceptsADistanceThatTheBallCanHaveReached) {
  // 25 % and, at 60 deg/s or 1.05 per s, another 23 % after 0.2 s.
  const auto g = gate("continuity");
  ASSERT_TRUE(feed(*g, 60, [](int) { return sure(60, 60, 12); }));
  EXPECT_FALSE(update(*g, 61'000, sure(60, 60, 17)));
  EXPECT_TRUE(update(*g, 261'000, sure(60, 60, 17)));
}

TEST(ContinuityGate, AWrongRadiusThatWasTakenDoesNotKeepTheBallOut) {
  const auto g = gate("continuity");
  ASSERT_TRUE(feed(*g, 100, [](int) { return sure(60, 60, 12); }));
  ASSERT_TRUE(update(*g, 101'000, sure(60, 60, 12 * (ContinuityGateConfig{}.depth_ratio - 0.02))));
  int taken = 0;
  for (int i = 102; i <= 300; ++i) taken += update(*g, i * 1000, sure(60, 60, 11.7)).has_value();
  EXPECT_EQ(taken, 199);
}

TEST(ContinuityGate, AFastBallIsFoundAgainFartherAway) {
  // Sideways at 0.9 m/s, 110 deg/s: 8.8 deg in the 80 ms in which it is not seen.
  const auto circle_at = [](double y_m) {
    return Estimate{
        true, false,
        *camera.project_sphere(looking_ahead().inverse() * Eigen::Vector3d(-0.45, y_m, 0.0), 0.0475), 1.0};
  };
  const auto fast = gate("continuity");
  ASSERT_TRUE(feed(*fast, 200, [&](int i) { return circle_at(i < 100 ? -0.1 : -0.1 + 0.9e-3 * (i - 100)); }));
  EXPECT_FALSE(update(*fast, 201'000, circle_at(-0.01 + 0.072)));
  EXPECT_TRUE(update(*fast, 280'000, circle_at(-0.01 + 0.072)));
  // One that rested cannot have moved that far.
  const auto slow = gate("continuity");
  ASSERT_TRUE(feed(*slow, 200, [&](int) { return circle_at(-0.01); }));
  EXPECT_FALSE(update(*slow, 280'000, circle_at(-0.01 + 0.072)));
}

TEST(ContinuityGate, UsesTheRootFrameSoThatHeadMotionHasNoEffect) {
  const auto g = gate("continuity");
  const Eigen::Vector3d ball(-0.45, 0.0, 0.0);
  int passed = 0;
  for (int i = 1; i <= 300; ++i) {  // the camera turns by 0.1 deg per ms, 100 deg/s
    Eigen::Isometry3d pose = looking_ahead();
    pose.linear() =
        Eigen::AngleAxisd((150 - i) * 0.1 * 3.14159265 / 180, Eigen::Vector3d::UnitZ()) * pose.linear();
    const auto circle = camera.project_sphere(pose.inverse() * ball, 0.0475);
    ASSERT_TRUE(circle);
    passed += g->update(i * 1000, {true, false, *circle, 1.0}, threshold, camera, pose).has_value();
  }
  EXPECT_EQ(passed, 300 - static_cast<int>(ContinuityGateConfig{}.min_agreeing) + 1);
}

/// A passing ball at `t_s`: 45 cm ahead, to the right at 10 cm/s (13 deg/s).
Estimate passing_ball(double t_s, double score, double off_m = 0.0) {
  const Eigen::Vector3d ball_m(-0.45, -0.1 + 0.1 * t_s + off_m, 0.0);
  return {true, false, *camera.project_sphere(looking_ahead().inverse() * ball_m, 0.0475), score,
          Eigen::Matrix3d::Identity()};
}

TEST(ContinuityGate, TakesALowScoreWhereTheBallIsPredictedAndNowhereElse) {
  const auto g = gate("continuity");
  ASSERT_TRUE(feed(*g, 500, [](int i) { return passing_ball(i * 1e-3, 1.0); }));
  // 60 ms later, 0.8 deg on.
  EXPECT_FALSE(update(*g, 560'000, passing_ball(0.56, 0.2, 0.04)));
  EXPECT_FALSE(update(*g, 561'000, passing_ball(0.561, 0.09)));
  EXPECT_TRUE(update(*g, 562'000, passing_ball(0.562, 0.2)));
}

TEST(ContinuityGate, ALowScoreMovesTheTargetToItsDirectionAndLeavesItsDistance) {
  const auto g = gate("continuity");
  const auto sure_m = feed(*g, 500, [](int i) { return passing_ball(i * 1e-3, 1.0); });
  ASSERT_TRUE(sure_m);
  Estimate weak = passing_ball(0.52, 0.2);
  weak.circle.r_px *= 1.1;
  const auto target_m = update(*g, 520'000, weak);
  ASSERT_TRUE(target_m);
  EXPECT_NEAR(target_m->norm(), sure_m->norm(), 1e-12);
  const Eigen::Vector2d at_px = *camera.project(looking_ahead().inverse() * *target_m);
  EXPECT_NEAR((at_px - Eigen::Vector2d(weak.circle.x_px, weak.circle.y_px)).norm(), 0.0, 0.2);
}

TEST(ContinuityGate, ALowScoreFindsNoBallAndKeepsNoneForLong) {
  const auto fresh = gate("continuity");
  EXPECT_FALSE(feed(*fresh, 500, [](int i) { return passing_ball(i * 1e-3, 0.2); }));
  const auto g = gate("continuity");
  ASSERT_TRUE(feed(*g, 200, [](int i) { return passing_ball(i * 1e-3, 1.0); }));
  int taken = 0;
  for (int i = 201; i <= 2600; ++i) taken += update(*g, i * 1000, passing_ball(i * 1e-3, 0.2)).has_value();
  EXPECT_EQ(taken, 2000);  // near_s
}

TEST(ContinuityGate, ALowScoreOfAFastBallIsNoTarget) {
  const auto g = gate("continuity");
  // At rest for 0.1 s, since a fast one is not confirmed, then 100 deg/s.
  const auto fast_ball = [](int i, double score) {
    return passing_ball(8e-3 * std::max(0, i - 100), score, -0.1);
  };
  ASSERT_TRUE(feed(*g, 300, [&](int i) { return fast_ball(i, 1.0); }));
  EXPECT_FALSE(update(*g, 301'000, fast_ball(301, 0.499)));
  EXPECT_TRUE(update(*g, 302'000, fast_ball(302, 0.5)));
}

TEST(ContinuityGate, ALowScoreOfADetectorWithoutCovarianceIsNoTarget) {
  const auto g = gate("continuity");
  const auto untracked = [](int i, double score) {
    Estimate estimate = passing_ball(i * 1e-3, score);
    estimate.covariance_px2.setZero();
    return estimate;
  };
  ASSERT_TRUE(feed(*g, 500, [&](int i) { return untracked(i, 1.0); }));
  EXPECT_FALSE(update(*g, 501'000, untracked(501, 0.499)));
}

TEST(ContinuityGate, WithANearScoreOf1ALowScoreIsNoTarget) {
  ContinuityGateConfig config;
  config.near_score = 1.0;
  ContinuityGate g(config, TargetConfig{});
  ASSERT_TRUE(feed(g, 500, [](int i) { return passing_ball(i * 1e-3, 1.0); }));
  EXPECT_FALSE(update(g, 501'000, passing_ball(0.501, 0.499)));
}

}  // namespace
}  // namespace saccade
