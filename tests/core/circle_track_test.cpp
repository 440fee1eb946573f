#include "core/tracker/circle_track.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace saccade {
namespace {

/// An edge on a circle at an angle, moving along the normal at 100 px/s.
Edge edge_on(const Circle& circle, double angle_rad, std::int64_t t_us) {
  Edge edge;
  edge.t_us = t_us;
  edge.x = static_cast<std::uint16_t>(std::lround(circle.x_px + circle.r_px * std::cos(angle_rad)));
  edge.y = static_cast<std::uint16_t>(std::lround(circle.y_px + circle.r_px * std::sin(angle_rad)));
  edge.along = {std::cos(angle_rad), std::sin(angle_rad)};
  edge.speed_px_s = 100.0;
  return edge;
}

TEST(CircleTrack, KeepsAPositiveDefiniteCovarianceAfterANewSpeed) {
  // Edges of one side of the circle measure the speed along one direction, and so relate its x and y. Then another
  // measurement of the speed replaces theirs.
  const Circle circle{60, 60, 15};
  const Eigen::Vector2d still = Eigen::Vector2d::Zero();
  CircleTrack track(circle, 100'000);
  for (int i = 0; i < 10; ++i) {
    ASSERT_TRUE(track.measure(edge_on(circle, std::numbers::pi / 4, 100'000), 1.0,
                              CircleTrack::Learn::place_and_speed, still));
  }
  track.set_speed({1.0, -2.0}, 0.5);
  for (std::int64_t t_us = 101'000; t_us <= 201'000; t_us += 1000) {
    track.predict(t_us, still);
    const Eigen::LLT<Eigen::Matrix3d> factor(track.covariance());
    ASSERT_EQ(factor.info(), Eigen::Success) << t_us << "\n" << track.covariance();
  }
}

TEST(CircleTrack, ADoubtedCircleTakesHalfOfAMeasurementThatIsAsSure) {
  CircleTrack track({60, 60, 15}, 100'000);
  const Eigen::Vector3d confident = Eigen::Vector3d::Constant(0.01);
  track.correct({60, 60, 15}, confident);
  ASSERT_LT(track.covariance().diagonal().maxCoeff(), 1e-3);
  const Eigen::Vector3d sd_px(2.0, 2.0, 1.0);
  track.inflate(sd_px);
  track.correct({64, 60, 17}, sd_px);
  EXPECT_NEAR(track.circle().x_px, 62.0, 0.1);
  EXPECT_NEAR(track.circle().y_px, 60.0, 0.1);
  EXPECT_NEAR(track.circle().r_px, 16.0, 0.1);
  EXPECT_NEAR(track.covariance()(0, 0), 2.0, 0.1);  // half of 2 px squared
  // One that is less sure already stays so.
  track.inflate(0.1);
  EXPECT_NEAR(track.covariance()(0, 0), 2.0, 0.1);
}

struct Followed {
  CircleTrack track;
  Eigen::Vector2d centre_px;  // where the circle is
  double worst_off_px = 0.0;  // of the track, while the image moves
};

/// Follows a circle that moves to and fro with `velocity_px_s` from 0.1 s on, 40 ms each way with as long a pause,
/// whose events come `latency_us` late. The camera's rotation makes the motion where `by_camera`.
Followed follow(const Eigen::Vector2d& velocity_px_s, std::int64_t latency_us, bool by_camera) {
  const auto motion = [&](std::int64_t t_us) -> Eigen::Vector2d {
    if (t_us < 100'000) return Eigen::Vector2d::Zero();
    const std::int64_t phase = (t_us - 100'000) / 40'000 % 4;
    return phase == 0   ? velocity_px_s
           : phase == 2 ? Eigen::Vector2d(-velocity_px_s)
                        : Eigen::Vector2d::Zero();
  };
  Followed f{CircleTrack({60, 60, 12}, 0), {60, 60}};
  f.track.set_speed(Eigen::Vector2d::Zero(), 0.0);
  Eigen::Vector2d shown_px = f.centre_px;
  for (std::int64_t t_us = 1000; t_us <= 900'000; t_us += 1000) {
    const Eigen::Vector2d camera = by_camera ? motion(t_us) : Eigen::Vector2d::Zero();
    f.centre_px += motion(t_us) * 1e-3;
    const Eigen::Vector2d shown_px_s = motion(t_us - latency_us);
    shown_px += shown_px_s * 1e-3;
    f.track.predict(t_us, camera);
    for (int i = 0; i < 16; ++i) {
      const double angle_rad = i * std::numbers::pi / 8;
      Edge edge = edge_on({shown_px.x(), shown_px.y(), 12}, angle_rad, t_us);
      edge.speed_px_s = edge.along.dot(shown_px_s);
      if (std::abs(edge.speed_px_s) < 20.0) continue;  // no event
      if (edge.speed_px_s < 0.0) {
        edge.along = -edge.along;
        edge.speed_px_s = -edge.speed_px_s;
      }
      f.track.measure(edge, 1.0, CircleTrack::Learn::place, camera);
    }
    if (t_us > 500'000 && !motion(t_us).isZero())
      f.worst_off_px = std::max(f.worst_off_px, (f.track.centre() - f.centre_px).norm());
  }
  return f;
}

TEST(CircleTrack, LearnsTheLatencyOfTheEventsFromTheMotionOfTheCamera) {
  const Followed late = follow({240, -120}, 8'000, true);
  EXPECT_NEAR(late.track.latency_s(), 0.008, 0.003);
  EXPECT_LT(late.worst_off_px, 1.0) << "the events are up to 2.1 px behind";
  const Followed at_once = follow({240, -120}, 0, true);
  EXPECT_NEAR(at_once.track.latency_s(), 0.0, 0.001);
  EXPECT_LT(at_once.worst_off_px, 1.0);
}

TEST(CircleTrack, FollowsATurnThatLasts) {
  // A circle that goes round once in a second, 25 px from the middle, and shows few edges.
  const auto place_px = [](std::int64_t t_us) {
    const double angle_rad = 2.0 * std::numbers::pi * static_cast<double>(t_us) * 1e-6;
    return Eigen::Vector2d(64 + 25 * std::cos(angle_rad), 64 + 25 * std::sin(angle_rad));
  };
  const Eigen::Vector2d still = Eigen::Vector2d::Zero();
  CircleTrack track({89, 64, 12}, 0);
  track.set_speed({0, 2.0 * std::numbers::pi * 25}, 0.0);
  double outward_px = 0.0;
  int ticks = 0;
  for (std::int64_t t_us = 1000; t_us <= 2'000'000; t_us += 1000) {
    track.predict(t_us, still);
    const Eigen::Vector2d at = place_px(t_us);
    const Eigen::Vector2d velocity_px_s = (at - place_px(t_us - 1000)) * 1e3;
    const double angle_rad = static_cast<double>(t_us / 1000) * 2.4;  // all round, one edge in a ms
    Edge edge = edge_on({at.x(), at.y(), 12}, angle_rad, t_us);
    if (edge.along.dot(velocity_px_s) < 0.0) edge.along = -edge.along;
    edge.speed_px_s = edge.along.dot(velocity_px_s);
    if (edge.speed_px_s > 20.0) track.measure(edge, 1.0, CircleTrack::Learn::place, still);
    if (t_us <= 1'000'000) continue;
    outward_px += (track.centre() - at).dot((at - Eigen::Vector2d(64, 64)) / 25.0);
    ++ticks;
  }
  EXPECT_LT(std::abs(outward_px / ticks), 0.25);
}

TEST(CircleTrack, LearnsNoLatencyFromAMotionOfItsOwn) {
  const Followed f = follow({120, -60}, 8'000, false);
  EXPECT_EQ(f.track.latency_s(), 0.0);
}

TEST(CircleTrack, CountsTheLongestTimesThat64BitsHoldAndNotMore) {
  constexpr std::int64_t earliest = std::numeric_limits<std::int64_t>::min();
  constexpr std::int64_t latest = std::numeric_limits<std::int64_t>::max();
  CircleTrack track({50.0, 40.0, 10.0}, earliest);
  track.set_speed({1.0, -2.0}, 0.0);
  const Circle then = track.circle_at(latest, Eigen::Vector2d::Zero());
  EXPECT_DOUBLE_EQ(then.x_px, 50.0 + 1e-6 * static_cast<double>(latest));
  EXPECT_DOUBLE_EQ(then.y_px, 40.0 - 2e-6 * static_cast<double>(latest));
  track.predict(latest, Eigen::Vector2d::Zero());
  EXPECT_EQ(track.silent_us(), latest);
  EXPECT_FALSE(track.measure({.t_us = earliest, .x = 60, .y = 40}, 1.0, CircleTrack::Learn::place,
                             Eigen::Vector2d::Zero()))
      << "an edge of long before";
}

}  // namespace
}  // namespace saccade
