#include "sim/lens_resampler.h"

#include <gtest/gtest.h>

#include <cmath>

#include "head/icub_cameras.h"
#include "sim/keyframe_camera.h"

namespace saccade {
namespace {

TEST(LensResampler, AnEvenImageStaysEven) {
  LensResampler resampler(icub_left_2016, 2);
  const auto samples =
      static_cast<std::size_t>(resampler.columns()) * static_cast<std::size_t>(resampler.rows());
  const std::vector<std::uint32_t> rgba(samples, 0xff40'4040U);
  std::vector<float> image(static_cast<std::size_t>(icub_left_2016.size.pixels()));
  WorkerThreads one(1);
  resampler.luminance(rgba, image, one);
  for (const float value : image) ASSERT_NEAR(value, image.front(), 1e-3F);
  EXPECT_NEAR(image.front(), 64.0F, 0.1F);
}

TEST(LensResampler, DrawsAllThatTheLensShows) {
  const LensResampler resampler(icub_left_2016, 2);
  const ImageSize size = icub_left_2016.size;
  for (const double x : {-0.5, size.width - 0.5}) {
    for (const double y : {-0.5, size.height - 0.5}) {
      const Eigen::Vector3d ray = icub_left_2016.ray(x, y);
      const double column = resampler.centre_x() + resampler.focal() * ray.x();
      const double row = resampler.centre_y() + resampler.focal() * ray.y();
      EXPECT_TRUE(column > -1.0 && column < resampler.columns() + 1.0) << column;
      EXPECT_TRUE(row > -1.0 && row < resampler.rows() + 1.0) << row;
    }
  }
  EXPECT_EQ(resampler.is_inside().size(),
            static_cast<std::size_t>(resampler.columns()) * static_cast<std::size_t>(resampler.rows()));
}

TEST(LensResampler, SmallestIgnoresZeros) {
  const LensResampler resampler(icub_left_2016, 1);
  const auto samples =
      static_cast<std::size_t>(resampler.columns()) * static_cast<std::size_t>(resampler.rows());
  std::vector<std::uint8_t> numbers(static_cast<std::size_t>(icub_left_2016.size.pixels()));
  resampler.smallest(std::vector<std::uint32_t>(samples, 0U), 99, numbers);
  EXPECT_EQ(numbers.front(), 99);
  resampler.smallest(std::vector<std::uint32_t>(samples, 7U), 99, numbers);
  EXPECT_EQ(numbers.front(), 7);
}

TEST(KeyframeCamera, HasTheLensesImageAndAMargin) {
  using detail::KeyframeCamera;
  const KeyframeCamera plain(icub_left_2016, 2, 0.0), wide(icub_left_2016, 2, 10.0);
  EXPECT_EQ(plain.samples(), 2);
  EXPECT_NEAR(wide.columns() - plain.columns(), 2 * 10 * 2, 8);
  EXPECT_NEAR(wide.rows() - plain.rows(), 2 * 10 * 2, 8);
  const ImageSize size = icub_left_2016.size;
  for (const double x : {-0.5, size.width - 0.5}) {
    for (const double y : {-0.5, size.height - 0.5}) {
      const Eigen::Vector3d ray = icub_left_2016.ray(x, y);
      const double column = plain.centre_x() + plain.focal() * ray.x();
      const double row = plain.centre_y() + plain.focal() * ray.y();
      EXPECT_TRUE(column > -1.0 && column < plain.columns() + 1.0) << column;
      EXPECT_TRUE(row > -1.0 && row < plain.rows() + 1.0) << row;
    }
  }
}

TEST(KeyframeCamera, TheSpanOfASphereHoldsItsProjection) {
  const detail::KeyframeCamera camera(icub_left_2016, 2, 10.0);
  const Eigen::Vector3d centre(0.05, -0.03, 0.6);
  const double radius_m = 0.04;
  const auto span = camera.span_of(centre, radius_m, 0.01);
  ASSERT_TRUE(span);
  for (int i = 0; i < 100; ++i) {
    const double a = 0.1 * i, b = 0.37 * i;
    const Eigen::Vector3d p = centre + radius_m * Eigen::Vector3d(std::cos(a) * std::cos(b),
                                                                  std::sin(a) * std::cos(b), std::sin(b));
    const double column = camera.centre_x() + camera.focal() * p.x() / p.z();
    const double row = camera.centre_y() + camera.focal() * p.y() / p.z();
    EXPECT_TRUE(column >= span->left && column <= span->right) << column;
    EXPECT_TRUE(row >= span->top && row <= span->bottom) << row;
  }
  EXPECT_FALSE(camera.span_of({0.0, 0.0, 0.03}, radius_m, 0.01)) << "reaches behind the near plane";
}

TEST(SampleRect, IsCutByAnother) {
  const detail::SampleRect rect{2, 3, 10, 8};
  const detail::SampleRect cut = rect.cut({4, 0, 20, 5});
  EXPECT_EQ(cut.left, 4);
  EXPECT_EQ(cut.top, 3);
  EXPECT_EQ(cut.right, 10);
  EXPECT_EQ(cut.bottom, 5);
  EXPECT_TRUE(rect.cut({20, 20, 30, 30}).is_empty());
}

}  // namespace
}  // namespace saccade
