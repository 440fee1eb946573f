// What sets each detector of core/baselines/ apart.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/baselines/cluster.h"
#include "core/baselines/multi_kernel.h"
#include "core/baselines/original_2016.h"
#include "core/hough/hough_detector.h"
#include "tests/core/streams.h"

namespace saccade {
namespace {

constexpr ImageSize small_image{64, 64};

double sum(const std::vector<float>& space) {
  double total = 0.0;
  for (const float response : space) total += static_cast<double>(response);
  return total;
}

std::vector<float> space_of(const Detector& detector) {
  std::vector<float> space(static_cast<std::size_t>(small_image.pixels()));
  EXPECT_TRUE(hough_space_of(detector, space));
  return space;
}

/// Events of a straight edge that sweeps over 20 columns, 1 ms per column, from `t_us` on.
std::vector<Event> sweep(std::int64_t t_us) {
  std::vector<Event> events;
  for (int x = 20; x < 40; ++x) {
    for (int y = 25; y < 40; ++y) events.push_back(streams::event_at(t_us + (x - 20) * 1000, x, y, true));
  }
  return events;
}

TEST(Original2016, AnEventReplacesTheOneBeforeAtItsPixel) {
  Original2016Config config;
  config.radius_px = {8, 8};
  config.window_events = 60'000;
  Original2016 detector(config, small_image);
  detector.process(sweep(0), nullptr);
  const double once = sum(space_of(detector));
  EXPECT_GT(once, 0.0);
  for (int pass = 1; pass < 5; ++pass) detector.process(sweep(pass * 100'000), nullptr);
  // Every pixel that voted once still votes once; the first pass lacked the patches of its leading columns.
  EXPECT_LT(sum(space_of(detector)), 1.3 * once);

  HoughDetectorConfig fifo;
  fifo.radius_px = {8, 8};
  fifo.window.events = 60'000;
  HoughDetector keeps_all(fifo, small_image);
  keeps_all.process(sweep(0), nullptr);
  static_cast<void>(keeps_all.estimate());
  const double one_pass = sum(space_of(keeps_all));
  for (int pass = 1; pass < 5; ++pass) keeps_all.process(sweep(pass * 200'000), nullptr);
  static_cast<void>(keeps_all.estimate());
  EXPECT_GT(sum(space_of(keeps_all)), 4.0 * one_pass);
}

TEST(Original2016, EventsWithoutFlowDoNotDisplaceOthersFromTheWindow) {
  Original2016Config config;
  config.radius_px = {8, 8};
  config.window_events = 400;
  Original2016 detector(config, small_image);
  detector.process(sweep(0), nullptr);
  const std::vector<float> before = space_of(detector);
  // Lone events, three pixels apart: no patch of 3 x 3 is ever filled.
  std::vector<Event> lone;
  for (int i = 0; i < 2000; ++i) {
    lone.push_back(streams::event_at(50'000 + i, i % 21 * 3, (i / 21) % 7 * 3, true));
  }
  detector.process(lone, nullptr);
  EXPECT_EQ(space_of(detector), before);
}

TEST(Original2016, TheRememberedMaximumIsAtMostTheTrueOne) {
  Original2016Config config;
  config.window_events = 300;
  const ImageSize size{128, 128};
  Original2016 detector(config, size);
  config.maximum = MaximumSearch::exact;
  Original2016 exact(config, size);
  const std::vector<Event> events = streams::cluttered(size, 12'000, 0.3, 7);
  std::vector<float> space(static_cast<std::size_t>(size.pixels()));
  int asked = 0;
  int below = 0;
  for (std::size_t i = 0; i < events.size(); i += 50, ++asked) {
    detector.process(std::span(events).subspan(i, 50), nullptr);
    ASSERT_TRUE(detector.hough_space(space));
    const auto most = static_cast<double>(*std::max_element(space.begin(), space.end()));
    const double remembered = detector.estimate().score;
    ASSERT_LE(remembered, most + 1e-6);
    exact.process(std::span(events).subspan(i, 50), nullptr);
    ASSERT_NEAR(exact.estimate().score, most, 1e-6);
    below += remembered < most - 1e-6 ? 1 : 0;
  }
  std::printf("below the true maximum in %.1f %% of %d estimates\n", 100.0 * below / asked, asked);
  EXPECT_GT(below, 0);
  EXPECT_LT(below, asked / 2);
}

TEST(Original2016, AnEmptyWindowHasNoVotes) {
  Original2016Config config;
  config.radius_px = {5, 12};
  config.window_events = 1;
  Original2016 detector(config, small_image);
  detector.process(streams::moving_edge(small_image, 0.4, 500, true), nullptr);
  // One event with two arcs of +-15 degrees: less than a third of a ring, in each plane.
  EXPECT_LT(detector.estimate().score * 26, 1.5 * 26);
  EXPECT_LE(sum(space_of(detector)), 8.0);
}

/// Events in turn on two rings, one of which has three times as many.
std::vector<Event> two_rings(double strong_x_px, double weak_x_px, double r_px) {
  std::vector<Event> events;
  for (int i = 0; i < 4000; ++i) {
    const double angle = i * 2.399963;  // by the golden angle: evenly in the long run
    const double x = (i % 4 == 0 ? weak_x_px : strong_x_px) + r_px * std::cos(angle);
    events.push_back(streams::event_at(i * 20, static_cast<int>(std::lround(x)),
                                       static_cast<int>(std::lround(64 + r_px * std::sin(angle))), true));
  }
  return events;
}

TEST(Trackers, PreferTheRingWithMoreEvents) {
  const ImageSize size{240, 128};
  ClusterDetector cluster({}, size);
  MultiKernelDetector multi_kernel({}, size);
  const std::vector<Event> events = two_rings(180, 50, 20);
  for (Detector* detector : {static_cast<Detector*>(&cluster), static_cast<Detector*>(&multi_kernel)}) {
    detector->process(events, nullptr);
    const Estimate e = detector->estimate();
    EXPECT_NEAR(e.circle.x_px, 180, 2.0);
    EXPECT_NEAR(e.circle.y_px, 64, 2.0);
    EXPECT_NEAR(e.circle.r_px, 20, 2.0);
  }
}

TEST(Trackers, LoseTheirScoreWithTimeWithoutEvents) {
  const ImageSize size{240, 128};
  ClusterDetector cluster({}, size);
  MultiKernelDetector multi_kernel({}, size);
  const std::vector<Event> events = two_rings(180, 50, 20);
  for (Detector* detector : {static_cast<Detector*>(&cluster), static_cast<Detector*>(&multi_kernel)}) {
    detector->process(events, nullptr);
    const Estimate before = detector->estimate();
    detector->advance_to(events.back().t_us + 5'000, nullptr);
    EXPECT_LT(detector->estimate().score, before.score);
    EXPECT_EQ(detector->estimate().circle.x_px, before.circle.x_px);
    detector->advance_to(events.back().t_us + 1'000'000, nullptr);
    EXPECT_FALSE(detector->estimate().valid);
  }
}

TEST(MultiKernel, UniformEventsGiveLessActivityThanARing) {
  const ImageSize size{128, 128};
  MultiKernelDetector ring({}, size);
  MultiKernelDetector spread({}, size);
  const std::vector<Event> on_ring = two_rings(64, 64, 20);
  std::vector<Event> everywhere = streams::random(size, on_ring.size(), 3);
  for (std::size_t i = 0; i < everywhere.size(); ++i) everywhere[i].t_us = on_ring[i].t_us;
  ring.process(on_ring, nullptr);
  spread.process(everywhere, nullptr);
  EXPECT_GT(ring.estimate().score, 5.0 * spread.estimate().score);
}

}  // namespace
}  // namespace saccade
