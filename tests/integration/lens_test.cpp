#include <gtest/gtest.h>

#include <cstdio>
#include <opencv2/calib3d.hpp>
#include <utility>
#include <vector>

#include "core/camera.h"
#include "head/icub_cameras.h"

namespace saccade {
namespace {

const Camera dvs = icub_left_2016;
const Camera atis{{304, 240}, 198.516,  198.583,     155.675,     115.426,
                  -0.326302,  0.101052, -0.00470766, -0.000842836};

cv::Matx33d matrix_of(const Camera& c) {
  return {c.fx_px, 0.0, c.cx_px, 0.0, c.fy_px, c.cy_px, 0.0, 0.0, 1.0};
}
cv::Vec4d distortion_of(const Camera& c) { return {c.k1, c.k2, c.p1, c.p2}; }

std::vector<cv::Point2d> pixels_of(const Camera& camera) {
  std::vector<cv::Point2d> pixels;
  for (int y = 0; y < camera.size.height; ++y) {
    for (int x = 0; x < camera.size.width; ++x) pixels.emplace_back(x, y);
  }
  return pixels;
}

TEST(Lens, FindsTheRaysThatOpenCvFinds) {
  for (const Camera& camera : {dvs, atis}) {
    const std::vector<cv::Point2d> pixels = pixels_of(camera);
    std::vector<cv::Point2d> rays;
    cv::undistortPoints(pixels, rays, matrix_of(camera), distortion_of(camera), cv::noArray(), cv::noArray(),
                        cv::TermCriteria(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 200, 1e-13));
    double worst = 0.0;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
      const Eigen::Vector3d ray = camera.ray(pixels[i].x, pixels[i].y);
      worst = std::max(worst, (ray.head<2>() - Eigen::Vector2d(rays[i].x, rays[i].y)).norm());
    }
    std::printf("%dx%d: worst difference %.1e\n", camera.size.width, camera.size.height, worst);
    EXPECT_LT(worst, 1e-9);
  }
}

TEST(Lens, ProjectsAsOpenCvProjects) {
  for (const Camera& camera : {dvs, atis}) {
    std::vector<cv::Point3d> points;
    for (const cv::Point2d& pixel : pixels_of(camera)) {
      const Eigen::Vector3d point = (0.2 + 1e-3 * pixel.x) * camera.ray(pixel.x, pixel.y);
      points.emplace_back(point.x(), point.y(), point.z());
    }
    std::vector<cv::Point2d> seen;
    cv::projectPoints(points, cv::Vec3d(), cv::Vec3d(), matrix_of(camera), distortion_of(camera), seen);
    double worst_px = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto pixel = camera.project({points[i].x, points[i].y, points[i].z});
      ASSERT_TRUE(pixel);
      worst_px = std::max(worst_px, (*pixel - Eigen::Vector2d(seen[i].x, seen[i].y)).norm());
    }
    std::printf("%dx%d: worst difference %.1e px\n", camera.size.width, camera.size.height, worst_px);
    EXPECT_LT(worst_px, 1e-9);
  }
}

}  // namespace
}  // namespace saccade
