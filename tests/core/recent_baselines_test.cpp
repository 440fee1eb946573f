// The detectors of core/baselines/ after 2016: surfaces with convolution kernels, particle filter, blob filter.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/baselines/blob_filter.h"
#include "core/baselines/eros.h"
#include "core/baselines/particle_filter.h"
#include "core/baselines/scarf.h"
#include "core/detectors/built_in_detectors.h"
#include "head/icub_cameras.h"
#include "tests/core/streams.h"

namespace saccade {
namespace {

constexpr ImageSize image{128, 128};

double at(std::span<const double> values, ImageSize size, int x, int y) {
  return values[static_cast<std::size_t>(y * size.width + x)];
}

Event event_of(int x, int y) { return streams::event_at(0, x, y, true); }

TEST(ErosSurface, AnEventDecaysItsSquareAndSetsItsPixel) {
  const ImageSize size{9, 7};
  ErosConfig config;
  config.kernel_px = 3;
  config.decay = 0.5;
  const double factor = std::cbrt(0.5);
  ErosSurface surface(config, size);
  surface.add(event_of(2, 3));
  surface.add(event_of(3, 4));  // its square holds (2, 3)
  surface.add(event_of(5, 4));  // its square does not hold (3, 4)
  surface.add(event_of(4, 3));  // its square holds (3, 4) and (5, 4)
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      double expected = 0.0;
      if ((x == 2 && y == 3) || (x == 3 && y == 4) || (x == 5 && y == 4)) expected = 255.0 * factor;
      if (x == 4 && y == 3) expected = 255.0;
      EXPECT_NEAR(at(surface.values(), size, x, y), expected, 1e-9) << x << " " << y;
    }
  }
}

TEST(ErosSurface, APixelFallsToDecayAfterAsManyEventsAsTheSideOfTheSquare) {
  ErosSurface surface(ErosConfig{}, image);
  surface.add(event_of(60, 60));
  for (int i = 0; i < 5; ++i) surface.add(event_of(61, 58 + i));
  EXPECT_NEAR(at(surface.values(), image, 60, 60), 0.3 * 255.0, 1e-9);
}

TEST(ErosSurface, TimeAndPolarityHaveNoEffect) {
  ErosSurface surface(ErosConfig{}, image);
  ErosSurface other(ErosConfig{}, image);
  for (const Event& event : streams::clustered(image, 3000, 4)) {
    surface.add(event);
    other.add({event.t_us * 7 + 12, event.x, event.y, !event.on, event.camera});
  }
  EXPECT_TRUE(std::equal(surface.values().begin(), surface.values().end(), other.values().begin()));
}

TEST(ErosSurface, EventsAtTheBorderStayInsideTheImage) {
  ErosSurface surface(ErosConfig{}, image);
  for (const Event& event : streams::border_hugging(image, 3000, 5)) {
    surface.add(event);
    ASSERT_EQ(at(surface.values(), image, event.x, event.y), 255.0);
  }
  EXPECT_THAT(surface.values(), testing::Each(testing::AllOf(testing::Ge(0.0), testing::Le(255.0))));
}

/// 44 x 44 pixels with blocks of 10: 3 x 3 fields whose centres begin at 5, 15 and 25.
constexpr ImageSize scarf_image{44, 44};

TEST(ScarfSurface, AFieldKeepsHalfAsManyEventsAsItsCentreHasPixels) {
  ScarfSurface surface(ScarfConfig{}, scarf_image);
  ASSERT_EQ(surface.columns(), 3);
  ASSERT_EQ(surface.rows(), 3);
  ASSERT_EQ(surface.capacity(), 50U);
  surface.add(event_of(17, 17));
  EXPECT_NEAR(at(surface.values(), scarf_image, 17, 17), 0.3 * 255, 1e-9);
  for (int i = 0; i < 49; ++i) surface.add(event_of(18, 18));
  EXPECT_NEAR(at(surface.values(), scarf_image, 17, 17), 0.3 * 255, 1e-9);
  surface.add(event_of(18, 18));
  EXPECT_EQ(at(surface.values(), scarf_image, 17, 17), 0.0);
  EXPECT_NEAR(at(surface.values(), scarf_image, 18, 18), 50 * 0.3 * 255, 1e-6);
}

TEST(ScarfSurface, EventsInTheSurroundOfAFieldDisplaceThoseInItsCentre) {
  // The field with the centre [15, 25) reaches from 10 to 30.
  for (const auto& [x, displaces] : {std::pair{29, true}, {10, true}, {30, false}, {9, false}}) {
    ScarfSurface surface(ScarfConfig{}, scarf_image);
    surface.add(event_of(20, 20));
    for (int i = 0; i < 50; ++i) surface.add(event_of(x, 20));
    EXPECT_EQ(at(surface.values(), scarf_image, 20, 20) == 0.0, displaces) << x;
  }
}

TEST(ScarfSurface, AnEventOutsideAllCentresIsNotShownAndDisplacesOthers) {
  ScarfSurface surface(ScarfConfig{}, scarf_image);
  surface.add(event_of(6, 17));
  for (int i = 0; i < 50; ++i) surface.add(event_of(2, 17));
  EXPECT_THAT(surface.values(), testing::Each(0.0));
}

std::vector<double> drawn_circle(const Circle& circle, ImageSize size) {
  std::vector<double> surface(static_cast<std::size_t>(size.pixels()), 0.0);
  for (int i = 0; i < 2000; ++i) {
    const double angle = i * std::numbers::pi / 1000;
    const auto x = static_cast<int>(std::lround(circle.x_px + circle.r_px * std::cos(angle)));
    const auto y = static_cast<int>(std::lround(circle.y_px + circle.r_px * std::sin(angle)));
    if (size.contains(x, y)) surface[static_cast<std::size_t>(y * size.width + x)] = 255.0;
  }
  return surface;
}

TEST(KernelSearch, FindsACircleAnywhereAndOfAnyRadiusOfItsRange) {
  const ImageSize size{160, 120};
  for (const Circle& circle :
       {Circle{80, 60, 20}, {30, 31, 12}, {140, 100, 35}, {5, 60, 18}, {100, 40, 10}}) {
    KernelSearch search({10, 35}, size);
    const std::vector<double> surface = drawn_circle(circle, size);
    EXPECT_FALSE(search.disc().valid);
    for (std::int64_t i = 0; i < search.steps_to_settle(); ++i) search.step(surface);
    const Estimate e = search.disc();
    ASSERT_TRUE(e.valid);
    EXPECT_NEAR(e.circle.x_px, circle.x_px, 1.0);
    EXPECT_NEAR(e.circle.y_px, circle.y_px, 1.0);
    EXPECT_NEAR(e.circle.r_px, circle.r_px, 1.0);
  }
}

TEST(KernelSearch, GivesAThinOutlineHalfTheLargestResponseAndAnEvenImageNone) {
  const std::vector<double> circle = drawn_circle({64, 64, 20}, image);
  const std::vector<double> even(static_cast<std::size_t>(image.pixels()), 255.0);
  KernelSearch on_circle({10, 35}, image);
  KernelSearch on_even({10, 35}, image);
  for (std::int64_t i = 0; i < on_circle.steps_to_settle(); ++i) {
    on_circle.step(circle);
    on_even.step(even);
  }
  EXPECT_NEAR(on_circle.disc().score, 0.45, 0.1);
  EXPECT_LT(on_even.disc().score, 0.1);
}

TEST(KernelSearch, ReplacesItsDiscByAStrongerOne) {
  KernelSearch search({10, 35}, image);
  std::vector<double> surface = drawn_circle({40, 40, 15}, image);
  for (double& value : surface) value *= 0.6;
  for (std::int64_t i = 0; i < search.steps_to_settle(); ++i) search.step(surface);
  EXPECT_NEAR(search.disc().circle.x_px, 40, 1.0);
  const std::vector<double> stronger = drawn_circle({95, 90, 20}, image);
  for (std::size_t i = 0; i < surface.size(); ++i) surface[i] = std::max(surface[i], stronger[i]);
  for (std::int64_t i = 0; i < search.steps_to_settle(); ++i) search.step(surface);
  EXPECT_NEAR(search.disc().circle.x_px, 95, 1.0);
  EXPECT_NEAR(search.disc().circle.r_px, 20, 1.0);
}

struct Errors {
  double position_px = 0.0;
  double radius_px = 0.0;
};

/// Largest errors from 40 ms on, at every millisecond.
Errors errors_on(Detector& detector, const streams::MovingDisc& disc) {
  const std::vector<Event> events = disc.events(image, 0.12);
  std::size_t next = 0;
  Errors worst;
  for (std::int64_t now = 1000; now <= 120'000; now += 1000) {
    std::size_t end = next;
    while (end < events.size() && events[end].t_us <= now) ++end;
    detector.process(std::span(events).subspan(next, end - next), nullptr);
    detector.advance_to(now, nullptr);
    next = end;
    if (now < 40'000) continue;
    const Estimate e = detector.estimate();
    EXPECT_TRUE(e.valid);
    EXPECT_GE(e.score, detector.threshold());
    worst.position_px = std::max(worst.position_px,
                                 std::hypot(e.circle.x_px - disc.x_at(now), e.circle.y_px - disc.y_at(now)));
    worst.radius_px = std::max(worst.radius_px, std::abs(e.circle.r_px - disc.r_px));
  }
  return worst;
}

struct Bound {
  std::string preset;
  Errors largest;
};

class RecentBaseline : public testing::TestWithParam<Bound> {};
INSTANTIATE_TEST_SUITE_P(Presets, RecentBaseline,
                         testing::Values(Bound{"eros", {2.5, 1.5}}, Bound{"scarf", {3.0, 1.5}},
                                         Bound{"particle_filter", {7.5, 3.5}},
                                         Bound{"blob_filter", {4.0, 2.0}}),
                         [](const auto& test) { return test.param.preset; });

TEST_P(RecentBaseline, FollowsMovingDiscsAboveItsThreshold) {
  const auto& [preset, largest] = GetParam();
  for (const streams::MovingDisc& disc :
       {streams::MovingDisc{35, 50, 400, 200, 22.5}, {90, 90, -350, -300, 15}, {64, 30, 0, 500, 18}}) {
    const auto detector = make_detector(built_in_detectors().config(preset), icub_left_2016);
    const Errors worst = errors_on(*detector, disc);
    std::printf("%s, r %.1f px: largest error %.2f px, of the radius %.2f px\n", preset.c_str(), disc.r_px,
                worst.position_px, worst.radius_px);
    EXPECT_LT(worst.position_px, largest.position_px) << disc.r_px;
    EXPECT_LT(worst.radius_px, largest.radius_px) << disc.r_px;
  }
}

TEST(SurfaceDetectors, HoldADiscThatMakesNoEvents) {
  for (const char* preset : {"eros", "scarf"}) {
    const auto detector = make_detector(built_in_detectors().config(preset), icub_left_2016);
    const std::vector<Event> events = streams::MovingDisc{35, 64, 400, 0, 20}.events(image, 0.1);
    detector->process(events, nullptr);
    const std::int64_t end_us = events.back().t_us;
    detector->advance_to(end_us, nullptr);
    EXPECT_FALSE(detector->estimate().held) << preset;
    detector->advance_to(end_us + 60'000'000, nullptr);
    const Estimate e = detector->estimate();
    EXPECT_TRUE(e.valid && e.held) << preset;
    EXPECT_GT(e.score, detector->threshold()) << preset;
    EXPECT_NEAR(e.circle.x_px, 35 + 400 * static_cast<double>(end_us) * 1e-6, 4.0) << preset;
  }
}

TEST(SurfaceDetectors, GiveTheSameEstimatesForAnyInstantsAtWhichTimeIsPassed) {
  const std::vector<Event> events = streams::cluttered(image, 6000, 0.4, 2);
  for (const char* preset : {"eros", "scarf"}) {
    const auto once = make_detector(built_in_detectors().config(preset), icub_left_2016);
    const auto often = make_detector(built_in_detectors().config(preset), icub_left_2016);
    for (const Event& event : events) {
      often->advance_to(event.t_us - 1, nullptr);
      once->process({&event, 1}, nullptr);
      often->process({&event, 1}, nullptr);
    }
    const std::int64_t end_us = events.back().t_us + 500'000;
    for (std::int64_t now = events.back().t_us; now < end_us; now += 777) often->advance_to(now, nullptr);
    for (Detector* each : {once.get(), often.get()}) each->advance_to(end_us, nullptr);
    EXPECT_EQ(once->estimate().circle.x_px, often->estimate().circle.x_px) << preset;
    EXPECT_EQ(once->estimate().score, often->estimate().score) << preset;
  }
}

TEST(ParticleFilter, DependsOnItsSeedAndNothingElse) {
  const std::vector<Event> events = streams::MovingDisc{35, 50, 400, 200, 22.5}.events(image, 0.12);
  const auto circle_of = [&](std::int64_t seed) {
    ParticleFilterConfig config;
    config.seed = seed;
    ParticleFilter filter(config, image);
    filter.process(events, nullptr);
    return filter.estimate().circle;
  };
  EXPECT_EQ(circle_of(1).x_px, circle_of(1).x_px);
  EXPECT_NE(circle_of(1).x_px, circle_of(2).x_px);
  EXPECT_NEAR(circle_of(1).x_px, circle_of(2).x_px, 3.0);
}

TEST(ParticleFilter, FindsABallAgainThatWasLost) {
  ParticleFilter filter(ParticleFilterConfig{}, image);
  std::vector<Event> events = streams::MovingDisc{30, 40, 400, 0, 15}.events(image, 0.1);
  // It is then somewhere else at once, while scattered events go on where it was.
  const auto scattered = streams::random({60, 60}, 2000, 3);
  for (std::size_t i = 0; i < scattered.size(); ++i) {
    events.push_back(streams::event_at(100'000 + static_cast<std::int64_t>(i) * 100, 40 + scattered[i].x,
                                       scattered[i].y, true));
  }
  for (Event e : streams::MovingDisc{30, 100, 300, 0, 20}.events(image, 0.2)) {
    e.t_us += 100'000;
    events.push_back(e);
  }
  streams::sort_by_time(events);
  filter.process(events, nullptr);
  EXPECT_NEAR(filter.estimate().circle.x_px, 90, 7.5);
  EXPECT_NEAR(filter.estimate().circle.y_px, 100, 7.5);
}

TEST(BlobFilter, TheCovarianceShrinksWithEventsAndIsThatOfACircle) {
  BlobFilter filter(BlobFilterConfig{}, image);
  const std::vector<Event> events = streams::MovingDisc{35, 50, 400, 200, 22.5}.events(image, 0.12);
  filter.process(std::span(events).first(50), nullptr);
  const Eigen::Matrix3d early = filter.estimate().covariance_px2;
  filter.process(std::span(events).subspan(50), nullptr);
  const Eigen::Matrix3d late = filter.estimate().covariance_px2;
  for (int i = 0; i < 3; ++i) {
    EXPECT_GT(late(i, i), 0.0);
    EXPECT_LT(late(i, i), early(i, i));
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(late(i, k), late(k, i), 1e-9);
      EXPECT_LE(late(i, k) * late(i, k), late(i, i) * late(k, k) * (1 + 1e-9));
    }
  }
}

TEST(BlobFilter, HasNoEstimateAfterTimeWithoutEvents) {
  BlobFilter filter(BlobFilterConfig{}, image);
  const std::vector<Event> events = streams::MovingDisc{35, 50, 400, 200, 22.5}.events(image, 0.12);
  filter.process(events, nullptr);
  const double score = filter.estimate().score;
  filter.advance_to(events.back().t_us + 20'000, nullptr);
  EXPECT_NEAR(filter.estimate().score, score / std::numbers::e, 1e-9);
  filter.advance_to(events.back().t_us + 1'000'000, nullptr);
  EXPECT_FALSE(filter.estimate().valid);
}

template <class DetectorType, class Config>
void expect_refused(Config config) {
  EXPECT_THROW(DetectorType(config, image), InputError);
}

TEST(RecentBaselines, RejectKeysOutOfRange) {
  ErosConfig eros;
  eros.kernel_px = 4;
  expect_refused<ErosDetector>(eros);
  eros.kernel_px = 5;
  eros.decay = 1.1;
  expect_refused<ErosDetector>(eros);
  ScarfConfig scarf;
  scarf.block_px = 1;
  expect_refused<ScarfDetector>(scarf);
  ParticleFilterConfig particles;
  particles.particles = 0;
  expect_refused<ParticleFilter>(particles);
  particles = {};
  particles.seed = -1;
  expect_refused<ParticleFilter>(particles);
  BlobFilterConfig blobs;
  blobs.decay_us = 0;
  expect_refused<BlobFilter>(blobs);
}

TEST(RecentBaselines, WorkOnImagesSmallerThanTheirFieldsAndKernels) {
  for (const char* preset : {"eros", "scarf", "particle_filter", "blob_filter"}) {
    Camera camera = icub_left_2016;
    camera.size = {9, 5};
    const auto detector = make_detector(built_in_detectors().config(preset), camera);
    for (const Event& event : streams::random(camera.size, 2000, 6)) detector->process({&event, 1}, nullptr);
    detector->advance_to(100'000, nullptr);
    const Estimate e = detector->estimate();
    EXPECT_TRUE(std::isfinite(e.circle.x_px) && std::isfinite(e.score)) << preset;
  }
}

}  // namespace
}  // namespace saccade
