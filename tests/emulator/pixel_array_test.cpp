#include "emulator/pixel_array.h"

#include <gtest/gtest.h>

#include <cmath>

namespace saccade {
namespace {

/// A sensor of logarithmic pixels without noise, bandwidth, mismatch and dead time.
EmulatorConfig ideal_pixels() {
  EmulatorConfig config;
  config.dark_current = 0.0;
  config.cutoff_hz = 0.0;
  config.threshold_mismatch = 0.0;
  config.refractory_us = 0;
  config.leak_rate_hz = 0.0;
  config.shot_noise_rate_hz = 0.0;
  config.latency_us = 0;
  return config;
}

std::vector<PixelEvent> events_of(PixelArray& array, std::vector<float> luminance, std::int64_t t_us) {
  std::vector<PixelEvent> events;
  array.process(luminance, {}, t_us, events);
  return events;
}

TEST(PixelArray, MakesAnEventAtEachCrossingOfAThreshold) {
  PixelArray array(ideal_pixels(), 10, 2, 1);
  EXPECT_TRUE(events_of(array, {100.0F, 100.0F}, 0).empty()) << "the first image sets the references";
  // The logarithm rises by 1 = five thresholds of 0.2, linearly in time; the second pixel falls by 0.5.
  const auto events = events_of(
      array, {100.0F * static_cast<float>(std::exp(1.0)), 100.0F * static_cast<float>(std::exp(-0.5))},
      10'000);
  ASSERT_GE(events.size(), 6U);
  std::size_t on = 0, off = 0;
  for (const PixelEvent& event : events) {
    if (event.on) {
      ++on;
      EXPECT_EQ(event.pixel, 10U);
      EXPECT_NEAR(static_cast<double>(event.t_us), 2000.0 * static_cast<double>(on), 2.0);
    } else {
      ++off;
      EXPECT_EQ(event.pixel, 11U);
      EXPECT_NEAR(static_cast<double>(event.t_us), 4000.0 * static_cast<double>(off), 2.0);
    }
  }
  EXPECT_GE(on, 4U);  // the fifth lies at the end of the interval, within rounding
  EXPECT_EQ(off, 2U);
  EXPECT_NEAR(array.output_log(1) - array.reference_log(1), -0.1, 1e-3)
      << "what is left after two thresholds";
}

TEST(PixelArray, APixelDependsOnItsNumberAndNotOnItsNeighbours) {
  EmulatorConfig noisy = ideal_pixels();
  noisy.threshold_mismatch = 0.1;
  noisy.shot_noise_rate_hz = 200.0;
  PixelArray whole(noisy, 0, 600, 7), part(noisy, 550, 20, 7);
  std::vector<PixelEvent> of_whole, of_part;
  const auto image = [](std::size_t count, float value) { return std::vector<float>(count, value); };
  for (int i = 0; i <= 20; ++i) {
    const float value = 50.0F + 5.0F * static_cast<float>(i % 7);
    for (const PixelEvent& event : events_of(whole, image(600, value), i * 1000)) {
      if (event.pixel >= 550 && event.pixel < 570) of_whole.push_back(event);
    }
    for (const PixelEvent& event : events_of(part, image(20, value), i * 1000)) of_part.push_back(event);
  }
  ASSERT_GT(of_part.size(), 100U);
  ASSERT_EQ(of_part.size(), of_whole.size());
  for (std::size_t i = 0; i < of_part.size(); ++i) {
    EXPECT_EQ(of_part[i].t_us, of_whole[i].t_us);
    EXPECT_EQ(of_part[i].pixel, of_whole[i].pixel);
    EXPECT_EQ(of_part[i].on, of_whole[i].on);
  }
}

}  // namespace
}  // namespace saccade
