#include "core/baselines/kernel_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/baselines/surface_detector.h"

namespace saccade {
namespace {

constexpr ImageSize search_image{96, 80};
constexpr std::array<double, 2> search_radii = {6, 14};

/// A surface with a closed outline, 0 or 255.
std::vector<double> surface_with(const Circle& c) {
  std::vector<double> surface(static_cast<std::size_t>(search_image.pixels()), 0.0);
  for (int i = 0; i < 720; ++i) {
    const double angle = i * std::numbers::pi / 360.0;
    const auto x = static_cast<int>(std::lround(c.x_px + c.r_px * std::cos(angle)));
    const auto y = static_cast<int>(std::lround(c.y_px + c.r_px * std::sin(angle)));
    surface[static_cast<std::size_t>(y * search_image.width + x)] = 255.0;
  }
  return surface;
}

TEST(KernelSearch, FindsTheOutlineAndFollowsIt) {
  KernelSearch search(search_radii, search_image);
  EXPECT_FALSE(search.disc().valid) << "before the first search has ended";
  Circle circle{30, 40, 10};
  for (std::int64_t i = 0; i < search.steps_to_settle(); ++i) search.step(surface_with(circle));
  for (int i = 0; i < 20; ++i) {
    circle.x_px += 2.0;  // within its reach of 3 px
    search.step(surface_with(circle));
    const Estimate disc = search.disc();
    ASSERT_TRUE(disc.valid);
    EXPECT_NEAR(disc.circle.x_px, circle.x_px, 1.0);
    EXPECT_NEAR(disc.circle.y_px, circle.y_px, 1.0);
    EXPECT_NEAR(disc.circle.r_px, circle.r_px, 1.0);
  }
  EXPECT_GT(search.disc().score, 0.25) << "about 0.5 for a thin closed outline";
}

TEST(KernelSearch, AnEvenTextureHasHardlyAResponse) {
  KernelSearch search(search_radii, search_image);
  const std::vector<double> even(static_cast<std::size_t>(search_image.pixels()), 200.0);
  for (std::int64_t i = 0; i < search.steps_to_settle(); ++i) search.step(even);
  EXPECT_LT(search.disc().score, 0.25);
}

struct CopiedConfig {
  std::array<double, 2> radius_px = search_radii;
  double threshold = 0.4;
};
void describe(FieldVisitor& v, CopiedConfig& c) { v.real("threshold", c.threshold, {0.0, 1.0}, ""); }

/// The pixels of all events so far.
class PlainSurface {
 public:
  PlainSurface(const CopiedConfig&, ImageSize size)
      : size_(size), values_(static_cast<std::size_t>(size.pixels()), 0.0) {}
  void add(const Event& e) { values_[static_cast<std::size_t>(e.y * size_.width + e.x)] = 255.0; }
  [[nodiscard]] std::span<const double> values() const { return values_; }

 private:
  ImageSize size_;
  std::vector<double> values_;
};

std::vector<Event> events_of(const Circle& circle, std::int64_t t_us) {
  const std::vector<double> surface = surface_with(circle);
  std::vector<Event> events;
  for (std::size_t i = 0; i < surface.size(); ++i) {
    const auto width = static_cast<std::size_t>(search_image.width);
    if (surface[i] > 0.0)
      events.push_back(
          {t_us, static_cast<std::uint16_t>(i % width), static_cast<std::uint16_t>(i / width), true, 0});
  }
  return events;
}

TEST(SurfaceDetector, StepsEachMillisecondAndHoldsWithoutEvents) {
  SurfaceDetector<CopiedConfig, PlainSurface> detector({}, search_image);
  const Circle circle{50, 40, 9};
  detector.advance_to(500, nullptr);
  EXPECT_FALSE(detector.estimate().valid);
  detector.process(events_of(circle, 1000), nullptr);
  detector.advance_to(200'000, nullptr);
  const Estimate found = detector.estimate();
  ASSERT_TRUE(found.valid);
  EXPECT_TRUE(found.held) << "no event in the last millisecond";
  EXPECT_NEAR(found.circle.x_px, circle.x_px, 1.0);
  EXPECT_NEAR(found.circle.r_px, circle.r_px, 1.0);
  detector.process(events_of(circle, 200'500), nullptr);
  detector.advance_to(201'000, nullptr);
  EXPECT_FALSE(detector.estimate().held);
  EXPECT_EQ(detector.threshold(), 0.4);
}

TEST(SurfaceDetector, RefusesAConfigurationOutOfRange) {
  EXPECT_THROW((SurfaceDetector<CopiedConfig, PlainSurface>({.threshold = 2.0}, search_image)), InputError);
}

}  // namespace
}  // namespace saccade
