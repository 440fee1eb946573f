#include "core/camera.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "core/random.h"

namespace saccade {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

Eigen::Vector3d random_point_m(const RandomStream& random, std::uint64_t i) {
  return {random.uniform(-1.0, 1.0, 0, i), random.uniform(-1.0, 1.0, 1, i), random.uniform(0.2, 2.0, 2, i)};
}

/// The outline by brute force: the rays that touch the sphere meet it on a circle, here a polygon.
struct Outline {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius_px = 0.0;  ///< sqrt(ab) = sqrt(area / pi)
};
Outline brute_outline(const PinholeCamera& camera, const Eigen::Vector3d& centre_m, double radius_m) {
  const double sine = radius_m / centre_m.norm();
  const Eigen::Vector3d axis = centre_m.normalized();
  const Eigen::Vector3d u = axis.unitOrthogonal();
  const Eigen::Vector3d v = axis.cross(u);
  constexpr int corners = 20'000;
  Outline outline;
  double twice_area = 0.0;
  Eigen::Vector2d previous;
  for (int i = 0; i <= corners; ++i) {
    const double phi = 2.0 * std::numbers::pi * i / corners;
    const Eigen::Vector3d touch =
        centre_m * (1.0 - sine * sine) +
        radius_m * std::sqrt(1.0 - sine * sine) * (std::cos(phi) * u + std::sin(phi) * v);
    const Eigen::Vector2d pixel = camera.project(touch).value();
    if (i > 0) {
      const double cross = previous.x() * pixel.y() - previous.y() * pixel.x();
      twice_area += cross;
      outline.centre += (previous + pixel) * cross;
    }
    previous = pixel;
  }
  outline.centre /= 3.0 * twice_area;  // centroid of the polygon
  outline.radius_px = std::sqrt(std::abs(twice_area) / 2.0 / std::numbers::pi);
  return outline;
}

TEST(PinholeCamera, ProjectsARayBackToItsPixel) {
  const PinholeCamera camera;
  const RandomStream random(1, "camera");
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const Eigen::Vector3d point = random_point_m(random, i);
    const auto pixel = camera.project(point);
    ASSERT_TRUE(pixel);
    const Eigen::Vector3d ray = camera.ray(pixel->x(), pixel->y());
    EXPECT_EQ(ray.z(), 1.0);
    EXPECT_LT((ray * point.z() - point).norm(), 1e-12);
  }
}

TEST(PinholeCamera, SeesTheOpticalAxisAtThePrincipalPointAndXRightYDown) {
  const PinholeCamera camera;
  EXPECT_EQ(*camera.project({0, 0, 3}), Eigen::Vector2d(64.00, 69.18));
  EXPECT_GT(camera.project({0.1, 0, 1})->x(), 64.0);
  EXPECT_GT(camera.project({0, 0.1, 1})->y(), 69.18);
  EXPECT_NEAR(camera.project({1, 0, 1})->x(), 64.0 + 99.45, 1e-12);
  EXPECT_NEAR(camera.project({0, 1, 1})->y(), 69.18 + 99.75, 1e-12);
}

TEST(PinholeCamera, DoesNotProjectWhatIsNotInFront) {
  const PinholeCamera camera;
  EXPECT_FALSE(camera.project({0, 0, 0}));
  EXPECT_FALSE(camera.project({0.1, 0, -1}));
  EXPECT_FALSE(camera.project({0, 0, std::nan("")}));
  EXPECT_FALSE(camera.project_sphere({0, 0, -1}, 0.05));
  EXPECT_FALSE(camera.project_sphere({0, 0, 0.04}, 0.05));    // the camera is inside
  EXPECT_FALSE(camera.project_sphere({0.5, 0, 0.04}, 0.05));  // partly behind
  EXPECT_TRUE(camera.project_sphere({0.5, 0, 0.06}, 0.05));
}

TEST(PinholeCamera, ProjectsASphereToItsOutline) {
  const PinholeCamera camera;
  const RandomStream random(2, "sphere");
  double worst_px = 0.0;
  for (std::uint64_t i = 0; i < 200; ++i) {
    const Eigen::Vector3d centre = random_point_m(random, i);
    const double radius = random.uniform(0.01, 0.15, 3, i);
    const auto circle = camera.project_sphere(centre, radius);
    ASSERT_TRUE(circle);
    const Outline outline = brute_outline(camera, centre, radius);
    // The polygon of 20,000 corners is short of the ellipse by 2e-8 of its size.
    const double scale = 1.0 + outline.radius_px + outline.centre.norm();
    worst_px = std::max({worst_px, std::abs(circle->x_px - outline.centre.x()) / scale,
                         std::abs(circle->y_px - outline.centre.y()) / scale,
                         std::abs(circle->r_px - outline.radius_px) / scale});
  }
  std::printf("worst difference from the brute-force outline: %.2e of its size\n", worst_px);
  EXPECT_LT(worst_px, 1e-6);
}

TEST(PinholeCamera, HoldsEveryPointOfTheSphereInsideTheOutlinesExtent) {
  // A second way, by the surface: the extremes of an ellipse lie symmetrically around its centre.
  const PinholeCamera camera;
  const Eigen::Vector3d centre(0.12, -0.08, 0.30);
  Eigen::Vector2d low(1e9, 1e9);
  Eigen::Vector2d high = -low;
  for (int i = 0; i <= 1500; ++i) {
    for (int k = 0; k < 3000; ++k) {
      const double theta = std::numbers::pi * i / 1500;
      const double phi = 2 * std::numbers::pi * k / 3000;
      const Eigen::Vector3d normal(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                                   std::cos(theta));
      const Eigen::Vector2d pixel = *camera.project(centre + 0.0475 * normal);
      low = low.cwiseMin(pixel);
      high = high.cwiseMax(pixel);
    }
  }
  const auto circle = camera.project_sphere(centre, 0.0475);
  ASSERT_TRUE(circle);
  EXPECT_NEAR(circle->x_px, (low.x() + high.x()) / 2, 1e-3);
  EXPECT_NEAR(circle->y_px, (low.y() + high.y()) / 2, 1e-3);
}

TEST(PinholeCamera, PutsTheOutlineOffTheProjectedCentreAwayFromTheAxis) {
  // The ball of 95 mm at 0.30 m and 28 deg: 1.8 px.
  const PinholeCamera camera;
  const Eigen::Vector3d centre = 0.30 * Eigen::Vector3d(std::sin(28 * degree), 0.0, std::cos(28 * degree));
  const auto circle = camera.project_sphere(centre, 0.0475);
  ASSERT_TRUE(circle);
  const double apart_px =
      std::hypot(circle->x_px - camera.project(centre)->x(), circle->y_px - camera.project(centre)->y());
  std::printf("outline centre is %.3f px from the projected centre\n", apart_px);
  EXPECT_NEAR(apart_px, 1.8, 0.05);
  EXPECT_GT(circle->x_px, camera.project(centre)->x());
  // On the axis the two agree, and the radius is f R / sqrt(Z^2 - R^2).
  const auto ahead = camera.project_sphere({0, 0, 0.30}, 0.0475);
  EXPECT_NEAR(ahead->x_px, 64.0, 1e-9);
  EXPECT_NEAR(ahead->y_px, 69.18, 1e-9);
  EXPECT_NEAR(ahead->r_px, std::sqrt(99.45 * 99.75) * 0.0475 / std::sqrt(0.09 - 0.0475 * 0.0475), 1e-9);
}

TEST(PinholeCamera, RotationalFlowIsHowTheProjectionOfAStillPointMoves) {
  const Eigen::Vector3d turn_rad_s(0.3, -0.7, 0.5);
  const PinholeCamera camera;
  const double dt_s = 1e-6;
  for (const auto& [u, v] : {std::pair{10.0, 20.0}, {64.0, 69.0}, {120.0, 100.0}}) {
    const Eigen::Vector3d point = 2.0 * camera.ray(u, v);
    // A still point turns the other way in the camera's frame.
    const Eigen::Vector3d moved = point - turn_rad_s.cross(point) * dt_s;
    const Eigen::Vector2d expected = (*camera.project(moved) - *camera.project(point)) / dt_s;
    EXPECT_TRUE(camera.rotational_flow_px_s(u, v, turn_rad_s).isApprox(expected, 1e-4));
  }
}

}  // namespace
}  // namespace saccade
