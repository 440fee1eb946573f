#include "sim/eye_renderer.h"

#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"
#include "core/random.h"
#include "core/units.h"
#include "emulator/event_emulator.h"
#include "head/icub_cameras.h"
#include "sim/lab.h"
#include "sim/mujoco_compat.h"
#include "sim/scene_renderer.h"

namespace saccade {
namespace {

using Eigen::Vector3d;

/// A camera at the origin in the pose of an iCub eye (it looks along root -x), one sphere that tests move,
/// a wall behind, and uniform light only.
constexpr const char* test_world = R"(
<mujoco>
  <visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
  <worldbody>
    <camera name="eye" pos="0 0 0" xyaxes="0 1 0 0 0 1"/>
    <geom name="wall" type="box" pos="-3 0 0" size="0.01 9 9" rgba="0.2 0.2 0.2 1"/>
    <body name="ball" mocap="true">
      <geom name="ball" type="sphere" size="0.05" rgba="0.8 0.8 0.8 1" contype="0" conaffinity="0"/>
    </body>
    <body name="screen" mocap="true" pos="9 0 0">
      <geom name="screen" type="box" size="0.001 0.5 0.5" rgba="0.5 0.5 0.5 1" contype="0" conaffinity="0"/>
    </body>
  </worldbody>
</mujoco>)";

class Renderer : public ::testing::Test {
 protected:
  void SetUp() override {
    try {
      gl_ = GlContext::create("auto");
    } catch (const RunError& error) {
      GTEST_SKIP() << "NOT TESTED, there is no OpenGL: " << error.what();
    }
    const MjVfsPtr vfs(new mjVFS);
    mj_defaultVFS(vfs.get());
    ASSERT_TRUE(add_to_vfs(vfs.get(), "test.xml", test_world));
    std::array<char, 1000> error{};
    model_.reset(mj_loadXML("test.xml", vfs.get(), error.data(), static_cast<int>(error.size())));
    ASSERT_NE(model_, nullptr) << error.data();
    data_.reset(mj_makeData(model_.get()));
    image_.resize(static_cast<std::size_t>(camera_.size.pixels()));
  }

  EyeRenderer make_eye(EyeRenderConfig config = {}) { return {*model_, *gl_, camera_, config}; }

  void set_ball_radius(double radius_m) {
    const int ball = mj_name2id(model_.get(), mjOBJ_GEOM, "ball");
    model_->geom_size[3 * ball] = radius_m;
    model_->geom_rbound[ball] = radius_m;
  }
  /// `point_m` in the OpenCV camera frame: x right = root y, y down = root -z, z forward = root -x.
  void place(int mocap, const Vector3d& point_m) {
    data_->mocap_pos[3 * mocap + 0] = -point_m.z();
    data_->mocap_pos[3 * mocap + 1] = point_m.x();
    data_->mocap_pos[3 * mocap + 2] = -point_m.y();
  }
  void draw(EyeRenderer& eye) {
    mj_kinematics(model_.get(), data_.get());
    mj_camlight(model_.get(), data_.get());
    eye.render(*data_, 0, image_);
  }
  /// A point at depth `z_m` that projects to the pixel.
  Vector3d at_pixel(double x_px, double y_px, double z_m) const { return z_m * camera_.ray(x_px, y_px); }

  struct Blob {
    double area_px = 0.0;
    double x_px = 0.0;
    double y_px = 0.0;
  };
  /// Area and centroid of the difference from the wall, with the ball's brightness as one.
  Blob measure_ball(const std::vector<float>& background) const {
    double ball = 0.0;
    for (std::size_t i = 0; i < image_.size(); ++i) {
      ball = std::max(ball, static_cast<double>(image_[i] - background[i]));
    }
    Blob blob;
    for (int y = 0; y < camera_.size.height; ++y) {
      for (int x = 0; x < camera_.size.width; ++x) {
        const auto i = static_cast<std::size_t>(y * camera_.size.width + x);
        const double share = static_cast<double>(image_[i] - background[i]) / ball;
        blob.area_px += share;
        blob.x_px += share * x;
        blob.y_px += share * y;
      }
    }
    blob.x_px /= blob.area_px;
    blob.y_px /= blob.area_px;
    return blob;
  }

  static constexpr int the_ball = 0;  // mocap bodies
  static constexpr int the_screen = 1;
  Camera camera_ = icub_left_2016;
  std::unique_ptr<GlContext> gl_;
  MjModelPtr model_;
  MjDataPtr data_;
  std::vector<float> image_;
};

// The border of a disc of 6 px radius crosses about 75 of the half-pixel samples, and each is in or out at
// random: an area error uniform in +-1/8 px^2, lever up to 6 px. That is a standard deviation of 0.024 px
// per axis of the centroid; 81 places stay below 4 of them, their mean below 4 / 9.
TEST_F(Renderer, DrawsASphereWhereThePinholeProjectsItOverTheWholeImage) {
  camera_ = camera_.without_lens();
  EyeRenderer eye = make_eye();
  place(the_ball, {0.0, 0.0, -1.0});
  draw(eye);
  const std::vector<float> background = image_;
  set_ball_radius(0.03);
  double worst = 0.0;
  double sum_x = 0.0;
  double sum_y = 0.0;
  int count = 0;
  for (double y = 9.0; y < 120.0; y += 13.7) {
    for (double x = 9.0; x < 120.0; x += 13.7) {
      const Vector3d point = at_pixel(x, y, 0.5);
      place(the_ball, point);
      draw(eye);
      const Circle truth = *camera_.project_sphere(point, 0.03);
      const Blob blob = measure_ball(background);
      worst = std::max(worst, std::hypot(blob.x_px - truth.x_px, blob.y_px - truth.y_px));
      sum_x += blob.x_px - truth.x_px;
      sum_y += blob.y_px - truth.y_px;
      ++count;
    }
  }
  EXPECT_LT(worst, 0.1);
  EXPECT_LT(std::abs(sum_x / count), 0.01) << "a bias over the image";
  EXPECT_LT(std::abs(sum_y / count), 0.01);
  std::printf("centroid: worst %.4f px, bias %.4f %.4f px\n", worst, sum_x / count, sum_y / count);
}

// Where the lens stretches the image, samples are fewer: 40 % as many in the corners.
TEST_F(Renderer, DrawsASphereWhereTheLensShowsItOverTheWholeImage) {
  EyeRenderer eye = make_eye();
  place(the_ball, {0.0, 0.0, -1.0});
  draw(eye);
  const std::vector<float> background = image_;
  EXPECT_THAT(background, ::testing::Each(::testing::FloatNear(51.0F, 0.01F)));
  set_ball_radius(0.03);
  double worst = 0.0;
  double worst_radius = 0.0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (double y = 9.5; y < 120.0; y += 13.6) {
    for (double x = 9.5; x < 120.0; x += 13.6) {
      const Vector3d point = at_pixel(x, y, 0.5);
      const Circle truth = *camera_.project_sphere(point, 0.03);
      const Eigen::Vector2d from_middle(truth.x_px - 63.5, truth.y_px - 63.5);
      if (from_middle.cwiseAbs().maxCoeff() + truth.r_px > 63.0) continue;
      place(the_ball, point);
      draw(eye);
      const Blob blob = measure_ball(background);
      const Eigen::Vector2d off(blob.x_px - truth.x_px, blob.y_px - truth.y_px);
      worst = std::max(worst, off.norm());
      worst_radius =
          std::max(worst_radius, std::abs(std::sqrt(blob.area_px / std::numbers::pi) - truth.r_px));
      sum += off;
      ++count;
    }
  }
  std::printf("centroid at %d places: worst %.4f px, bias %.4f %.4f px; radius: worst %.4f px\n", count,
              worst, sum.x() / count, sum.y() / count, worst_radius);
  EXPECT_GT(count, 60);
  EXPECT_LT(worst, 0.15);
  EXPECT_LT(worst_radius, 0.15);
  EXPECT_LT(sum.norm() / count, 0.02) << "a bias over the image";
}

TEST_F(Renderer, PlacesEveryPixelExactlyWithManySamples) {
  const Camera with_lens = camera_;
  for (const Camera& camera : {with_lens.without_lens(), with_lens}) {
    camera_ = camera;
    EyeRenderer eye = make_eye({.supersampling = 8});
    place(the_ball, {0.0, 0.0, -1.0});
    draw(eye);
    const std::vector<float> background = image_;
    set_ball_radius(0.02);
    double worst = 0.0;
    for (const auto& [x, y] :
         {std::pair{9.0, 9.0}, {118.5, 9.2}, {9.3, 118.0}, {118.1, 118.4}, {64.0, 69.18}}) {
      const Vector3d point = at_pixel(x, y, 0.5);
      place(the_ball, point);
      draw(eye);
      const Circle truth = *camera_.project_sphere(point, 0.02);
      const Blob blob = measure_ball(background);
      worst = std::max(worst, std::hypot(blob.x_px - truth.x_px, blob.y_px - truth.y_px));
    }
    EXPECT_LT(worst, 0.02);
    std::printf("centroid, 8 x 8 samples, %s: worst %.4f px\n", camera.has_lens() ? "lens" : "pinhole",
                worst);
  }
}

TEST_F(Renderer, DrawsTheImageOfALensThatShowsMoreThanThePinhole) {
  camera_ = {{304, 240}, 198.516, 198.583, 155.675, 115.426, -0.326302, 0.101052, -0.00470766, -0.000842836};
  image_.resize(static_cast<std::size_t>(camera_.size.pixels()));
  EyeRenderer eye = make_eye();
  place(the_ball, {0.0, 0.0, -1.0});
  draw(eye);
  const std::vector<float> background = image_;
  EXPECT_THAT(background, ::testing::Each(::testing::FloatNear(51.0F, 0.01F)));
  set_ball_radius(0.03);
  double worst = 0.0;
  for (const auto& [x, y] :
       {std::pair{14.0, 14.0}, {289.5, 13.2}, {14.3, 225.0}, {289.1, 225.4}, {155.6, 115.4}}) {
    const Vector3d point = at_pixel(x, y, 0.5);
    place(the_ball, point);
    draw(eye);
    const Circle truth = *camera_.project_sphere(point, 0.03);
    const Blob blob = measure_ball(background);
    worst = std::max(worst, std::hypot(blob.x_px - truth.x_px, blob.y_px - truth.y_px));
    EXPECT_NEAR(std::sqrt(blob.area_px / std::numbers::pi), truth.r_px, 0.05);
  }
  EXPECT_LT(worst, 0.1);
  std::printf("centroid, ATIS: worst %.4f px\n", worst);
}

// The polyhedron has the area of the true outline to 0.1 %, so the radius to 0.05 %.
TEST_F(Renderer, DrawsASphereAsLargeAsItsOutline) {
  EyeRenderer eye = make_eye();
  place(the_ball, {0.0, 0.0, -1.0});
  draw(eye);
  const std::vector<float> background = image_;
  double worst = 0.0;
  for (const double radius : {0.03, 0.0475, 0.07}) {
    set_ball_radius(radius);
    for (const auto& [x, y] : {std::pair{40.0, 41.0}, {64.3, 69.7}, {88.6, 52.2}, {61.0, 86.1}}) {
      const Vector3d point = at_pixel(x, y, 0.25);
      place(the_ball, point);
      draw(eye);
      const Circle truth = *camera_.project_sphere(point, radius);
      const Blob blob = measure_ball(background);
      worst = std::max(worst, std::abs(std::sqrt(blob.area_px / std::numbers::pi) - truth.r_px));
    }
  }
  EXPECT_LT(worst, 0.05);
  std::printf("radius: worst %.4f px\n", worst);
}

TEST_F(Renderer, ResamplesColumnsWithoutLossForAnyRatioOfFocalLengths) {
  camera_ = camera_.without_lens();
  for (const double fx : {70.0, 99.45, 120.0}) {
    camera_.fx_px = fx;
    EyeRenderer eye = make_eye();
    place(the_ball, {0.0, 0.0, -1.0});
    draw(eye);
    const std::vector<float> background = image_;
    // The wall is even, so every pixel must be: 0.2 of 255 grey levels.
    EXPECT_THAT(background, ::testing::Each(::testing::FloatNear(51.0F, 0.01F)));
    set_ball_radius(0.03);
    const Vector3d point = at_pixel(100.2, 30.4, 0.4);
    place(the_ball, point);
    draw(eye);
    const Circle truth = *camera_.project_sphere(point, 0.03);
    const Blob blob = measure_ball(background);
    EXPECT_NEAR(blob.x_px, truth.x_px, 0.05) << fx;
    EXPECT_NEAR(blob.y_px, truth.y_px, 0.05) << fx;
    EXPECT_NEAR(std::sqrt(blob.area_px / std::numbers::pi), truth.r_px, 0.05) << fx;
  }
}

TEST_F(Renderer, ReportsAFreeBallAsVisibleAndOneBehindAsHidden) {
  EyeRenderer eye = make_eye();
  for (const double z : {0.2, 0.45, 1.5}) {
    const Vector3d point = at_pixel(70.0, 60.0, z);
    place(the_ball, point);
    draw(eye);
    EXPECT_EQ(eye.visible_share(point, 0.05), 1.0) << z;
  }
  EXPECT_EQ(eye.visible_share({0.0, 0.0, -0.5}, 0.05), 0.0);
  EXPECT_EQ(eye.visible_share({3.0, 0.0, 0.5}, 0.05), 0.0);
}

TEST_F(Renderer, MeasuresOneHalfOfABallHalfOutOfTheImage) {
  EyeRenderer eye = make_eye();
  for (const auto& [x, y] : {std::pair{-0.5, 60.0}, {127.5, 60.0}, {70.0, -0.5}, {70.0, 127.5}}) {
    // So far away that its outline is nearly a circle around the projected centre.
    const Vector3d point = at_pixel(x, y, 1.0);
    place(the_ball, point);
    draw(eye);
    const Circle circle = *camera_.project_sphere(point, 0.05);
    const double shift = std::hypot(circle.x_px - x, circle.y_px - y);
    EXPECT_NEAR(eye.visible_share(point, 0.05), 0.5, 0.02 + shift / circle.r_px) << x << " " << y;
  }
}

TEST_F(Renderer, MeasuresThePartOfABallThatTheLensShowsInsideTheImage) {
  EyeRenderer eye = make_eye();
  double worst = 0.0;
  for (const auto& [x, y] : {std::pair{0.0, 0.0},
                             {-4.0, 3.0},
                             {127.0, 127.0},
                             {125.0, 2.0},
                             {1.0, 131.0},
                             {4.0, 126.0},
                             {64.0, 130.0},
                             {-3.0, 60.0},
                             {120.0, 9.0}}) {
    const Vector3d point = at_pixel(x, y, 0.4);
    place(the_ball, point);
    draw(eye);
    // The same count with independent rays.
    int all = 0;
    int inside = 0;
    for (double v = point.y() / point.z() - 0.4; v < point.y() / point.z() + 0.4; v += 0.002) {
      for (double u = point.x() / point.z() - 0.4; u < point.x() / point.z() + 0.4; u += 0.002) {
        const Vector3d ray(u, v, 1.0);
        if (point.cross(ray).norm() > 0.05 * ray.norm()) continue;
        ++all;
        const auto pixel = camera_.project(ray);
        inside += pixel && (pixel->array() > -0.5).all() && (pixel->array() < 127.5).all() ? 1 : 0;
      }
    }
    const double expected = static_cast<double>(inside) / all;
    const double share = eye.visible_share(point, 0.05);
    EXPECT_NEAR(share, expected, 0.02) << x << " " << y;
    worst = std::max(worst, std::abs(share - expected));
  }
  std::printf("share inside the image: worst difference %.4f\n", worst);
}

TEST_F(Renderer, MeasuresABallThatNearlyTouchesTheCamera) {
  // Its outline is far larger than the image: the share is the area of the image over that of the ellipse, at once.
  camera_ = {{128, 128}, 100.0, 100.0, 63.5, 63.5, 0.0, 0.0, 0.0, 0.0};
  EyeRenderer eye = make_eye({.near_m = 0.001});
  for (const double over : {1e-3, 1e-6, 1e-9, 1e-12}) {
    const double radius_m = 0.05;
    const Vector3d point(0.0, 0.0, radius_m * (1.0 + over));
    place(the_ball, {0.0, 0.0, -5.0});  // nothing is in front of where the ball would be
    draw(eye);
    const double outline_px = 100.0 * radius_m / std::sqrt(point.z() * point.z() - radius_m * radius_m);
    const double expected = 128.0 * 128.0 / (std::numbers::pi * outline_px * outline_px);
    EXPECT_NEAR(eye.visible_share(point, radius_m), expected, 0.01 * expected) << over;
  }
  // Close to the plane of the camera and far to its side.
  const double share = eye.visible_share({0.4, 0.0, 0.05 * (1.0 + 1e-9)}, 0.05);
  EXPECT_GE(share, 0.0);
  EXPECT_LT(share, 1e-3);
}

TEST_F(Renderer, ExcludesThePartOfABallBehindAnotherObject) {
  EyeRenderer eye = make_eye();
  const Vector3d point(0.0, 0.0, 0.6);
  place(the_ball, point);
  place(the_screen, {0.5, 0.0, 0.3});  // its left edge is on the axis
  draw(eye);
  EXPECT_NEAR(eye.visible_share(point, 0.05), 0.5, 0.02);
  place(the_screen, {0.0, 0.0, 0.3});
  draw(eye);
  EXPECT_EQ(eye.visible_share(point, 0.05), 0.0);
  place(the_screen, {0.0, 0.0, 0.9});  // behind the ball
  draw(eye);
  EXPECT_EQ(eye.visible_share(point, 0.05), 1.0);
}

TEST_F(Renderer, DoesNotDrawTheRobotsOwnShell) {
  model_->geom_group[mj_name2id(model_.get(), mjOBJ_GEOM, "screen")] = 2;
  EyeRenderer eye = make_eye();
  place(the_ball, {0.0, 0.0, -1.0});
  place(the_screen, {0.0, 0.0, 0.3});
  draw(eye);
  EXPECT_THAT(image_, ::testing::Each(::testing::FloatNear(51.0F, 0.01F)));
}

TEST_F(Renderer, DrawsEverythingAtTheBorderOfTheImage) {
  EyeRenderer eye = make_eye();
  place(the_ball, {0.0, 0.0, -1.0});
  draw(eye);
  const std::vector<float> background = image_;
  for (const auto& [x, y] : {std::pair{-4.0, 64.0}, {131.0, 64.0}, {64.0, -4.0}, {64.0, 131.0}}) {
    const Vector3d point = at_pixel(x, y, 0.5);  // the centre is outside, the rim inside
    place(the_ball, point);
    draw(eye);
    const auto row = static_cast<std::size_t>(std::clamp(y, 0.0, 127.0));
    const auto column = static_cast<std::size_t>(std::clamp(x, 0.0, 127.0));
    const std::size_t nearest = row * 128 + column;
    EXPECT_GT(image_[nearest], 2.0F * background[nearest]) << x << " " << y;
  }
}

TEST_F(Renderer, RejectsADrawnImageLargerThanAnyBuffer) {
  camera_ = {{2100, 8}, 100.0, 100.0, 1050.0, 4.0, 0.0, 0.0, 0.0, 0.0};
  EXPECT_THROW(make_eye({.supersampling = 8}), InputError);  // 16,800 samples wide
}

TEST_F(Renderer, RejectsConfigurationsOutOfRange) {
  EXPECT_THROW(make_eye({.supersampling = 0}), InputError);
  EXPECT_THROW(make_eye({.near_m = -1.0}), InputError);
  camera_.fx_px = 10.0;
  EXPECT_THROW(make_eye(), InputError);
  EXPECT_THROW(SceneRenderer(*model_, *gl_, {0, 600}), InputError);
  EXPECT_THROW(GlContext::create("vulkan"), InputError);
}

/// An eye and a lab around it, without a robot.
class RenderedLab : public Renderer {
 protected:
  void build(const LabConfig& config, std::uint64_t seed) {
    const Lab lab(config, seed);
    const std::string text = "<mujoco>" + lab.mjcf() +
                             "<worldbody><camera name=\"eye\" pos=\"-0.056 -0.034 0.347\" "
                             "xyaxes=\"0 1 0 0 0 1\"/></worldbody>"
                             "<visual><headlight active=\"0\"/></visual></mujoco>";
    const MjVfsPtr vfs(new mjVFS);
    mj_defaultVFS(vfs.get());
    ASSERT_TRUE(add_to_vfs(vfs.get(), "lab.xml", text));
    std::array<char, 1000> error{};
    model_.reset(mj_loadXML("lab.xml", vfs.get(), error.data(), static_cast<int>(error.size())));
    ASSERT_NE(model_, nullptr) << error.data();
    lab.paint(*model_);
    data_.reset(mj_makeData(model_.get()));
    mj_kinematics(model_.get(), data_.get());
    mj_camlight(model_.get(), data_.get());
  }
  /// Turns the eye: yaw to the right, pitch up.
  void turn(double yaw_rad, double pitch_rad) {
    const Vector3d forward(-std::cos(pitch_rad) * std::cos(yaw_rad), std::cos(pitch_rad) * std::sin(yaw_rad),
                           std::sin(pitch_rad));
    const Vector3d right(std::sin(yaw_rad), std::cos(yaw_rad), 0.0);
    const Vector3d up = right.cross(forward);
    for (int i = 0; i < 3; ++i) {
      data_->cam_xmat[3 * i + 0] = right[i];
      data_->cam_xmat[3 * i + 1] = up[i];
      data_->cam_xmat[3 * i + 2] = -forward[i];
    }
  }
};

TEST_F(RenderedLab, IsNeitherBlackNorSaturatedNorEmptyWhereverTheEyeLooks) {
  for (const Clutter clutter : {Clutter::textured, Clutter::rectilinear}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      build({.clutter = clutter}, seed);
      EyeRenderer eye = make_eye();
      double sum = 0.0;
      int outside = 0;
      int edges = 0;
      int count = 0;
      for (const double yaw : {-45.0, 0.0, 45.0}) {
        for (const double pitch : {-30.0, 0.0, 30.0}) {
          turn(yaw * rad_per_deg, pitch * rad_per_deg);
          eye.render(*data_, 0, image_);
          for (std::size_t i = 0; i < image_.size(); ++i) {
            sum += static_cast<double>(image_[i]);
            outside += image_[i] < 20.0F || image_[i] > 230.0F ? 1 : 0;
            EXPECT_GT(image_[i], 8.0F) << "no surface";
            // Neighbours that differ by more than one threshold.
            if (i % 128 != 127)
              edges += std::abs(std::log((image_[i + 1] + 10) / (image_[i] + 10))) > 0.2F ? 1 : 0;
            ++count;
          }
        }
      }
      const double mean = sum / count;
      EXPECT_GT(mean, 60.0) << word_of(clutter) << seed;
      EXPECT_LT(mean, 140.0) << word_of(clutter) << seed;
      EXPECT_LT(outside, count / 100) << word_of(clutter) << seed;
      EXPECT_GT(edges, count / 40) << word_of(clutter) << seed;
      std::printf("%s %d: mean %.1f, %.3f %% outside 20..230, edges at %.1f %% of pixels\n",
                  word_of(clutter).data(), static_cast<int>(seed), mean, 100.0 * outside / count,
                  100.0 * edges / count);
    }
  }
}

TEST_F(RenderedLab, IsDrawnWithTheSameBytesEveryTime) {
  build({.clutter = Clutter::textured}, 3);
  EyeRenderer eye = make_eye();
  eye.render(*data_, 0, image_);
  const std::vector<float> first = image_;
  turn(0.7, 0.2);
  eye.render(*data_, 0, image_);
  EXPECT_NE(image_, first);
  turn(0.0, 0.0);
  eye.render(*data_, 0, image_);
  EXPECT_EQ(image_, first);
  // A second renderer and a third-person image between do not change it.
  EyeRenderer other = make_eye();
  SceneRenderer scene(*model_, *gl_, {320, 200});
  std::vector<std::uint8_t> rgb(320 * 200 * 3);
  scene.render(*data_, {}, rgb);
  other.render(*data_, 0, image_);
  EXPECT_EQ(image_, first);
  eye.render(*data_, 0, image_);
  EXPECT_EQ(image_, first);
}

TEST_F(RenderedLab, MakesNoEventWhenPixelsFlickerByOneGreyLevel) {
  build({.clutter = Clutter::textured}, 1);
  EyeRenderer eye = make_eye();
  eye.render(*data_, 0, image_);
  const RandomStream random(1, "flicker");
  EmulatorConfig noiseless = emulator_preset("dvs128");
  noiseless.leak_rate_hz = noiseless.shot_noise_rate_hz = 0.0;
  EventEmulator on_lab(noiseless, camera_.size, 1);
  EventEmulator in_the_dark(noiseless, camera_.size, 1);
  std::vector<Event> events;
  std::vector<float> lab(image_.size());
  std::vector<float> dark(image_.size());
  for (std::uint64_t step = 0; step < 50; ++step) {
    for (std::size_t i = 0; i < image_.size(); ++i) {
      dark[i] = random.uniform(i, step) < 0.5 ? 0.0F : 1.0F;
      lab[i] = image_[i] + dark[i];
    }
    on_lab.process_image(lab, static_cast<std::int64_t>(1000 * step), events);
    in_the_dark.process_image(dark, static_cast<std::int64_t>(1000 * step), events);
  }
  EXPECT_EQ(events.size(), 0U);
}

/// Run by the next test in a separate process: renders an image and prints its hash.
TEST_F(RenderedLab, PrintsTheHashOfAnImage) {
  build({.clutter = Clutter::textured}, 1);
  EyeRenderer eye = make_eye();
  std::uint64_t hash = 1469598103934665603ULL;
  for (const double yaw : {-0.6, 0.0, 0.6}) {
    turn(yaw, 0.1);
    eye.render(*data_, 0, image_);
    const auto* bytes = reinterpret_cast<const unsigned char*>(image_.data());
    for (std::size_t i = 0; i < image_.size() * sizeof(float); ++i)
      hash = (hash ^ bytes[i]) * 1099511628211ULL;
  }
  std::printf("image hash %016llx\n", static_cast<unsigned long long>(hash));
  EXPECT_NE(hash, 0U);
}

/// The lines that the test above prints in a process with these environment variables.
std::vector<std::string> image_hashes(const std::string& environment) {
  const std::string command = environment + " /proc/" + std::to_string(getpid()) +
                              "/exe --gtest_filter=RenderedLab.PrintsTheHashOfAnImage 2>/dev/null";
  std::vector<std::string> hashes;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return hashes;
  std::array<char, 512> line{};
  while (std::fgets(line.data(), static_cast<int>(line.size()), pipe) != nullptr) {
    const std::string text(line.data());
    if (text.rfind("image hash ", 0) == 0) hashes.push_back(text);
  }
  EXPECT_EQ(pclose(pipe), 0);
  return hashes;
}

TEST_F(RenderedLab, IsDrawnWithTheSameBytesByAnyNumberOfThreads) {
  if (gl_->description().find("llvmpipe") == std::string::npos) {
    GTEST_SKIP() << "NOT TESTED, only the software renderer has threads: " << gl_->description();
  }
  const std::vector<std::string> first = image_hashes("LP_NUM_THREADS=0");
  ASSERT_EQ(first.size(), 1U);
  for (const char* threads : {"1", "2", "5"})
    EXPECT_EQ(image_hashes(std::string("LP_NUM_THREADS=") + threads), first) << threads << " threads";
}

TEST(GlContext, DrawsTheSameBytesWithEveryBackend) {
  for (const GlWay& way : GlContext::ways()) {
    if (!way.works || way.description.find("llvmpipe") == std::string::npos)
      GTEST_SKIP() << "NOT COMPARED, " << way.backend
                   << " does not draw with llvmpipe here: " << way.description;
  }
  const std::vector<std::string> egl = image_hashes("MUJOCO_GL=egl");
  ASSERT_EQ(egl.size(), 1U);
  EXPECT_EQ(image_hashes("MUJOCO_GL=osmesa"), egl);
}

TEST_F(RenderedLab, IsUprightInThirdPersonImages) {
  build({.clutter = Clutter::rectilinear}, 2);
  SceneRenderer scene(*model_, *gl_, {160, 100});
  std::vector<std::uint8_t> rgb(160 * 100 * 3);
  const auto mean = [&] {
    double sum = 0.0;
    for (const std::uint8_t value : rgb) sum += value;
    return sum / static_cast<double>(rgb.size());
  };
  scene.render(*data_, {.look_at_m = {-0.5, 0.0, 0.3}, .azimuth_rad = std::numbers::pi, .elevation_rad = 0.0},
               rgb);
  EXPECT_GT(mean(), 60.0);
  EXPECT_LT(mean(), 230.0);
  // Compares the upper half of a horizontal view with a view that is turned up.
  std::vector<std::uint8_t> level = rgb;
  scene.render(*data_, {.look_at_m = {-0.5, 0.0, 0.3}, .azimuth_rad = std::numbers::pi, .elevation_rad = 0.2},
               rgb);
  // Turned up by 0.2 rad, everything moves down by about 0.2 / 0.84 of the height: 23 rows.
  double down = 0.0;
  double up = 0.0;
  for (std::size_t row = 30; row < 70; ++row) {
    for (std::size_t i = 0; i < 480; ++i) {
      down += std::abs(rgb[(row + 23) * 480 + i] - level[row * 480 + i]);
      up += std::abs(rgb[(row - 23) * 480 + i] - level[row * 480 + i]);
    }
  }
  EXPECT_LT(down, up);
}

TEST(GlContext, NamesItsBackendRendererAndVersion) {
  for (const std::string backend : {"egl", "osmesa"}) {
    std::unique_ptr<GlContext> gl;
    try {
      gl = GlContext::create(backend);
    } catch (const RunError& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr("OpenGL"));
      EXPECT_THAT(error.what(), ::testing::Not(::testing::HasSubstr("\n")));
      continue;
    }
    EXPECT_THAT(gl->description(), ::testing::StartsWith(backend + ", "));
    EXPECT_NE(gl->function("glReadPixels"), nullptr);
  }
}

TEST(GlContext, ListsTheBackendsAndLeavesTheChoiceOpen) {
  const std::vector<GlWay> ways = GlContext::ways();
  ASSERT_EQ(ways.size(), 2U);
  EXPECT_EQ(ways[0].backend, "egl");
  EXPECT_EQ(ways[1].backend, "osmesa");
  for (const GlWay& way : ways)
    EXPECT_THAT(way.description, ::testing::StartsWith(way.works ? way.backend + ", " : "no OpenGL"));
  // A process can use one of them alone, here the last that works.
  if (dlsym(RTLD_DEFAULT, "eglGetProcAddress") != nullptr)
    GTEST_SKIP() << "NOT TESTED, an earlier test of this process has chosen a backend";
  for (std::size_t i = ways.size(); i-- > 0;) {
    if (!ways[i].works) continue;
    EXPECT_EQ(GlContext::create(ways[i].backend)->description(), ways[i].description);
    return;
  }
}

TEST(GlContext, RefusesADeviceForABackendThatHasNone) {
  EXPECT_THROW(GlContext::create("osmesa", 0), InputError);
}

TEST(GlContext, ListsTheSameDevicesEveryTimeAndNamesEach) {
  const std::vector<GlDevice> devices = GlContext::devices();
  const std::vector<GlDevice> again = GlContext::devices();
  ASSERT_EQ(devices.size(), again.size());
  for (std::size_t i = 0; i < devices.size(); ++i) {
    EXPECT_EQ(devices[i].name, again[i].name);
    EXPECT_EQ(devices[i].software, again[i].software);
    EXPECT_FALSE(devices[i].name.empty());
  }
}

}  // namespace
}  // namespace saccade
