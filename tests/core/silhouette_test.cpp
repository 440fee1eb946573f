#include "core/tracker/silhouette.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <limits>
#include <numbers>

#include "core/random.h"

namespace saccade {
namespace {

struct Scene {
  Circle hole{64.3, 61.8, 10.6};
  double outside_per_px2 = 0.3;
  double inside_per_px2 = 0.005;
  double hand_from_rad = 10.0;  ///< from this direction on (to pi) nothing happens outside either
};

/// Events of one instant in a square around the hole, each in a pixel: one that the hole covers wholly makes
/// as many as the inside, another as many as the outside.
Silhouette seen(const Scene& scene, std::uint64_t seed, std::int64_t t_us = 0) {
  Silhouette silhouette;
  const RandomStream random(seed, "scene");
  std::uint64_t n = 0;
  for (int y = 40; y <= 84; ++y) {
    for (int x = 42; x <= 86; ++x, ++n) {
      const double dx = x - scene.hole.x_px, dy = y - scene.hole.y_px;
      const bool inside = std::hypot(dx, dy) < scene.hole.r_px - 0.35;
      const bool hand = std::atan2(dy, dx) > scene.hand_from_rad;
      const double density = inside || hand ? scene.inside_per_px2 : scene.outside_per_px2;
      if (std::hypot(dx, dy) < scene.hole.r_px + 6.0 && random.uniform(0.0, 1.0, n, 0) < density) {
        silhouette.add(Eigen::Vector2d(x, y), Eigen::Vector2d::Zero(), t_us);
      }
    }
  }
  return silhouette;
}

TEST(Silhouette, FindsTheOutlineFromAPixelAndAHalfAway) {
  double squares = 0.0;
  int found = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    const Scene scene;
    const Silhouette silhouette = seen(scene, seed);
    Circle circle = scene.hole;
    circle.x_px += 1.0;
    circle.y_px -= 1.0;
    circle.r_px -= 0.5;
    for (int look = 0; look < 4; ++look) {
      const auto fit = silhouette.fit(circle, Eigen::Vector2d::Zero(), 1000);
      ASSERT_TRUE(fit);
      circle = fit->circle;
    }
    ++found;
    squares += std::pow(circle.x_px - scene.hole.x_px, 2) + std::pow(circle.y_px - scene.hole.y_px, 2);
  }
  const double rms_px = std::sqrt(squares / found);
  std::cout << "off by " << rms_px << " px (root mean square)\n";
  EXPECT_LT(rms_px, 0.8);
}

TEST(Silhouette, IgnoresDirectionsWithoutEventsOutside) {
  // The hand: a third of the surroundings is as silent as the ball.
  double y_px = 0.0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Scene scene;
    scene.hand_from_rad = std::numbers::pi / 3.0;
    const auto fit = seen(scene, seed).fit(scene.hole, Eigen::Vector2d::Zero(), 1000);
    ASSERT_TRUE(fit);
    y_px += (fit->circle.y_px - scene.hole.y_px) / 20.0;
  }
  std::cout << "off by " << y_px << " px towards the hand on average\n";
  EXPECT_LT(std::abs(y_px), 0.5);
}

TEST(Silhouette, HasNoFitIfInsideAndOutsideHaveTheSameDensity) {
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Scene scene;
    scene.inside_per_px2 = scene.outside_per_px2;
    const auto fit = seen(scene, seed).fit(scene.hole, Eigen::Vector2d::Zero(), 1000);
    if (fit) {
      EXPECT_LT(fit->seen * fit->emptiness, 0.35);
    }
  }
}

TEST(Silhouette, HasNoFitWithoutEvents) {
  Scene scene;
  scene.outside_per_px2 = scene.inside_per_px2;
  EXPECT_FALSE(seen(scene, 1).fit(scene.hole, Eigen::Vector2d::Zero(), 1000));
}

TEST(Silhouette, IgnoresOldEvents) {
  const Scene scene;
  const Silhouette silhouette = seen(scene, 1);
  EXPECT_TRUE(silhouette.fit(scene.hole, Eigen::Vector2d::Zero(), 49'000));
  EXPECT_FALSE(silhouette.fit(scene.hole, Eigen::Vector2d::Zero(), 51'000));
  EXPECT_FALSE(silhouette.fit(scene.hole, Eigen::Vector2d::Zero(), std::numeric_limits<std::int64_t>::max()));
  EXPECT_FALSE(seen(scene, 1, std::numeric_limits<std::int64_t>::min())
                   .fit(scene.hole, Eigen::Vector2d::Zero(), std::numeric_limits<std::int64_t>::max()));
}

TEST(Silhouette, MovesWithTheCircle) {
  const Scene scene;
  const Silhouette silhouette = seen(scene, 1);
  const Eigen::Vector2d carried(7.0, -4.0);
  Circle moved = scene.hole;
  moved.x_px += carried.x();
  moved.y_px += carried.y();
  const auto at_rest = silhouette.fit(scene.hole, Eigen::Vector2d::Zero(), 1000);
  const auto carried_fit = silhouette.fit(moved, carried, 1000);
  ASSERT_TRUE(at_rest && carried_fit);
  EXPECT_NEAR(carried_fit->circle.x_px, at_rest->circle.x_px + carried.x(), 1e-9);
  EXPECT_NEAR(carried_fit->circle.y_px, at_rest->circle.y_px + carried.y(), 1e-9);
}

}  // namespace
}  // namespace saccade
