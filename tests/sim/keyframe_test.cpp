#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <vector>

#include "core/error.h"
#include "core/random.h"
#include "core/units.h"
#include "head/icub_cameras.h"
#include "sim/keyframe_renderer.h"
#include "sim/lab.h"
#include "sim/world.h"

namespace saccade {
namespace {

using Image = std::vector<float>;

/// A world with keyframes, and the same world drawn with 8x8 samples per pixel to compare with.
class Keyframes : public testing::Test {
 protected:
  void SetUp() override {
    try {
      gl_ = GlContext::create("auto");
    } catch (const RunError& error) {
      GTEST_SKIP() << "NOT TESTED, there is no OpenGL: " << error.what();
    }
    ball().trajectory.kind = TrajectoryKind::circle;
    ball().trajectory.radius_a_m = {0.0, -0.07, 0.0};
    ball().trajectory.radius_b_m = {0.0, 0.0, 0.07};
    ball().trajectory.frequency_hz = 0.5;
    render_.method = RenderMethod::keyframes;
  }

  BallConfig& ball() { return config_.ball; }
  void make_world() {
    const Lab lab(LabConfig{}, 1);
    world_ = std::make_unique<World>(config_, lab.mjcf(), 1);
    lab.paint(world_->model());
  }
  [[nodiscard]] KeyframeRenderer keyframes(std::size_t threads = 1) {
    return {world_->model(), *gl_, camera_, render_, std::make_shared<WorkerThreads>(threads)};
  }
  [[nodiscard]] EyeRenderer drawn(std::int64_t supersampling) {
    EyeRenderConfig config;
    config.supersampling = supersampling;
    return {world_->model(), *gl_, camera_, config};
  }

  /// Neck and eyes turn, the eyes at up to 60 deg/s.
  void turn_head(std::int64_t i) {
    HeadJointVector reference_rad = HeadJointVector::Zero();
    const double turn = 2.0 * std::numbers::pi * static_cast<double>(i) * 1e-3;
    reference_rad[neck_yaw - torso_joint_count] = 6.0 * rad_per_deg * std::sin(0.6 * turn);
    reference_rad[eyes_tilt - torso_joint_count] = 5.0 * rad_per_deg * std::sin(2.0 * turn);
    reference_rad[eyes_version - torso_joint_count] = -4.0 * rad_per_deg * std::sin(1.5 * turn);
    ASSERT_TRUE(world_->set_reference(reference_rad));
  }
  template <class Renderer>
  Image image_of(Renderer& renderer) {
    Image image(static_cast<std::size_t>(camera_.size.pixels()));
    renderer.render(world_->data(), world_->left_eye_camera(), image);
    return image;
  }
  template <class Renderer>
  double visible_share(Renderer& renderer) {
    const Eigen::Vector3d ball_m = world_->root_from_left_cam().inverse() * world_->target_position_m();
    if constexpr (std::is_same_v<Renderer, KeyframeRenderer>) {
      const int geom = mj_name2id(&world_->model(), mjOBJ_GEOM, "ball");
      return renderer.visible_share(ball_m, *world_->target_radius_m(), world_->model().geom_bodyid[geom]);
    } else {
      return renderer.visible_share(ball_m, *world_->target_radius_m());
    }
  }
  static double mean_difference(const Image& a, const Image& b) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.size(); ++i) sum += std::abs(static_cast<double>(a[i] - b[i]));
    return sum / static_cast<double>(a.size());
  }

  WorldConfig config_;
  Camera camera_ = icub_left_2016;
  EyeRenderConfig render_;
  std::unique_ptr<GlContext> gl_;
  std::unique_ptr<World> world_;
};

// A keyframe has six times the samples of a drawn image, and reprojection adds no more than those are worth.
TEST_F(Keyframes, ReprojectedImagesAreNearerToFinelyDrawnOnesThanImagesDrawnWith2x2Samples) {
  make_world();
  KeyframeRenderer reprojected = keyframes();
  EyeRenderer coarse = drawn(2);
  EyeRenderer fine = drawn(8);
  double error = 0.0;
  double coarse_error = 0.0;
  int images = 0;
  for (int i = 0; i < 240; ++i) {
    turn_head(i);
    world_->step();
    const Image image = image_of(reprojected);
    if (i % 24 != 23) continue;
    const Image truth = image_of(fine);
    error += mean_difference(image, truth);
    coarse_error += mean_difference(image_of(coarse), truth);
    ++images;
  }
  EXPECT_LT(error, 0.7 * coarse_error);
  EXPECT_LT(error / images, 1.5) << "grey levels";
  EXPECT_LT(reprojected.counts().room, 240 / 8) << "most images are reprojected";
}

// With a resting head one keyframe of the room does: it has what is behind the ball.
TEST_F(Keyframes, WhatTheBallUncoversIsThere) {
  ball().hand = Hand::none;
  make_world();
  KeyframeRenderer reprojected = keyframes();
  EyeRenderer fine = drawn(8);
  for (int i = 0; i < 100; ++i) world_->step();
  image_of(reprojected);
  const std::int64_t rooms = reprojected.counts().room;
  const Circle before = *camera_.project_sphere(
      world_->root_from_left_cam().inverse() * world_->target_position_m(), *world_->target_radius_m());
  for (int i = 0; i < 400; ++i) {
    world_->step();
    if (i % 5 == 4) image_of(reprojected);
  }
  const Circle after = *camera_.project_sphere(
      world_->root_from_left_cam().inverse() * world_->target_position_m(), *world_->target_radius_m());
  ASSERT_GT(std::hypot(after.x_px - before.x_px, after.y_px - before.y_px), 4.0);
  const Image image = image_of(reprojected);
  const Image truth = image_of(fine);
  double sum = 0.0;
  int uncovered = 0;
  for (int y = 0; y < camera_.size.height; ++y) {
    for (int x = 0; x < camera_.size.width; ++x) {
      const bool was_ball = std::hypot(x - before.x_px, y - before.y_px) < before.r_px;
      const bool is_ball = std::hypot(x - after.x_px, y - after.y_px) < after.r_px + 2.0;
      if (!was_ball || is_ball) continue;
      const auto i = static_cast<std::size_t>(y * camera_.size.width + x);
      sum += std::abs(static_cast<double>(image[i] - truth[i]));
      ++uncovered;
    }
  }
  ASSERT_GT(uncovered, 30);
  EXPECT_LT(sum / uncovered, 2.0) << "grey levels";
  EXPECT_EQ(reprojected.counts().room, rooms);
}

TEST_F(Keyframes, ASmallerErrorBoundDrawsMoreKeyframesAndIsNearerToTheDrawnImage) {
  make_world();
  const auto run = [&](double error_px) {
    make_world();
    render_.keyframe_error_px = error_px;
    render_.keyframe_samples = 8;
    KeyframeRenderer reprojected = keyframes();
    EyeRenderer fine = drawn(8);
    double error = 0.0;
    for (int i = 0; i < 180; ++i) {
      turn_head(i);
      world_->step();
      const Image image = image_of(reprojected);
      if (i % 12 == 11) error += mean_difference(image, image_of(fine));
    }
    return std::pair(reprojected.counts().room + reprojected.counts().bodies, error);
  };
  const auto [few, large] = run(1.5);
  const auto [many, small] = run(0.05);
  EXPECT_GT(many, 2 * few);
  EXPECT_LT(small, large);
}

TEST_F(Keyframes, ImagesAreTheSameWithAnyNumberOfThreads) {
  make_world();
  KeyframeRenderer one = keyframes();
  KeyframeRenderer two = keyframes(2);
  KeyframeRenderer five = keyframes(5);
  for (int i = 0; i < 60; ++i) {
    turn_head(i);
    world_->step();
    const Image image = image_of(one);
    ASSERT_EQ(image, image_of(two)) << i;
    ASSERT_EQ(image, image_of(five)) << i;
  }
}

TEST_F(Keyframes, AGlossyBallIsDrawnMoreOftenThanAMattOne) {
  render_.keyframe_error_px = 0.05;
  const auto bodies = [&](double gloss) {
    ball().hand = Hand::none;
    ball().gloss = gloss;
    make_world();
    KeyframeRenderer reprojected = keyframes();
    for (int i = 0; i < 400; ++i) {
      world_->step();
      image_of(reprojected);
    }
    return reprojected.counts().bodies;
  };
  const std::int64_t matt = bodies(0.0);
  EXPECT_GT(bodies(0.8), 2 * matt);
}

TEST_F(Keyframes, OtherLightEndsAllKeyframes) {
  make_world();
  KeyframeRenderer reprojected = keyframes();
  EyeRenderer fine = drawn(8);
  const Image bright = image_of(reprojected);
  mjModel& model = world_->model();
  ASSERT_GT(model.nlight, 0);
  for (int i = 0; i < 3 * model.nlight; ++i) model.light_diffuse[i] *= 0.5F;
  const Image dark = image_of(reprojected);
  EXPECT_GT(mean_difference(bright, dark), 2.0);
  EXPECT_LT(mean_difference(dark, image_of(fine)), 1.0);
}

// The head looks past the ball, so that the image's border and then the hand cut it.
TEST_F(Keyframes, VisibleSharesAreThoseOfDrawnImages) {
  ball().hand = Hand::fist;
  ball().hand_turn_deg = 60.0;
  make_world();
  KeyframeRenderer reprojected = keyframes();
  EyeRenderer direct = drawn(2);
  double least = 1.0;
  double most = 0.0;
  for (int i = 0; i < 300; ++i) {
    HeadJointVector reference_rad = HeadJointVector::Zero();
    reference_rad[eyes_version - torso_joint_count] = std::min(0.1 * i, 28.0) * rad_per_deg;
    ASSERT_TRUE(world_->set_reference(reference_rad));
    world_->step();
    image_of(reprojected);
    if (i % 20 != 19) continue;
    image_of(direct);
    const double share = visible_share(direct);
    least = std::min(least, share);
    most = std::max(most, share);
    EXPECT_NEAR(visible_share(reprojected), share, 0.03) << i;
  }
  EXPECT_LT(least, 0.6);
  EXPECT_GT(most, 0.9);
}

TEST_F(Keyframes, AKeyframeWithTooManySamplesIsRefused) {
  make_world();
  camera_ = Camera{{4000, 100}, 2000.0, 2000.0, 2000.0, 50.0}.without_lens();
  render_.keyframe_samples = 8;
  EXPECT_THROW(static_cast<void>(keyframes()), InputError);
}

/// What is kept of a drawn body has the values that it has in all that was drawn: images do not depend on how much is kept.
TEST(KeyframeFilter, GivesWhatIsKeptOfABodyItsValuesToTheBit) {
  using detail::SampleRect;
  const detail::KeyframeCamera camera(Camera{{240, 180}, 200.0, 200.0, 119.0, 92.0}, 5, 30.0);
  detail::KeyframeFilter filter(camera);
  WorkerThreads threads(2);
  const RandomStream random(1, "samples");
  for (int offset = 0; offset < 64; ++offset) {
    const SampleRect drawn{200 + offset / 8, 150, 460 + 2 * offset, 330};
    const auto columns = static_cast<std::size_t>(drawn.columns());
    std::vector<std::uint32_t> rgba(drawn.area());
    std::vector<float> depth(drawn.area(), 1.0F);
    for (std::size_t i = 0; i < depth.size(); ++i) {
      const double x = static_cast<double>(i % columns) - 130.0 - offset % 8;
      const double y = static_cast<double>(i / columns) - 90.0;
      if (std::abs(x) > 30.0 || std::abs(y) > 20.0) continue;
      depth[i] = 0.5F + 1e-3F * static_cast<float>(x);
      rgba[i] = static_cast<std::uint32_t>(random.bits(0, i)) | 0xFF000000U;
    }
    const auto filled = [&](const SampleRect& rect) {
      std::vector<std::uint32_t> rgba_there;
      std::vector<float> depth_there;
      for (int row = rect.bottom - 1; row >= rect.top; --row) {
        const auto first = static_cast<std::size_t>(drawn.bottom - 1 - row) * columns +
                           static_cast<std::size_t>(rect.left - drawn.left);
        for (std::size_t i = first; i < first + static_cast<std::size_t>(rect.columns()); ++i) {
          rgba_there.push_back(rgba[i]);
          depth_there.push_back(depth[i]);
        }
      }
      detail::Keyframe keyframe;
      keyframe.drawn = drawn;
      keyframe.rect = rect;
      filter.fill(keyframe, {rgba_there, depth_there, 0.01, 10.0, false}, threads);
      return keyframe;
    };
    const SampleRect part = filter.covered_part(drawn, depth);
    ASSERT_LT(part.area(), drawn.area() / 2);
    const detail::Keyframe whole = filled(drawn);
    const detail::Keyframe kept = filled(part);
    EXPECT_EQ(kept.mean_1_m, whole.mean_1_m);
    EXPECT_EQ(kept.nearest_1_m, whole.nearest_1_m);
    EXPECT_EQ(kept.farthest_1_m, whole.farthest_1_m);
    EXPECT_EQ(kept.largest_step_1_m, whole.largest_step_1_m);
    int others = 0;
    for (int row = drawn.top; row < drawn.bottom; ++row) {
      for (int column = drawn.left; column < drawn.right; ++column) {
        const auto in = [&](const SampleRect& rect) {
          return static_cast<std::size_t>(row - rect.top) * static_cast<std::size_t>(rect.columns()) +
                 static_cast<std::size_t>(column - rect.left);
        };
        const bool is_kept =
            column >= part.left && column < part.right && row >= part.top && row < part.bottom;
        for (std::size_t i = 0; i < 4; ++i) {
          const std::uint16_t value = is_kept ? kept.samples[4 * in(part) + i] : std::uint16_t{0};
          others += value != whole.samples[4 * in(drawn) + i] ? 1 : 0;
        }
        if (is_kept) {
          others += kept.inverse_depth_1_m[in(part)] != whole.inverse_depth_1_m[in(drawn)] ? 1 : 0;
        }
      }
    }
    EXPECT_EQ(others, 0) << offset;
  }
}

}  // namespace
}  // namespace saccade
