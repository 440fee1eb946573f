// What the noise of scenes at rest says about a sensor: on emulated sensors of known thresholds before light with
// Gaussian noise behind a low-pass.
#include "evaluation/sensor_fit/still_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "emulator/event_emulator.h"
#include "evaluation/sensor_fit/sensor_fit.h"
#include "evaluation/sensor_fit/sensor_page.h"
#include "evaluation/sensor_fit/still_noise.h"

namespace saccade {
namespace {

using testing::HasSubstr;

constexpr double time_constant_s = 1.6e-3;
constexpr double noise = 0.05;  ///< standard deviation of log luminance

struct Sensor {
  double on, off;  // thresholds
  std::int64_t refractory_us;
};

EmulatorConfig config_of(const Sensor& sensor) {
  EmulatorConfig config = emulator_preset("ideal");  // the light has its low-pass already
  config.contrast_threshold_on = sensor.on;
  config.contrast_threshold_off = sensor.off;
  config.refractory_us = sensor.refractory_us;
  config.leak_rate_hz = 0.05;
  return config;
}

SensorRecording recorded(const Sensor& sensor, unsigned seed, double seconds) {
  constexpr ImageSize size{12, 12};
  constexpr std::int64_t step_us = 16;  // a hundredth of the time constant
  constexpr double light = 100.0;
  const double kept = std::exp(-1e-6 * step_us / time_constant_s);
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::vector<float> level(144), image(144);
  for (float& v : level) v = normal(random);
  EventEmulator emulator(config_of(sensor), size, seed);
  std::vector<Event> events;
  const auto end_us = static_cast<std::int64_t>(1e6 * seconds);
  const auto keep = static_cast<float>(kept), fresh = static_cast<float>(std::sqrt(1.0 - kept * kept));
  for (std::int64_t t_us = 0; t_us <= end_us; t_us += step_us) {
    for (std::size_t i = 0; i < level.size(); ++i) {
      level[i] = keep * level[i] + fresh * normal(random);
      image[i] = static_cast<float>(light * std::exp(noise * static_cast<double>(level[i])));
    }
    emulator.process_image(image, t_us, events);
  }
  emulator.finish(events);
  SensorRecording recording("still", Stimulus{}, size, 0, end_us);
  recording.add(events);
  recording.finish();
  return recording;
}

EmulatorConfig prior() {
  EmulatorConfig config = emulator_preset("dvs128");
  config.cutoff_follows_light = false;
  return config;
}

class KnownThreshold : public testing::TestWithParam<unsigned> {};

TEST_P(KnownThreshold, OverTheNoiseLiesInsideTheInterval) {
  constexpr std::array sensors{Sensor{0.17, 0.17, 500}, Sensor{0.19, 0.16, 200}, Sensor{0.16, 0.2, 1500}};
  const Sensor sensor = sensors[GetParam() - 1];
  const StillFit fit = fit_still(recorded(sensor, GetParam(), 4.0), prior());
  EXPECT_EQ(fit.limit, "");
  const auto expect_holds = [](const StillValue& v, double value, double widest, const char* what) {
    EXPECT_TRUE(v.identifiable) << what;
    EXPECT_LT(v.low, value) << what << " " << v.value;
    EXPECT_GT(v.high, value) << what << " " << v.value;
    EXPECT_LT(v.high / v.low, widest) << what;
  };
  // Images 16 us apart hide passages in between: ratios look larger by 0.58 sqrt(2 x 0.01) = 0.08.
  expect_holds(fit.on, sensor.on / noise, 1.3, "ON threshold / noise");
  expect_holds(fit.off, sensor.off / noise, 1.3, "OFF threshold / noise");
  expect_holds(fit.on_over_off, sensor.on / sensor.off, 1.3, "ON / OFF");
  EXPECT_NEAR(std::log(fit.cutoff_hz.value * 2.0 * std::numbers::pi * time_constant_s), 0.0, 0.25);
  EXPECT_NEAR(std::log(fit.refractory_s.value / (1e-6 * static_cast<double>(sensor.refractory_us))), 0.0,
              0.25);
}
INSTANTIATE_TEST_SUITE_P(Seeds, KnownThreshold, testing::Values(1U, 2U, 3U));

TEST(StillFit, TwiceTheThresholdWithTwiceTheNoiseIsTheSameSensor) {
  const std::array<double, 3> edges{1e-4, 1e-2, 1.0};
  const StillRates one = still_rates({3.4, 3.2, 1e-3, 5e-4, 0.1}, edges);
  const StillRates faster =
      still_rates({3.4, 3.2, 5e-4, 2.5e-4, 0.2}, std::array<double, 3>{5e-5, 5e-3, 0.5});
  EXPECT_NEAR(faster.on_hz / one.on_hz, 2.0, 1e-9);  // only the time constant sets a time
  EXPECT_NEAR(faster.intervals_hz[1][0] / one.intervals_hz[1][0], 2.0, 1e-9);
}

/// A fit of 20 x 20 pixels of `sensor` before a uniform image that does not change.
StillFit fit_of_still(const EmulatorConfig& sensor, float luminance, std::int64_t duration_us) {
  EventEmulator emulator(sensor, {20, 20}, 1);
  std::vector<Event> events;
  const std::vector<float> image(400, luminance);
  emulator.process_image(image, 0, events);
  emulator.process_image(image, duration_us, events);
  emulator.finish(events);
  SensorRecording recording("still", Stimulus{}, {20, 20}, 0, duration_us);
  recording.add(events);
  recording.finish();
  return fit_still(recording, prior());
}

TEST(StillFit, SaysWhichLimitAPixelWithoutNoiseSets) {
  EmulatorConfig sensor = emulator_preset("dvs128");
  sensor.shot_noise_rate_hz = 0.0;
  const StillFit fit = fit_of_still(sensor, 100.0F, 100'000'000);
  EXPECT_FALSE(fit.on.identifiable);
  EXPECT_GT(fit.on_events, 3000U);  // leak
  EXPECT_THAT(fit.limit, HasSubstr("0 OFF events: threshold / noise is above "));
}

TEST(StillFit, ShotNoiseThatIsAPoissonProcessHasNoThreshold) {
  EmulatorConfig sensor = emulator_preset("dvs128");
  sensor.shot_noise_rate_hz = 3.0;
  const StillFit fit = fit_of_still(sensor, 0.0F, 60'000'000);
  EXPECT_FALSE(fit.on.identifiable) << fit.on.value << " misfit " << fit.misfit;
  EXPECT_NE(fit.limit, "");
}

TEST(StillFit, TheFitKeepsTheMeanThresholdAndTakesTheirQuotient) {
  std::vector<SensorRecording> recordings;
  recordings.push_back(recorded({0.19, 0.16, 500}, 4, 2.0));
  SensorFitConfig config{.prior = prior(), .seed = 1, .still = true, .known_light = true, .progress = {}};
  const SensorFit fit = fit_sensor(recordings, config);
  ASSERT_EQ(fit.still.size(), 1U);
  const std::string remark = sensor_fit_remark(fit);
  EXPECT_THAT(remark, HasSubstr("# Fitted by saccade fit-sensor: rms residual of "));
  EXPECT_THAT(remark,
              HasSubstr("with the prior dvs128.\n# KS distances to pixels that the fit did not use: "));
  EXPECT_THAT(remark, HasSubstr("# Not identifiable: contrast_threshold_on, contrast_threshold_off, "));
  EXPECT_NEAR(fit.config.contrast_threshold_on / fit.config.contrast_threshold_off, 0.19 / 0.16, 0.1);
  EXPECT_NEAR(fit.config.contrast_threshold_on * fit.config.contrast_threshold_off, 0.04, 1e-9);
  for (const FittedParameter& p : fit.parameters) {
    if (p.key != "contrast_threshold_on") continue;
    EXPECT_FALSE(p.identifiable);
    EXPECT_THAT(p.decided_by, HasSubstr("only threshold / noise: still 3."));
  }
}

}  // namespace
}  // namespace saccade
