#include "control/target.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>

#include "core/error.h"
#include "core/random.h"
#include "head/icub_cameras.h"

namespace saccade {
namespace {

const double nan = std::numeric_limits<double>::quiet_NaN();
const double infinity = std::numeric_limits<double>::infinity();

TEST(Target, InvertsTheOutlineOfASphereOverTheWholeImageAndBeyond) {
  const Camera camera = icub_left_2016.without_lens();
  const RandomStream random(1, "target");
  double worst_m = 0.0;
  for (std::uint64_t i = 0; i < 20000; ++i) {
    const double radius_m = random.uniform(0.01, 0.09, 0, i);
    const Eigen::Vector3d ray =
        camera.ray(random.uniform(-30.0, 158.0, 1, i), random.uniform(-30.0, 158.0, 2, i));
    const Eigen::Vector3d centre = ray.normalized() * random.uniform(1.5 * radius_m + 0.05, 3.0, 3, i);
    const auto circle = camera.project_sphere(centre, radius_m);
    if (!circle) continue;
    worst_m = std::max(worst_m, (sphere_from_circle(*circle, camera, radius_m) - centre).norm());
  }
  EXPECT_LT(worst_m, 1e-9);
}

TEST(Target, InvertsTheOutlineOfASphereThroughTheLens) {
  const Camera atis{{304, 240}, 198.516,  198.583,     155.675,     115.426,
                    -0.326302,  0.101052, -0.00470766, -0.000842836};
  for (const Camera& camera : {icub_left_2016, atis}) {
    const RandomStream random(3, "target");
    double worst_inside_m = 0.0;
    double worst_m = 0.0;
    int inside = 0;
    for (std::uint64_t i = 0; i < 10000; ++i) {
      const Eigen::Vector3d ray = camera.ray(random.uniform(-0.5, camera.size.width - 0.5, 1, i),
                                             random.uniform(-0.5, camera.size.height - 0.5, 2, i));
      const Eigen::Vector3d centre = ray.normalized() * random.uniform(0.25, 0.60, 3, i);
      const auto circle = camera.project_sphere(centre, 0.0475);
      ASSERT_TRUE(circle);
      const double error_m = (sphere_from_circle(*circle, camera, 0.0475) - centre).norm();
      ASSERT_TRUE(std::isfinite(error_m)) << circle->x_px << " " << circle->y_px << " " << circle->r_px;
      worst_m = std::max(worst_m, error_m);
      const bool is_inside = circle->x_px - circle->r_px > -0.5 && circle->y_px - circle->r_px > -0.5 &&
                             circle->x_px + circle->r_px < camera.size.width - 0.5 &&
                             circle->y_px + circle->r_px < camera.size.height - 0.5;
      if (!is_inside) continue;
      ++inside;
      worst_inside_m = std::max(worst_inside_m, error_m);
    }
    std::printf("%dx%d: worst %.1e m of %d balls wholly inside, %.1e m of those partly\n", camera.size.width,
                camera.size.height, worst_inside_m, inside, worst_m);
    EXPECT_GT(inside, 4000);
    EXPECT_LT(worst_inside_m, 1e-9);
    EXPECT_LT(worst_m, 1e-9);
  }
}

TEST(Target, LocatesEveryCircleThatADetectorCanFindThroughTheLens) {
  const Camera camera = icub_left_2016;
  const RandomStream random(4, "target");
  for (std::uint64_t i = 0; i < 10000; ++i) {
    const Circle circle{random.uniform(-0.5, 127.5, 0, i), random.uniform(-0.5, 127.5, 1, i),
                        random.uniform(4.0, 35.0, 2, i)};
    const Eigen::Vector3d sphere = sphere_from_circle(circle, camera, 0.0475);
    ASSERT_TRUE(sphere.allFinite()) << circle.x_px << " " << circle.y_px << " " << circle.r_px;
    const auto back = camera.project_sphere(sphere, 0.0475);
    EXPECT_NEAR(back->x_px, circle.x_px, 1e-8);
    EXPECT_NEAR(back->y_px, circle.y_px, 1e-8);
    EXPECT_NEAR(back->r_px, circle.r_px, 1e-8);
  }
}

TEST(Target, IsExactForAWideAnglePinholeWithUnequalFocalLengths) {
  Camera camera = icub_left_2016.without_lens();
  camera.fx_px = 40.0;
  camera.fy_px = 55.0;
  const RandomStream random(2, "target");
  int seen = 0;
  for (std::uint64_t i = 0; i < 5000; ++i) {
    const double radius_m = 0.0475;
    const Eigen::Vector3d ray =
        camera.ray(random.uniform(0.0, 127.0, 1, i), random.uniform(0.0, 127.0, 2, i));
    const Eigen::Vector3d centre = ray.normalized() * random.uniform(0.10, 1.0, 3, i);
    const auto circle = camera.project_sphere(centre, radius_m);
    if (!circle) continue;
    ++seen;
    EXPECT_LT((sphere_from_circle(*circle, camera, radius_m) - centre).norm(), 1e-9);
  }
  EXPECT_GT(seen, 3000);
}

TEST(Target, TheAuthorsMapGives45CentimetresForTenPixelsAnd30ForSixteen) {
  TargetConfig config;
  config.depth = DepthModel::authors_linear;
  const TargetLocator locator(config);
  const Camera camera = icub_left_2016;
  for (const auto& [r_px, z_m] : {std::pair{10.0, 0.45}, {16.0, 0.30}, {20.0, 0.20}}) {
    const Target target = locator.locate({90.0, 30.0, r_px}, camera, Eigen::Isometry3d::Identity());
    ASSERT_EQ(target.status, TargetStatus::ok);
    EXPECT_NEAR(target.point_m.z(), z_m, 1e-12);
    const auto pixel = camera.project(target.point_m);
    EXPECT_NEAR(pixel->x(), 90.0, 1e-9);
    EXPECT_NEAR(pixel->y(), 30.0, 1e-9);
  }
}

TEST(Target, BothDepthModelsAgreeOnTheBallOf95MillimetresWithinThreeCentimetres) {
  TargetConfig linear;
  linear.depth = DepthModel::authors_linear;
  for (const double r_px : {10.0, 12.0, 14.0, 16.0}) {
    const Circle circle{64.0, 69.18, r_px};
    const auto z = [&](const TargetConfig& config) {
      return TargetLocator(config).locate(circle, icub_left_2016, Eigen::Isometry3d::Identity()).point_m.z();
    };
    EXPECT_NEAR(z(TargetConfig{}), z(linear), 0.03);
  }
}

TEST(Target, IsGivenInTheRootFrame) {
  Eigen::Isometry3d root_from_cam = Eigen::Isometry3d::Identity();
  root_from_cam.linear() << 0, 0, -1, 1, 0, 0, 0, -1, 0;
  root_from_cam.translation() << -0.0564, -0.034, 0.34685;
  const Camera camera = icub_left_2016;
  const Eigen::Vector3d ball_root(-0.5, 0.05, 0.30);
  const auto circle = camera.project_sphere(root_from_cam.inverse() * ball_root, 0.0475);
  const Target target = TargetLocator({}).locate(*circle, camera, root_from_cam);
  ASSERT_EQ(target.status, TargetStatus::ok);
  EXPECT_LT((target.point_m - ball_root).norm(), 1e-9);
}

TEST(Target, RejectsInvalidCirclesAndReportsWhy) {
  const Camera camera = icub_left_2016;
  const Eigen::Isometry3d here = Eigen::Isometry3d::Identity();
  TargetConfig linear;
  linear.depth = DepthModel::authors_linear;
  const TargetLocator pinhole({});
  const auto status = [&](const TargetLocator& locator, const Circle& circle) {
    return locator.locate(circle, camera, here).status;
  };
  for (const double bad : {nan, infinity, -infinity}) {
    EXPECT_EQ(status(pinhole, {bad, 60, 12}), TargetStatus::not_finite);
    EXPECT_EQ(status(pinhole, {60, bad, 12}), TargetStatus::not_finite);
    EXPECT_EQ(status(pinhole, {60, 60, bad}), TargetStatus::not_finite);
  }
  Eigen::Isometry3d lost = here;
  lost.translation().x() = nan;
  EXPECT_EQ(pinhole.locate({60, 60, 12}, camera, lost).status, TargetStatus::not_finite);
  EXPECT_EQ(status(pinhole, {60, 60, 0}), TargetStatus::bad_radius);
  EXPECT_EQ(status(pinhole, {60, 60, -3}), TargetStatus::bad_radius);
  EXPECT_EQ(status(pinhole, {64, 69.18, 60}), TargetStatus::too_near);
  EXPECT_EQ(status(TargetLocator(linear), {64, 69.18, 25}), TargetStatus::too_near);
  EXPECT_EQ(status(TargetLocator(linear), {64, 69.18, 29}), TargetStatus::behind);
}

TEST(Target, ExtremeCirclesNeverGiveATargetThatIsNotFinite) {
  const TargetLocator locator({});
  for (const double r_px : {1e-300, 1e-9, 1e3, 1e9, 1e300}) {
    for (const double x_px : {-1e9, 64.0, 1e9, 1e300}) {
      const Target target = locator.locate({x_px, 60.0, r_px}, icub_left_2016, Eigen::Isometry3d::Identity());
      EXPECT_TRUE(target.status != TargetStatus::ok || target.point_m.allFinite());
    }
  }
}

TEST(Target, ABadConfigurationIsAnInputError) {
  TargetConfig config;
  config.min_distance_m = 11.0;
  config.ball_diameter_m = -1.0;
  try {
    const TargetLocator locator(config);
    FAIL() << "taken";
  } catch (const InputError& error) {
    EXPECT_EQ(error.problems().size(), 3u) << "and the least distance is above the largest";
  }
}

// ---- both eyes -----------------------------------------------------------------------------------

constexpr double baseline_m = 0.068;
const Eigen::Vector3d left_eye_m(0.0, -baseline_m / 2, 0.0);
const Eigen::Vector3d right_eye_m(0.0, baseline_m / 2, 0.0);

std::optional<Eigen::Vector3d> triangulate_freely(const Eigen::Vector3d& left, const Eigen::Vector3d& right) {
  return triangulate({left_eye_m, left}, {right_eye_m, right}, 1e-3, 0.1);
}

TEST(Triangulation, IsExactForExactBearingsWhateverTheirLength) {
  const RandomStream random(4, "triangulation");
  double worst_m = 0.0;
  for (std::uint64_t i = 0; i < 1000; ++i) {
    const Eigen::Vector3d point_m(-random.uniform(0.15, 2.0, 0, i), random.uniform(-0.3, 0.3, 1, i),
                                  random.uniform(-0.3, 0.3, 2, i));
    const auto met_m = triangulate_freely(random.uniform(0.1, 9.0, 3, i) * (point_m - left_eye_m),
                                          random.uniform(0.1, 9.0, 4, i) * (point_m - right_eye_m));
    ASSERT_TRUE(met_m);
    worst_m = std::max(worst_m, (*met_m - point_m).norm());
  }
  std::printf("worst %.1e m\n", worst_m);
  EXPECT_LT(worst_m, 1e-11);
}

TEST(Triangulation, ErrsByDistanceSquaredOverTheBaseline) {
  const double noise_rad = 0.002;  // a fifth of a pixel, in each direction of each bearing
  const RandomStream random(5, "triangulation");
  for (const double distance_m : {0.25, 0.5, 1.0}) {
    double squares = 0.0;
    constexpr std::uint64_t trials = 4000;
    for (std::uint64_t i = 0; i < trials; ++i) {
      const Eigen::Vector3d point_m(-distance_m, 0.0, 0.0);
      const auto blurred = [&](const Eigen::Vector3d& ray, std::uint64_t k) {
        return Eigen::Vector3d(ray.normalized() + noise_rad * Eigen::Vector3d(0.0, random.normal(k, i),
                                                                              random.normal(k + 1, i)));
      };
      const auto met_m =
          triangulate_freely(blurred(point_m - left_eye_m, 0), blurred(point_m - right_eye_m, 2));
      ASSERT_TRUE(met_m);
      squares += std::pow(met_m->x() - point_m.x(), 2);
    }
    const double expected_m = std::sqrt(2.0) * noise_rad * distance_m * distance_m / baseline_m;
    const double found_m = std::sqrt(squares / static_cast<double>(trials));
    std::printf("%.2f m: distance errs by %.1f mm, expected %.1f mm\n", distance_m, 1e3 * found_m,
                1e3 * expected_m);
    EXPECT_NEAR(found_m / expected_m, 1.0, 0.1);
  }
}

TEST(Triangulation, HasNoPointIfTheRaysAreNearlyParallelSkewOrIntersectBehind) {
  const Eigen::Vector3d ahead(-1.0, 0.0, 0.0);
  EXPECT_FALSE(triangulate_freely(ahead, ahead));
  EXPECT_FALSE(triangulate_freely(ahead, {-1.0, -0.0009, 0.0}));
  EXPECT_TRUE(triangulate_freely(ahead, {-1.0, -0.0011, 0.0}));
  EXPECT_FALSE(triangulate_freely({-1.0, -0.05, 0.0}, {-1.0, 0.05, 0.0})) << "they part: they meet behind";
  const Eigen::Vector3d inwards(-1.0, -0.15, 0.0);
  EXPECT_TRUE(triangulate_freely(ahead, {inwards.x(), inwards.y(), 0.09}));
  EXPECT_FALSE(triangulate_freely(ahead, {inwards.x(), inwards.y(), 0.12})) << "they pass each other";
  EXPECT_FALSE(triangulate_freely(ahead, {nan, 0.0, 0.0}));
  EXPECT_FALSE(triangulate({left_eye_m, ahead}, {left_eye_m, inwards}, 1e-3, 0.1)) << "no baseline";
}

TEST(Stereo, CorrectsADistanceErrorFromTheRadiusInTheLeftEye) {
  Eigen::Isometry3d root_from_right_cam = Eigen::Isometry3d::Identity();
  root_from_right_cam.linear() << 0, 0, -1, 1, 0, 0, 0, -1, 0;
  root_from_right_cam.translation() = right_eye_m;
  const Eigen::Vector3d ball_m(-0.45, 0.05, 0.04);
  const auto circle = icub_right_2016.project_sphere(root_from_right_cam.inverse() * ball_m, 0.0475);
  const Eigen::Vector3d wrong_m = left_eye_m + 1.3 * (ball_m - left_eye_m);
  const auto mended_m =
      StereoLocator({}).locate(wrong_m, left_eye_m, *circle, icub_right_2016, root_from_right_cam);
  ASSERT_TRUE(mended_m);
  EXPECT_LT((*mended_m - ball_m).norm(), 1e-9);

  Circle higher = *circle;
  higher.y_px -= 5.0;
  EXPECT_FALSE(StereoLocator({}).locate(wrong_m, left_eye_m, higher, icub_right_2016, root_from_right_cam))
      << "something else";
  EXPECT_FALSE(
      StereoLocator({}).locate(wrong_m, left_eye_m, {60, 60, -1}, icub_right_2016, root_from_right_cam));
}

TEST(TargetLocator, ATargetInTheRobotsBodyOrTooFarAwayIsRejected) {
  TargetConfig config;
  config.max_distance_m = 1.0;
  const TargetLocator locator(config);
  const Camera camera = icub_left_2016;
  // A camera 0.35 m above the origin that looks down onto a point 5 cm in front of it.
  Eigen::Isometry3d above = Eigen::Isometry3d::Identity();
  above.translation() << -0.05, 0.0, 0.35;
  above.linear() << 0, -1, 0, 1, 0, 0, 0, 0, -1;
  above.linear().col(0) = above.linear().col(1).cross(above.linear().col(2));
  const auto seen = camera.project_sphere({0.0, 0.0, 0.33}, config.ball_diameter_m / 2);
  ASSERT_TRUE(seen);
  EXPECT_EQ(locator.locate(*seen, camera, above).status, TargetStatus::in_body);
  above.translation().x() = -0.40;
  EXPECT_EQ(locator.locate(*seen, camera, above).status, TargetStatus::ok);
  const auto far = camera.project_sphere({0.0, 0.0, 1.2}, config.ball_diameter_m / 2);
  ASSERT_TRUE(far);
  EXPECT_EQ(locator.locate(*far, camera, above).status, TargetStatus::too_far);
}

}  // namespace
}  // namespace saccade
