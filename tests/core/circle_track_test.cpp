#include "core/circle_track.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
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

}  // namespace
}  // namespace saccade
