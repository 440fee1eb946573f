#include "evaluation/calibration/calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "config/cameras.h"
#include "core/error.h"
#include "core/random.h"
#include "core/units.h"
#include "emulator/event_emulator.h"
#include "evaluation/calibration/grid_finder.h"
#include "head/icub_cameras.h"

namespace saccade {
namespace {

using testing::HasSubstr;

/// Dots without extent, which project to points.
DotGrid points_of_light() {
  DotGrid grid;
  grid.dot_diameter_m = 0.0;
  return grid;
}

Eigen::Isometry3d pose(const Eigen::Vector3d& at_m, const Eigen::Vector3d& turn_deg) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.translation() = at_m;
  const double angle = turn_deg.norm() * rad_per_deg;
  if (angle > 0.0) pose.linear() = Eigen::AngleAxisd(angle, turn_deg.normalized()).toRotationMatrix();
  return pose;
}

/// The dots of a board that rests at one pose after another while the eye turns and moves. Root is the eye's frame at
/// rest.
std::vector<CalibrationView> views_of(const MountedCamera& camera, const DotGrid& grid, double noise_px,
                                      int rests = 5, double tilt = 1.0, double turn = 1.0) {
  const RandomStream random(3, "calibration");
  const double to_side[5][2] = {{0, 0}, {0, 30}, {-28, 0}, {25, -20}, {0, -32}};
  std::vector<CalibrationView> views;
  for (int rest = 0; rest < rests; ++rest) {
    const auto& side = to_side[rest % 5];
    const Eigen::Isometry3d board = pose({0.01 * rest, -0.01, 0.27 + 0.02 * rest},
                                         tilt * Eigen::Vector3d(side[0], side[1], 20.0 * (rest - 2)));
    for (int i = 0; i < 12; ++i) {
      const auto number = static_cast<std::uint64_t>(100 * rest + i);
      const auto between = [&](double low, double high, std::uint64_t what) {
        return random.uniform(low, high, what, number);
      };
      const Eigen::Isometry3d eye =
          pose({between(-0.04, 0.04, 0), between(-0.04, 0.04, 1), between(-0.02, 0.02, 2)},
               turn * Eigen::Vector3d(between(-12, 12, 3), between(-12, 12, 4), between(-18, 18, 5)));
      const Eigen::Isometry3d camera_from_board = (eye * camera.mount.eye_from_camera()).inverse() * board;
      CalibrationView view;
      view.grid.t_us = 1'000'000 * rest + 50'000 * i;
      view.root_from_eye = eye;
      for (const cv::Point3d& p : grid.points_m()) {
        const auto at = camera.camera.project(camera_from_board * Eigen::Vector3d(p.x, p.y, p.z));
        const std::uint64_t dot = number * 100 + view.grid.dots_px.size();
        if (!at || !camera.camera.size.contains(static_cast<int>(at->x()), static_cast<int>(at->y()))) break;
        view.grid.dots_px.emplace_back(at->x() + noise_px * random.normal(6, dot),
                                       at->y() + noise_px * random.normal(7, dot));
      }
      if (view.grid.dots_px.size() == grid.dots()) views.push_back(view);
    }
  }
  return views;
}

const MountedCamera off_centre{icub_left_2016, {{1.0, -2.0, -10.0}, {0.5, -1.0, 1.5}}};

TEST(Calibration, RecoversCameraAndMountFromExactDots) {
  const DotGrid grid = points_of_light();
  const Calibration c =
      calibrate(views_of(off_centre, grid, 0.0), grid, {128, 128}, LensModel::radial_tangential, true);
  const Camera& camera = c.camera.camera;
  EXPECT_NEAR(camera.fx_px, 99.45, 1e-3);
  EXPECT_NEAR(camera.fy_px, 99.75, 1e-3);
  EXPECT_NEAR(camera.cx_px, 64.0, 1e-3);
  EXPECT_NEAR(camera.cy_px, 69.18, 1e-3);
  EXPECT_NEAR(camera.k1, icub_left_2016.k1, 1e-4);
  EXPECT_NEAR(camera.k2, icub_left_2016.k2, 1e-3);
  EXPECT_NEAR(camera.p1, icub_left_2016.p1, 1e-5);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(c.camera.mount.translation_mm[i], off_centre.mount.translation_mm[i], 0.01);
    EXPECT_NEAR(c.camera.mount.rotation_deg[i], off_centre.mount.rotation_deg[i], 0.002);
  }
  EXPECT_EQ(c.quality.rests, 5);
}

TEST(Calibration, HasStandardDeviationsThatCoverItsErrors) {
  const DotGrid grid = points_of_light();
  const Calibration c =
      calibrate(views_of(off_centre, grid, 0.1), grid, {128, 128}, LensModel::radial_tangential, true);
  const Camera& camera = c.camera.camera;
  const CalibrationDeviations& d = c.deviations;
  std::printf("fx %.3f +- %.3f, cy %.3f +- %.3f px, x %.2f +- %.2f mm\n", camera.fx_px, d.fx_px, camera.cy_px,
              d.cy_px, c.camera.mount.translation_mm[0], d.translation_mm[0]);
  // 4 standard deviations: one such test in 2000 would fail by chance, and this one always does the same.
  EXPECT_NEAR(camera.fx_px, 99.45, 4.0 * d.fx_px);
  EXPECT_NEAR(camera.fy_px, 99.75, 4.0 * d.fy_px);
  EXPECT_NEAR(camera.cx_px, 64.0, 4.0 * d.cx_px);
  EXPECT_NEAR(camera.cy_px, 69.18, 4.0 * d.cy_px);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_GT(d.translation_mm[i], 0.0);
    EXPECT_NEAR(c.camera.mount.translation_mm[i], off_centre.mount.translation_mm[i],
                4.0 * d.translation_mm[i]);
  }
  // The dots scatter by 0.1 px in x and in y.
  EXPECT_NEAR(c.quality.rms_px, 0.1 * std::numbers::sqrt2, 0.02);
}

const MountedCamera fisheye{camera_preset("davis346"), {{1.0, -2.0, -10.0}, {0.5, -1.0, 1.5}}};

TEST(Calibration, RecoversAFisheyeAndItsMountFromExactDots) {
  const DotGrid grid = points_of_light();
  const Calibration c = calibrate(views_of(fisheye, grid, 0.0, 10, 1.0, 2.0), grid, fisheye.camera.size,
                                  LensModel::fisheye, true);
  const Camera& camera = c.camera.camera;
  EXPECT_EQ(camera.lens, LensModel::fisheye);
  EXPECT_EQ(c.quality.held, 0);
  EXPECT_NEAR(camera.fx_px, fisheye.camera.fx_px, 1e-3);
  EXPECT_NEAR(camera.fy_px, fisheye.camera.fy_px, 1e-3);
  EXPECT_NEAR(camera.cx_px, fisheye.camera.cx_px, 1e-3);
  EXPECT_NEAR(camera.cy_px, fisheye.camera.cy_px, 1e-3);
  EXPECT_NEAR(camera.k1, fisheye.camera.k1, 1e-3);
  EXPECT_NEAR(camera.k2, fisheye.camera.k2, 1e-3);
  EXPECT_NEAR(camera.k3, fisheye.camera.k3, 1e-3);
  EXPECT_NEAR(camera.k4, fisheye.camera.k4, 1e-3);
  EXPECT_GT(c.quality.max_angle_deg, 40.0);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(c.camera.mount.translation_mm[i], fisheye.mount.translation_mm[i], 0.01);
    EXPECT_NEAR(c.camera.mount.rotation_deg[i], fisheye.mount.rotation_deg[i], 0.002);
  }
}

/// The largest distance between where two cameras see the same ray, over pixels of the first up to `angle_deg` off its axis.
double farthest_px(const Camera& a, const Camera& b, double angle_deg) {
  double worst_px = 0.0;
  for (int y = 0; y < a.size.height; y += 10) {
    for (int x = 0; x < a.size.width; x += 10) {
      const Eigen::Vector3d ray = a.ray(x, y);
      if (std::atan(ray.head<2>().norm()) > angle_deg * rad_per_deg) continue;
      const auto seen = b.project(ray);
      worst_px = std::max(worst_px, seen ? (*seen - Eigen::Vector2d(x, y)).norm() : 1e9);
    }
  }
  return worst_px;
}

TEST(Calibration, FindsAFisheyeInDotsWithNoiseAsFarOutAsTheyReach) {
  const DotGrid grid = points_of_light();
  const Calibration c = calibrate(views_of(fisheye, grid, 0.1, 6, 1.0, 2.0), grid, fisheye.camera.size,
                                  LensModel::fisheye, true);
  const Camera& camera = c.camera.camera;
  const CalibrationDeviations& d = c.deviations;
  const double worst_px = farthest_px(fisheye.camera, camera, c.quality.max_angle_deg);
  std::printf("fx %.3f +- %.3f, k1 %.4f +- %.4f, k4 %.4f +- %.4f, %d held; %.2f px up to %.1f deg\n",
              camera.fx_px, d.fx_px, camera.k1, d.k1, camera.k4, d.k4, static_cast<int>(c.quality.held),
              worst_px, c.quality.max_angle_deg);
  EXPECT_NEAR(camera.fx_px, fisheye.camera.fx_px, 4.0 * d.fx_px);
  EXPECT_NEAR(camera.fy_px, fisheye.camera.fy_px, 4.0 * d.fy_px);
  EXPECT_NEAR(camera.cx_px, fisheye.camera.cx_px, 4.0 * d.cx_px);
  EXPECT_NEAR(camera.cy_px, fisheye.camera.cy_px, 4.0 * d.cy_px);
  EXPECT_LT(worst_px, 0.5);
  EXPECT_NEAR(c.quality.rms_px, 0.1 * std::numbers::sqrt2, 0.02);
  // Another model of the lens does not fit these dots as well.
  const Calibration other = calibrate(views_of(fisheye, grid, 0.1, 6, 1.0, 2.0), grid, fisheye.camera.size,
                                      LensModel::radial_tangential, false);
  EXPECT_GT(other.quality.rms_px, 1.05 * c.quality.rms_px);
}

TEST(Calibration, WhatTheDotsDoNotTellOfAFisheyeIsHeldAtZero) {
  DotGrid grid = points_of_light();
  grid.spacing_m = 0.012;
  MountedCamera narrow = fisheye;
  narrow.camera.size = {128, 128};
  narrow.camera.cx_px = narrow.camera.cy_px = 63.5;
  const CalibrationLimits loose{.max_focal_deviation = 0.1,
                                .max_centre_deviation_px = 10.0,
                                .max_translation_deviation_mm = 100.0,
                                .max_rotation_deviation_deg = 10.0};
  const Calibration c =
      calibrate(views_of(narrow, grid, 0.1), grid, narrow.camera.size, LensModel::fisheye, true, loose);
  EXPECT_GE(c.quality.held, 2);
  EXPECT_EQ(c.camera.camera.k4, 0.0);
  EXPECT_EQ(c.deviations.k4, 0.0);
  EXPECT_EQ(c.camera.camera.k3, 0.0);
  EXPECT_NO_THROW(check_config("calibration", c.camera.camera));
  EXPECT_LT(farthest_px(narrow.camera, c.camera.camera, c.quality.max_angle_deg), 0.5);
}

std::string refusal(const std::vector<CalibrationView>& views, const DotGrid& grid, bool with_mount = true) {
  try {
    static_cast<void>(calibrate(views, grid, {128, 128}, LensModel::radial_tangential, with_mount));
  } catch (const RunError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Calibration, RejectsPoorViewsAndNamesWhatIsMissing) {
  const DotGrid grid = points_of_light();
  const auto all = views_of(off_centre, grid, 0.05);
  EXPECT_THAT(refusal({all.begin(), all.begin() + 8}, grid), HasSubstr("8 images"));
  auto fast = all;
  for (CalibrationView& view : fast) view.grid.speed_px_s = 100.0;
  EXPECT_THAT(refusal(fast, grid), HasSubstr("in 0 of them at less than"));
  EXPECT_THAT(refusal(views_of(off_centre, grid, 0.05, 2), grid), HasSubstr("rested at 2 poses"));
  EXPECT_EQ(refusal(views_of(off_centre, grid, 0.05, 2), grid, false), "accepted");
  EXPECT_THAT(refusal(views_of(off_centre, grid, 0.8), grid), HasSubstr("rms"));
  std::vector<CalibrationView> middle = all;
  for (CalibrationView& view : middle) {
    for (cv::Point2d& dot : view.grid.dots_px) dot = 0.4 * dot + cv::Point2d(38, 38);
  }
  EXPECT_THAT(refusal(middle, grid), HasSubstr("raster over the image"));
}

/// A board before a pinhole in full view: dark dots on white, as light.
std::vector<float> drawn(const DotGrid& grid, const Camera& camera, const cv::Point2d& shift_px,
                         std::vector<cv::Point2d>& dots_px) {
  constexpr double distance_m = 0.3;
  constexpr int finer = 4;
  dots_px.clear();
  for (const cv::Point3d& p : grid.points_m()) {
    dots_px.emplace_back(camera.cx_px + camera.fx_px * p.x / distance_m + shift_px.x,
                         camera.cy_px + camera.fy_px * p.y / distance_m + shift_px.y);
  }
  const double radius_px = 0.5 * grid.dot_diameter_m * camera.fx_px / distance_m;
  std::vector<float> light(static_cast<std::size_t>(camera.size.pixels()), 200.0F);
  for (const cv::Point2d& dot : dots_px) {
    for (int y = static_cast<int>(dot.y - radius_px - 1); y <= dot.y + radius_px + 1; ++y) {
      for (int x = static_cast<int>(dot.x - radius_px - 1); x <= dot.x + radius_px + 1; ++x) {
        if (!camera.size.contains(x, y)) continue;
        int covered = 0;
        for (int i = 0; i < finer * finer; ++i) {
          const double u = x + (i % finer + 0.5) / finer - 0.5 - dot.x;
          const double v = y + (i / finer + 0.5) / finer - 0.5 - dot.y;
          covered += std::hypot(u, v) < radius_px ? 1 : 0;
        }
        float& pixel = light[static_cast<std::size_t>(y * camera.size.width + x)];
        pixel = std::min(pixel, 200.0F - 190.0F * static_cast<float>(covered) / (finer * finer));
      }
    }
  }
  return light;
}

TEST(GridFinder, FindsTheDotsOfAMovingGridInItsEvents) {
  const DotGrid grid;
  const Camera camera = Camera{{128, 128}, 100.0, 100.0, 63.5, 63.5}.without_lens();
  EventEmulator emulator(emulator_preset("dvs128"), camera.size, 1);
  ReconstructedImage image(camera.size, 400'000, 500);
  std::vector<Event> events;
  std::vector<cv::Point2d> dots_px;
  // 20 px to the right and 5 down in 0.8 s, which is more than a dot, and rest.
  for (std::int64_t t_us = 0; t_us <= 900'000; t_us += 10'000) {
    const double way = std::min(1.0, static_cast<double>(t_us) / 800'000.0);
    events.clear();
    emulator.process_image(drawn(grid, camera, {-10.0 + 20.0 * way, -2.5 + 5.0 * way}, dots_px), t_us,
                           events);
    image.add(events);
  }
  const auto found = find_grid(image.image(900'000), grid);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->size(), dots_px.size());
  double worst_px = 0.0;
  for (std::size_t i = 0; i < dots_px.size(); ++i)
    worst_px = std::max(worst_px, cv::norm((*found)[i] - dots_px[i]));
  std::printf("worst dot %.3f px off\n", worst_px);
  EXPECT_LT(worst_px, 0.25);
}

TEST(GridFinder, FindsTheDotsOfALargeImageDespiteNoiseInEveryPixel) {
  const DotGrid grid;
  cv::Mat image(260, 346, CV_32F, cv::Scalar(1.0));
  std::vector<cv::Point2d> dots_px;
  for (const cv::Point3d& dot : grid.points_m())
    dots_px.emplace_back(cvRound(173.0 + 700.0 * dot.x), cvRound(130.0 + 700.0 * dot.y));
  for (const cv::Point2d& dot : dots_px) cv::circle(image, dot, 7, 0.0, cv::FILLED);
  cv::Mat noise(image.size(), CV_32F);
  cv::RNG random(1);
  random.fill(noise, cv::RNG::NORMAL, 0.0, 0.3);
  image = cv::max(cv::min(image + noise, 1.0), 0.0);
  const auto found = find_grid(image, grid);
  ASSERT_TRUE(found);
  for (std::size_t i = 0; i < dots_px.size(); ++i) EXPECT_LT(cv::norm((*found)[i] - dots_px[i]), 0.5) << i;
}

TEST(GridFinder, ADotWhoseCentroidMovesToTheImagesBorderIsNoDot) {
  // Columns 2, 1 and 0 are each darker than the next: the centroid moves to the border in the last of its rounds.
  cv::Mat image(12, 12, CV_32F, cv::Scalar(1.0));
  image.col(0) = 0.0;
  image.col(1) = 0.48;
  image.col(2) = 0.499;
  EXPECT_EQ(dot_centroid(image, {3.6, 5.0}, 1.5), std::nullopt);
  cv::Mat dot(12, 12, CV_32F, cv::Scalar(1.0));
  dot(cv::Rect(4, 5, 3, 3)) = 0.0;
  const auto found = dot_centroid(dot, {5.4, 6.3}, 3.0);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->x, 5.0, 0.05);
  EXPECT_NEAR(found->y, 6.0, 0.05);
}

TEST(GridFinder, FindsNoGridWithoutOne) {
  ReconstructedImage image({128, 128}, 400'000, 500);
  EXPECT_FALSE(find_grid(image.image(1'000'000), DotGrid{}));
}

}  // namespace
}  // namespace saccade
