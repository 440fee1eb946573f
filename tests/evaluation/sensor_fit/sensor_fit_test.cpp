// Sensors with known parameters are recorded with the emulator before known stimuli and fitted.
#include "evaluation/sensor_fit/sensor_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/random.h"
#include "emulator/event_emulator.h"
#include "evaluation/sensor_fit/event_features.h"
#include "evaluation/sensor_fit/leak_fit.h"
#include "evaluation/sensor_fit/pixel_trains.h"
#include "evaluation/sensor_fit/sensor_recording.h"
#include "evaluation/sensor_fit/stimulus.h"

namespace saccade {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr ImageSize size{40, 40};

Stimulus still(double luminance) {
  Stimulus s;
  s.kind = StimulusKind::still;
  s.luminance = luminance;
  return s;
}

Stimulus board(std::vector<std::array<double, 3>> path) {
  Stimulus s;
  s.kind = StimulusKind::board;
  s.rows = 4;
  s.columns = 3;
  s.spacing_px = 9.0;
  s.dot_diameter_px = 7.0;
  s.path = std::move(path);
  s.dark = 12.0;
  s.light = 200.0;
  s.blur_px = 0.0;
  return s;
}

Stimulus panel() {
  Stimulus s;
  s.kind = StimulusKind::panel;
  s.region_px = {10.0, 10.0, 7.0, 7.0};
  s.points = {{0.0, 20.0}, {0.1, 28.0}, {0.2, 60.0}, {0.3, 240.0}, {0.4, 120.0}, {0.5, 40.0}};
  s.period_s = 0.6;
  return s;
}

/// What a sensor records of a stimulus in `duration_us`, with images at the given times.
SensorRecording record(const char* name, const Stimulus& stimulus, const EmulatorConfig& sensor,
                       const std::vector<std::int64_t>& times_us) {
  EventEmulator emulator(sensor, size, RandomStream(77, name).bits(0));
  ShownStimulus shown(stimulus);
  std::vector<Event> events;
  std::vector<float> image(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height));
  for (const std::int64_t t_us : times_us) {
    shown.move_to(t_us);
    std::size_t pixel = 0;
    for (int y = 0; y < size.height; ++y) {
      for (int x = 0; x < size.width; ++x) image[pixel++] = shown.luminance(x, y);
    }
    emulator.process_image(image, t_us, events);
  }
  emulator.finish(events);
  SensorRecording recording(name, stimulus, size, 0, times_us.back());
  recording.add(events);
  recording.finish();
  return recording;
}

SensorRecording record(const char* name, const Stimulus& stimulus, const EmulatorConfig& sensor,
                       double seconds) {
  const auto end_us = static_cast<std::int64_t>(seconds * 1e6);
  return record(name, stimulus, sensor, image_times_us(stimulus, {0, end_us}));
}

EmulatorConfig other_sensor() {
  EmulatorConfig sensor = emulator_preset("dvs128");
  sensor.contrast_threshold_on = 0.27;
  sensor.contrast_threshold_off = 0.16;
  sensor.threshold_mismatch = 0.04;
  sensor.cutoff_hz = 900.0;
  sensor.refractory_us = 900;
  sensor.leak_rate_hz = 0.25;
  sensor.shot_noise_rate_hz = 1.5;
  sensor.latency_us = 60;
  sensor.readout_rate_hz = 0.0;
  return sensor;
}

const FittedParameter& parameter(const SensorFit& fit, std::string_view key) {
  for (const FittedParameter& p : fit.parameters) {
    if (p.key == key) return p;
  }
  throw std::runtime_error("no parameter " + std::string(key));
}

TEST(SensorFit, FindsTheParametersOfAnEmulatedSensor) {
  EmulatorConfig sensor = other_sensor();
  sensor.hot_pixel_share = 0.005;
  sensor.hot_pixel_rate_hz = 200.0;  // of which the refractory period takes 15 %
  std::vector<SensorRecording> recordings;
  recordings.push_back(record("dark", still(0.0), sensor, 120.0));
  recordings.push_back(record("light", still(150.0), sensor, 120.0));
  recordings.push_back(record("slow", board({{0.0, -50.0, 4.0}, {3.0, 40.0, 4.0}}), sensor, 3.0));
  recordings.push_back(
      record("fast", board({{0.0, -50.0, 4.0}, {0.2, 40.0, 4.0}, {0.4, -50.0, 4.0}, {0.6, 40.0, 4.0}}),
             sensor, 0.6));
  recordings.push_back(record("panel", panel(), sensor, 12.0));
  const SensorFit fit =
      fit_sensor(recordings, {.prior = emulator_preset("dvs128"), .seed = 1, .progress = {}});
  const auto expect_within = [&](const char* key, double value, double relative) {
    const FittedParameter& p = parameter(fit, key);
    EXPECT_TRUE(p.identifiable) << key;
    EXPECT_NEAR(p.value / value, 1.0, relative) << key << " " << p.value << " +- " << p.deviation;
  };
  // The bounds of the issue: thresholds 5 %, bandwidth 15 %, noise and refractory period 20 %.
  expect_within("contrast_threshold_on", 0.27, 0.05);
  expect_within("contrast_threshold_off", 0.16, 0.05);
  expect_within("cutoff_hz", 900.0, 0.15);
  expect_within("refractory_us", 900.0, 0.2);
  expect_within("leak_rate_hz", 0.25, 0.2);
  expect_within("shot_noise_rate_hz", 1.5, 0.2);
  expect_within("hot_pixel_rate_hz", 200.0, 0.05);
  // Leak of a period of 4 s survives shot noise of 1.4 Hz in the dark in a share of exp(-5.7) of all intervals, that of
  // 0.8 Hz in light in a share of exp(-3.2).
  EXPECT_THAT(parameter(fit, "leak_rate_hz").decided_by, StartsWith("light"));
  const FittedParameter& readout = parameter(fit, "readout_rate_hz");
  EXPECT_FALSE(readout.identifiable);
  EXPECT_EQ(fit.config.readout_rate_hz, emulator_preset("dvs128").readout_rate_hz);
  EXPECT_THAT(readout.decided_by, StartsWith("no limit below "));
  EXPECT_LT(fit.misfit_after, 0.3 * fit.misfit_before);
  for (const ComparedDistribution& d : fit.distributions) {
    EXPECT_LT(d.ks_after, std::max(0.12, d.ks_before)) << d.recording << ": " << d.quantity;
  }
}

TEST(SensorFit, CallsThresholdsAndLatencyNotIdentifiableInAStillScene) {
  EmulatorConfig sensor = emulator_preset("dvs128");
  sensor.leak_rate_hz = 0.3;
  sensor.shot_noise_rate_hz = 2.0;
  std::vector<SensorRecording> recordings;
  recordings.push_back(record("dark", still(0.0), sensor, 120.0));
  const SensorFit fit =
      fit_sensor(recordings, {.prior = emulator_preset("dvs128"), .seed = 1, .progress = {}});
  for (const char* key : {"contrast_threshold_on", "contrast_threshold_off", "cutoff_hz", "latency_us"}) {
    EXPECT_FALSE(parameter(fit, key).identifiable) << key;
    EXPECT_EQ(parameter(fit, key).value, parameter(fit, key).prior) << key;
    EXPECT_THAT(parameter(fit, key).decided_by, HasSubstr("no ")) << key;
  }
  EXPECT_NEAR(parameter(fit, "leak_rate_hz").value, 0.3, 0.03);
  EXPECT_NEAR(parameter(fit, "shot_noise_rate_hz").value, 2.0, 0.2);
}

TEST(SensorFit, GivesALimitOfALeakThatShotNoiseHides) {
  EmulatorConfig sensor = emulator_preset("dvs128");
  sensor.leak_rate_hz = 0.03;
  sensor.shot_noise_rate_hz = 3.0;
  std::vector<SensorRecording> recordings;
  recordings.push_back(record("dark", still(0.0), sensor, 100.0));
  const SensorFit fit =
      fit_sensor(recordings, {.prior = emulator_preset("dvs128"), .seed = 1, .progress = {}});
  const FittedParameter& leak = parameter(fit, "leak_rate_hz");
  EXPECT_FALSE(leak.identifiable) << leak.value << " +- " << leak.deviation;
  EXPECT_THAT(leak.decided_by, StartsWith("no leak above "));
  EXPECT_NEAR(parameter(fit, "shot_noise_rate_hz").value, 3.0, 0.15);
}

TEST(LeakFit, SeparatesARareLeakFromShotNoise) {
  EmulatorConfig sensor = emulator_preset("dvs128");
  sensor.leak_rate_hz = 0.08;
  sensor.leak_spread_decades = 0.12;
  sensor.shot_noise_rate_hz = 1.2;
  std::vector<SensorRecording> recordings;
  recordings.push_back(record("dark", still(0.0), sensor, 120.0));
  recordings.push_back(record("white", still(255.0), sensor, 120.0));
  const LeakFit fit = fit_leak(recordings, {0.2, 2.0, 0.1, 1.0});
  // Of the shot noise in white 0.3 Hz are left; a share of exp(-3.75) of the intervals lasts for the period of 12.5 s.
  EXPECT_NEAR(fit.rate_hz, 0.08, 0.008);
  EXPECT_LT(fit.rate_deviation, 0.1);
  EXPECT_NEAR(fit.spread_decades, 0.12, 0.04);
  EXPECT_LT(fit.highest_rate_hz, 0.1);
  EXPECT_GT(fit.events[1], 10.0 * fit.events[0]);
}

TEST(SensorFit, FindsHotPixelsAndABusThatIsBusy) {
  EmulatorConfig sensor = emulator_preset("dvs128");
  sensor.hot_pixel_share = 0.01;
  sensor.hot_pixel_rate_hz = 60.0;
  const SensorRecording dark = record("dark", still(0.0), sensor, 120.0);
  const SensorRecording::HotPixels hot = dark.hot_pixels();
  EXPECT_NEAR(static_cast<double>(hot.places.size()), 16.0, 9.0);  // of 1600, drawn at 1 %
  EXPECT_NEAR(hot.rate_hz, 60.0, 6.0);                             // the refractory period takes 3 %
  EXPECT_FALSE(dark.readout().is_busy);

  sensor.readout_rate_hz = 400'000.0;
  std::vector<std::array<double, 3>> path;
  for (int i = 0; i < 8; ++i) path.push_back({0.02 * i, i % 2 == 0 ? -50.0 : 40.0, 4.0});
  const SensorRecording fast = record("fast", board(path), sensor, 0.14);
  EXPECT_TRUE(fast.readout().is_busy);
  EXPECT_NEAR(fast.readout().rate_hz, 400'000.0, 4'000.0);
}

TEST(SensorRecording, RejectsAStimulusOutsideTheRecording) {
  EXPECT_THAT(
      [] {
        SensorRecording("slow", board({{10.0, 0.0, 0.0}, {11.0, 5.0, 0.0}}), size, 0, 1'000'000);
      },
      testing::ThrowsMessage<InputError>(
          HasSubstr("stimuli.slow: found a stimulus from 10000000 to 11000000 us")));
  Stimulus outside = panel();
  outside.region_px[0] = 36.0;
  EXPECT_THAT([&] { SensorRecording("panel", outside, size, 0, 10'000'000); },
              testing::ThrowsMessage<InputError>(
                  HasSubstr("stimuli.panel.region_px: found pixels outside the image")));
}

TEST(EventFeatures, HaveTheDeviationThatChanceGives) {
  // Poisson processes of 2 events per pixel and second in 50 s of 400 pixels: the rate's deviation is sqrt(2 / 20000).
  const RandomStream random(5, "features");
  PixelTrains trains(400);
  for (std::size_t pixel = 0; pixel < 400; ++pixel) {
    double t_s = 0.0;
    for (std::uint64_t k = 0;; ++k) {
      t_s -= std::log(1.0 - random.uniform(pixel, k)) / 2.0;
      if (t_s > 50.0) break;
      trains.add(pixel, {static_cast<std::int64_t>(t_s * 1e6), true});
    }
  }
  trains.finish();
  const std::vector<Feature> features = features_of(still(0.0), {0, 50'000'000}, trains);
  EXPECT_EQ(features[1].name, "ON rate");
  EXPECT_NEAR(features[1].value(), 2.0, 0.04);
  EXPECT_NEAR(features[1].deviation(), 0.01, 0.005);
  EXPECT_TRUE(std::isnan(features[4].value()));  // intervals of OFF events, of which there are none
}

TEST(Stimulus, APanelRepeatsItsPointsAndStepsWithinAMicrosecond) {
  const Stimulus s = panel();
  ShownStimulus shown(s);
  for (const auto& [t_us, luminance] : {std::pair<std::int64_t, float>{0, 20.0F},
                                        {99'999, 20.0F},
                                        {100'000, 28.0F},
                                        {599'999, 40.0F},
                                        {600'000, 20.0F},
                                        {1'500'000, 240.0F}}) {
    shown.move_to(t_us);
    EXPECT_EQ(shown.luminance(0.0, 0.0), luminance) << t_us;
  }
  const std::vector<PanelStep> steps = steps_of(s);
  ASSERT_EQ(steps.size(), 6U);
  EXPECT_EQ(steps[0].before, 40.0);
  EXPECT_EQ(steps[5].until_s, 0.6);
  const auto times = image_times_us(s, {0, 1'200'000});
  EXPECT_THAT(times, testing::IsSupersetOf({99'999, 100'000, 599'999, 600'000, 699'999, 700'000}));
  EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
}

TEST(Stimulus, ABoardHasItsDotsWhereCalibrateHasThem) {
  const Stimulus s = board({{0.0, 10.0, 5.0}, {1.0, 20.0, 5.0}});
  ShownStimulus shown(s);
  shown.move_to(500'000);  // the first dot is at (15, 5)
  for (const auto& [x, y] : {std::pair{15.0, 5.0}, {33.0, 5.0}, {24.0, 14.0}, {15.0, 23.0}}) {
    EXPECT_EQ(shown.luminance(x, y), 12.0F) << x << " " << y;
  }
  EXPECT_EQ(shown.luminance(24.0, 5.0), 200.0F);
  EXPECT_EQ(shown.luminance(6.0, 14.0), 200.0F);                // left of the second row's first dot
  EXPECT_NEAR(shown.luminance(15.0 + 3.5, 5.0), 106.0F, 1.0F);  // on an edge
}

}  // namespace
}  // namespace saccade
