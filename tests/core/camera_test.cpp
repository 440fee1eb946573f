#include "core/camera.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/random.h"
#include "core/units.h"
#include "head/icub_cameras.h"

namespace saccade {
namespace {

Eigen::Vector3d random_point_m(const RandomStream& random, std::uint64_t i) {
  return {random.uniform(-1.0, 1.0, 0, i), random.uniform(-1.0, 1.0, 1, i), random.uniform(0.2, 2.0, 2, i)};
}

/// The outline by brute force: the rays that touch the sphere meet it on a circle, here a polygon.
struct Outline {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius_px = 0.0;  ///< sqrt(ab) = sqrt(area / pi)
};
Outline brute_outline(const Camera& camera, const Eigen::Vector3d& centre_m, double radius_m) {
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

/// As calibrated on the robot (iCubGenova02: icubEyes_DVS.ini, 2016; icubEyes.ini, 2017).
const std::vector<std::pair<const char*, Camera>> calibrated{
    {"DVS left", icub_left_2016},
    {"DVS right", {{128, 128}, 99.8, 99.8, 59.336, 63.761, -0.219021, 0.085382, -0.00071211, -0.00171136}},
    {"ATIS left",
     {{304, 240}, 198.516, 198.583, 155.675, 115.426, -0.326302, 0.101052, -0.00470766, -0.000842836}},
    {"ATIS right",
     {{304, 240}, 179.845, 180.251, 151.772, 117.758, -0.331165, 0.105876, -0.00359664, -0.00022332}},
    {"with k3",
     {{346, 260},
      260.3,
      259.8,
      172.1,
      131.4,
      -0.33,
      0.15,
      0.0008,
      -0.0005,
      LensModel::radial_tangential,
      -0.03}}};

TEST(Camera, ProjectsTheRayOfEveryPixelBackToIt) {
  for (const auto& [name, camera] : calibrated) {
    double worst_px = 0.0;
    for (double v = -0.5; v <= camera.size.height; v += 0.5) {
      for (double u = -0.5; u <= camera.size.width; u += 0.5) {
        const Eigen::Vector3d ray = camera.ray(u, v);
        EXPECT_EQ(ray.z(), 1.0);
        const auto pixel = camera.project(2.0 * ray);
        ASSERT_TRUE(pixel) << name << " " << u << " " << v;
        worst_px = std::max(worst_px, (*pixel - Eigen::Vector2d(u, v)).norm());
      }
    }
    std::printf("%s: worst %.1e px\n", name, worst_px);
    EXPECT_LT(worst_px, 1e-9) << name;
  }
}

TEST(Camera, IsTheExactPinholeWithoutALens) {
  const Camera camera = icub_left_2016.without_lens();
  EXPECT_FALSE(camera.has_lens());
  EXPECT_TRUE(icub_left_2016.has_lens());
  const RandomStream random(1, "camera");
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const Eigen::Vector3d point = random_point_m(random, i);
    const auto pixel = camera.project(point);
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x(), 64.00 + 99.45 * point.x() / point.z(), 1e-10);
    EXPECT_NEAR(pixel->y(), 69.18 + 99.75 * point.y() / point.z(), 1e-10);
    EXPECT_EQ(camera.ray(pixel->x(), pixel->y()),
              Eigen::Vector3d((pixel->x() - 64.00) / 99.45, (pixel->y() - 69.18) / 99.75, 1.0));
  }
}

TEST(Camera, ProjectsTheOpticalAxisToThePrincipalPointWithXRightAndYDown) {
  const Camera camera = icub_left_2016;
  EXPECT_EQ(*camera.project({0, 0, 3}), Eigen::Vector2d(64.00, 69.18));
  EXPECT_GT(camera.project({0.1, 0, 1})->x(), 64.0);
  EXPECT_GT(camera.project({0, 0.1, 1})->y(), 69.18);
  // By hand: 1 + k1 + k2 = 1.531809 at (1, 0), and p2 three times along, p1 once across; (0, 1) likewise.
  EXPECT_NEAR(camera.project({1, 0, 1})->x(), 64.0 + 99.45 * (1.531809 + 3.0 * -0.0059468), 1e-12);
  EXPECT_NEAR(camera.project({1, 0, 1})->y(), 69.18 + 99.75 * -0.0016571, 1e-12);
  EXPECT_NEAR(camera.project({0, 1, 1})->x(), 64.0 + 99.45 * -0.0059468, 1e-12);
  EXPECT_NEAR(camera.project({0, 1, 1})->y(), 69.18 + 99.75 * (1.531809 + 3.0 * -0.0016571), 1e-12);
}

TEST(Camera, ProjectsNoPointOutsideTheFieldOfTheLens) {
  // Of k1 = -0.3 alone x (1 - 0.3 x^2) is largest, 0.703, at x = 1.054.
  Camera camera = icub_left_2016.without_lens();
  camera.k1 = -0.3;
  EXPECT_TRUE(camera.project({1.05, 0, 1}));
  EXPECT_FALSE(camera.project({1.06, 0, 1}));
  EXPECT_FALSE(camera.project({1.7, 0, 1}));  // would be beside the principal point
  EXPECT_TRUE(camera.project_sphere({0.9, 0, 1}, 0.1));
  EXPECT_FALSE(camera.project_sphere({1.0, 0, 1}, 0.1));
  EXPECT_NEAR(camera.ray(64.0 + 0.70 * 99.45, 69.18).x(), 1.0, 1e-9);
  EXPECT_TRUE(std::isnan(camera.ray(64.0 + 0.71 * 99.45, 69.18).x()));
}

TEST(Camera, EndsAtTheFirstTurnOfALensWithK3) {
  // Of k3 = -0.1 alone x (1 - 0.1 x^6) is largest, 0.9109, at x = (1 / 0.7)^(1/6) = 1.0612.
  Camera camera = icub_left_2016.without_lens();
  camera.k3 = -0.1;
  EXPECT_TRUE(camera.has_lens());
  EXPECT_TRUE(camera.project({1.061, 0, 1}));
  EXPECT_FALSE(camera.project({1.0613, 0, 1}));
  EXPECT_NEAR(camera.project({1, 0, 1})->x(), 64.0 + 99.45 * 0.9, 1e-12);
  EXPECT_TRUE(std::isnan(camera.ray(64.0 + 0.92 * 99.45, 69.18).x()));
}

TEST(Camera, AcceptsTheLensesOfTheRobotAndRejectsOneThatIsNotInvertibleInTheCorners) {
  for (const auto& [name, camera] : calibrated) EXPECT_NO_THROW(check_config(name, camera));
  EXPECT_NO_THROW(check_config("none", icub_left_2016.without_lens()));
  EXPECT_THROW(check_config("without numbers", Camera{}), InputError);
  Camera folded = icub_left_2016.without_lens();
  folded.k1 = -0.3;  // reaches 70 px from the principal point; the farthest corner is 94 px away
  try {
    check_config("camera", folded);
    FAIL() << "taken";
  } catch (const InputError& error) {
    ASSERT_EQ(error.problems().size(), 1U);
    EXPECT_EQ(error.problems()[0].place, "camera.k1");
    EXPECT_EQ(error.problems()[0].value, "-0.3");
  }
  folded.size = {64, 64};
  folded.cx_px = folded.cy_px = 31.5;
  EXPECT_NO_THROW(check_config("camera", folded));
}

// The left DAVIS346 of MVSEC (Zhu et al., RA-L 3(3), 2018).
Camera fisheye() {
  Camera camera = icub_left_2016.without_lens();
  camera.size = {346, 260};
  camera.fx_px = 226.38;
  camera.fy_px = 226.15;
  camera.cx_px = 173.647;
  camera.cy_px = 133.733;
  camera.lens = LensModel::fisheye;
  camera.k1 = -0.0480314;
  camera.k2 = 0.0113310;
  camera.k3 = -0.0553782;
  camera.k4 = 0.0215010;
  return camera;
}

TEST(FisheyeCamera, ProjectsTheRayOfEveryPixelBackToIt) {
  Camera wide = fisheye().without_distortion();  // equidistant, 140 deg from left to right
  wide.fx_px = wide.fy_px = 141.6;
  for (const Camera& camera : {fisheye(), wide}) {
    double worst_px = 0.0;
    for (double v = -0.5; v <= camera.size.height; v += 1.5) {
      for (double u = -0.5; u <= camera.size.width; u += 1.5) {
        const auto pixel = camera.project(2.0 * camera.ray(u, v));
        ASSERT_TRUE(pixel) << u << " " << v;
        worst_px = std::max(worst_px, (*pixel - Eigen::Vector2d(u, v)).norm());
      }
    }
    EXPECT_LT(worst_px, 1e-9);
    EXPECT_NO_THROW(check_config("camera", camera));
  }
}

TEST(FisheyeCamera, ShowsAnglesAtDistancesInProportionWhereItHasNoDistortion) {
  const Camera camera = fisheye().without_distortion();
  EXPECT_TRUE(camera.has_lens());
  for (const double angle_rad : {0.0, 1e-7, 0.3, 1.0, 1.5}) {
    const auto pixel = camera.project({std::sin(angle_rad), 0.0, std::cos(angle_rad)});
    ASSERT_TRUE(pixel);
    EXPECT_NEAR(pixel->x(), camera.cx_px + camera.fx_px * angle_rad, 1e-9);
    EXPECT_NEAR(pixel->y(), camera.cy_px, 1e-12);
  }
  EXPECT_FALSE(camera.project({1.0, 0.0, -1e-9}));
  EXPECT_FALSE(camera.without_lens().has_lens());
}

TEST(FisheyeCamera, MovesAPixelAsTheDifferenceOfTwoProjections) {
  const Camera camera = fisheye();
  constexpr double step_rad = 1e-6;
  for (const Eigen::Vector3d& axis :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0.3, 0.4, 0.8)}) {
    const Eigen::Vector3d ray = camera.ray(300.0, 40.0);
    const Eigen::Vector3d later = ray - step_rad * axis.cross(ray);  // a camera that turns by +, a scene by -
    const Eigen::Vector2d moved = (*camera.project(later) - *camera.project(ray)) / step_rad;
    EXPECT_LT((moved - camera.rotational_flow_px_s(ray, axis)).norm(), 1e-3);
  }
}

TEST(FisheyeCamera, ShowsABallAsTheCentroidOfItsOutline) {
  const Camera camera = fisheye();
  for (const Eigen::Vector3d& centre_m : {Eigen::Vector3d(0, 0, 0.5), Eigen::Vector3d(0.3, -0.1, 0.35)}) {
    constexpr double radius_m = 0.0475;
    const auto circle = camera.project_sphere(centre_m, radius_m);
    ASSERT_TRUE(circle);
    // Pixels of a fifth inside the cone that the ball fills.
    double count = 0.0;
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    const double cos_cone = std::sqrt(1.0 - radius_m * radius_m / centre_m.squaredNorm());
    for (double v = circle->y_px - 45.0; v < circle->y_px + 45.0; v += 0.2) {
      for (double u = circle->x_px - 45.0; u < circle->x_px + 45.0; u += 0.2) {
        if (!(camera.ray(u, v).normalized().dot(centre_m.normalized()) > cos_cone)) continue;
        count += 0.04;
        sum += 0.04 * Eigen::Vector2d(u, v);
      }
    }
    EXPECT_NEAR(circle->r_px, std::sqrt(count / std::numbers::pi), 0.02);
    EXPECT_NEAR(circle->x_px, sum.x() / count, 0.02);
    EXPECT_NEAR(circle->y_px, sum.y() / count, 0.02);
  }
}

TEST(FisheyeCamera, IsRejectedWhereItShowsAPixelAtMoreThan90DegFromItsAxis) {
  Camera camera = fisheye().without_distortion();
  camera.fx_px = camera.fy_px = 100.0;  // the left border is 99 deg from the axis
  EXPECT_THROW(check_config("camera", camera), InputError);
}

TEST(Camera, ProjectsNoPointBehindTheCamera) {
  const Camera camera = icub_left_2016;
  EXPECT_FALSE(camera.project({0, 0, 0}));
  EXPECT_FALSE(camera.project({0.1, 0, -1}));
  EXPECT_FALSE(camera.project({0, 0, std::nan("")}));
  EXPECT_FALSE(camera.project_sphere({0, 0, -1}, 0.05));
  EXPECT_FALSE(camera.project_sphere({0, 0, 0.04}, 0.05));    // the camera is inside
  EXPECT_FALSE(camera.project_sphere({0.5, 0, 0.04}, 0.05));  // partly behind
  EXPECT_TRUE(camera.project_sphere({0.5, 0, 0.06}, 0.05));
}

TEST(Camera, ProjectsASphereToItsOutlineWithAndWithoutALens) {
  const RandomStream random(2, "sphere");
  auto cameras = calibrated;
  cameras.emplace_back("no lens", icub_left_2016.without_lens());
  for (const auto& [name, camera] : cameras) {
    double worst = 0.0;
    int count = 0;
    for (std::uint64_t i = 0; i < 60; ++i) {
      const Eigen::Vector3d centre = random_point_m(random, i);
      const double radius = random.uniform(0.01, 0.15, 3, i);
      const auto circle = camera.project_sphere(centre, radius);
      if (!circle) continue;
      ++count;
      const Outline outline = brute_outline(camera, centre, radius);
      // The polygon of 20,000 corners is short of the outline by 2e-8 of its size.
      const double scale = 1.0 + outline.radius_px + outline.centre.norm();
      worst = std::max({worst, std::abs(circle->x_px - outline.centre.x()) / scale,
                        std::abs(circle->y_px - outline.centre.y()) / scale,
                        std::abs(circle->r_px - outline.radius_px) / scale});
    }
    std::printf("%s: worst difference from the brute-force outline of %d: %.2e of its size\n", name, count,
                worst);
    EXPECT_LT(worst, 1e-6) << name;
    EXPECT_GT(count, 30) << name;
  }
}

TEST(Camera, ProjectsASphereToCentreAndSemiAxesOfAnEllipseWithoutALens) {
  const Camera camera = icub_left_2016.without_lens();
  const RandomStream random(3, "sphere");
  for (std::uint64_t i = 0; i < 100; ++i) {
    const Eigen::Vector3d d = random_point_m(random, i);
    const double radius = random.uniform(0.01, 0.15, 3, i);
    // Along x alone the outline spans from tan(angle - half) to tan(angle + half); turned there about z.
    const double off_axis = std::atan2(d.head<2>().norm(), d.z());
    const double half = std::asin(radius / d.norm());
    const double far = std::tan(off_axis + half);
    const double near = std::tan(off_axis - half);
    const double a = 0.5 * (far - near);
    // Across it the cone is cut at the ellipse's centre: b^2 = a^2 (1 - e^2), e = sin(off axis) / cos(half).
    const double b = a * std::sqrt(1.0 - std::pow(std::sin(off_axis) / std::cos(half), 2));
    const Eigen::Vector2d centre = 0.5 * (far + near) * d.head<2>().normalized();
    const auto circle = camera.project_sphere(d, radius);
    ASSERT_TRUE(circle);
    EXPECT_NEAR(circle->x_px, 64.00 + 99.45 * centre.x(), 1e-9);
    EXPECT_NEAR(circle->y_px, 69.18 + 99.75 * centre.y(), 1e-9);
    EXPECT_NEAR(circle->r_px, std::sqrt(99.45 * 99.75 * a * b), 1e-9);
  }
}

TEST(Camera, ProjectsEveryPointOfTheSphereInsideTheOutline) {
  // A second way, by the surface: the extremes of an ellipse lie symmetrically around its centre.
  const Camera camera = icub_left_2016.without_lens();
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

TEST(Camera, TheOutlineIsFurtherFromTheAxisThanTheProjectedCentre) {
  // The ball of 95 mm at 0.30 m and 28 deg: 1.8 px.
  const Camera camera = icub_left_2016.without_lens();
  const Eigen::Vector3d centre =
      0.30 * Eigen::Vector3d(std::sin(28 * rad_per_deg), 0.0, std::cos(28 * rad_per_deg));
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

TEST(Camera, RotationalFlowIsTheImageVelocityOfARestingPoint) {
  const Eigen::Vector3d turn_rad_s(0.3, -0.7, 0.5);
  const double dt_s = 1e-6;
  auto cameras = calibrated;
  cameras.emplace_back("no lens", icub_left_2016.without_lens());
  for (const auto& [name, camera] : cameras) {
    for (const auto& [u, v] :
         {std::pair{0.0, 0.0}, {10.0, 20.0}, {64.0, 69.0}, {120.0, 100.0}, {3.0, 127.0}}) {
      const Eigen::Vector3d ray = camera.ray(u, v);
      // A still point turns the other way in the camera's frame.
      const Eigen::Vector3d before = 2.0 * (ray + turn_rad_s.cross(ray) * dt_s);
      const Eigen::Vector3d after = 2.0 * (ray - turn_rad_s.cross(ray) * dt_s);
      const Eigen::Vector2d expected = (*camera.project(after) - *camera.project(before)) / (2.0 * dt_s);
      EXPECT_LT((camera.rotational_flow_px_s(ray, turn_rad_s) - expected).norm(), 1e-6 * expected.norm())
          << name << " " << u << " " << v;
    }
  }
}

}  // namespace
}  // namespace saccade
