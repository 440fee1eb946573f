// The stages of EmulatorConfig one by one, against their formulas.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <tuple>

#include "core/random.h"
#include "emulator/event_emulator.h"

namespace saccade {
namespace {

EmulatorConfig ideal() { return emulator_preset("ideal"); }

struct LabelledCounts {
  std::vector<Event> events;
  std::vector<EventLabel> labels;
  EmulatorCounts counts;
};

/// Pixels in constant light, with an image every dt_us.
LabelledCounts in_still_light(const EmulatorConfig& config, ImageSize size, float luminance,
                              double duration_s, std::int64_t dt_us, std::uint64_t seed = 1) {
  EventEmulator emulator(config, size, seed);
  const std::vector<float> image(static_cast<std::size_t>(size.pixels()), luminance);
  LabelledCounts out;
  for (std::int64_t t_us = 0; t_us <= std::llround(duration_s * 1e6); t_us += dt_us) {
    emulator.process_image(image, t_us, out.events, &out.labels);
  }
  emulator.finish(out.events, &out.labels);
  out.counts = emulator.counts();
  return out;
}

/// One pixel's event times after its light steps by `rise` ln at 0; images every dt_us, each held until the next.
std::vector<std::int64_t> after_a_step(const EmulatorConfig& config, double rise, std::int64_t dt_us,
                                       std::int64_t until_us, float luminance = 50.0F) {
  EventEmulator emulator(config, {1, 1}, 1);
  std::vector<Event> events;
  const auto bright = static_cast<float>(static_cast<double>(luminance) * std::exp(rise));
  emulator.process_image({&luminance, 1}, -dt_us, events);
  for (std::int64_t t_us = 0; t_us <= until_us; t_us += dt_us)
    emulator.process_image({&bright, 1}, t_us, events);
  emulator.finish(events);
  std::vector<std::int64_t> times_us;
  for (const Event& e : events) times_us.push_back(e.t_us);
  return times_us;
}

TEST(EmulatorStages, LowPassRespondsToAStepLikeOnePole) {
  EmulatorConfig config = ideal();
  config.cutoff_hz = 300.0;
  config.interpolation = Interpolation::held;
  const double tau_us = 1e6 / (2.0 * 3.14159265358979323846 * 300.0);
  for (const std::int64_t dt_us : {10, 100, 1000, 10'000}) {
    const auto times_us = after_a_step(config, 1.05, dt_us, 20'000);
    ASSERT_EQ(times_us.size(), 5U) << dt_us;
    std::printf("dt %5lld us:", static_cast<long long>(dt_us));
    for (std::size_t k = 0; k < 5; ++k) {
      const double expected_us = -tau_us * std::log(1.0 - 0.2 * static_cast<double>(k + 1) / 1.05);
      std::printf(" %lld (%.2f)", static_cast<long long>(times_us[k]), expected_us);
      EXPECT_NEAR(static_cast<double>(times_us[k]), expected_us, 1.0) << dt_us;
    }
    std::printf("\n");
  }
}

TEST(EmulatorStages, LowPassFollowsARampAlikeAtAnyImageRate) {
  // dv/dt = (s t - v) / tau from rest: v = s (t - tau (1 - exp(-t / tau))), here sampled at its own crossings.
  EmulatorConfig config = ideal();
  config.cutoff_hz = 100.0;
  const double tau = 1.0 / (2.0 * 3.14159265358979323846 * 100.0);
  const double slope = 40.0;
  for (const std::int64_t dt_us : {20, 1000, 50'000}) {
    EventEmulator emulator(config, {1, 1}, 1);
    std::vector<Event> events;
    for (std::int64_t t_us = 0; t_us <= 50'000; t_us += dt_us) {
      const auto luminance = static_cast<float>(10.0 * std::exp(slope * static_cast<double>(t_us) * 1e-6));
      emulator.process_image({&luminance, 1}, t_us, events);
    }
    ASSERT_GE(events.size(), 8U);
    double worst = 0.0;
    for (std::size_t k = 0; k < events.size(); ++k) {
      const double t = static_cast<double>(events[k].t_us) * 1e-6;
      const double v = slope * (t - tau * (1.0 - std::exp(-t / tau)));
      const double speed = slope * (1.0 - std::exp(-t / tau));
      worst = std::max(worst, std::abs(v - 0.2 * static_cast<double>(k + 1)) / speed * 1e6);
    }
    std::printf("ramp, dt %5lld us: %zu events, worst %.2f us from the formula\n",
                static_cast<long long>(dt_us), events.size(), worst);
    EXPECT_LE(worst, 1.0);
  }
}

TEST(EmulatorStages, LowPassDetectsAnExcursionBetweenTwoImages) {
  // The light drops immediately after its rise, but the slow output rises to a peak in between.
  EmulatorConfig config = ideal();
  config.cutoff_hz = 60.0;
  const auto events_at = [&](std::int64_t dt_us) {
    EventEmulator emulator(config, {1, 1}, 1);
    std::vector<Event> events;
    for (std::int64_t t_us = 0; t_us <= 24'000; t_us += dt_us) {
      const double t_ms = static_cast<double>(t_us) * 1e-3;
      const double level = t_ms < 4.0 ? 0.5 * t_ms : std::max(0.0, 2.0 - 0.1 * (t_ms - 4.0));
      const auto luminance = static_cast<float>(20.0 * std::exp(level));
      emulator.process_image({&luminance, 1}, t_us, events);
    }
    return events;
  };
  const std::vector<Event> fine = events_at(50);
  const std::vector<Event> coarse = events_at(4000);
  ASSERT_GT(std::count_if(fine.begin(), fine.end(), [](const Event& e) { return !e.on; }), 0);
  ASSERT_EQ(coarse.size(), fine.size());
  for (std::size_t i = 0; i < fine.size(); ++i) {
    EXPECT_EQ(coarse[i].on, fine[i].on);
    EXPECT_NEAR(static_cast<double>(coarse[i].t_us), static_cast<double>(fine[i].t_us), 1.0);
  }
}

TEST(EmulatorStages, LatencyFallsWithTheLightDownToTheComparators) {
  EmulatorConfig config = ideal();
  config.cutoff_hz = 3000.0;
  config.cutoff_follows_light = true;
  config.interpolation = Interpolation::held;
  config.latency_us = 15;
  std::vector<double> latency_us;
  const std::vector<double> luminances = {0.2, 2.0, 20.0, 200.0, 2e6};
  for (const double luminance : luminances) {
    const double bright = luminance / std::exp(0.3);
    const auto times_us = after_a_step(config, 0.3, 200'000, 200'000, static_cast<float>(bright));
    ASSERT_GE(times_us.size(), 1U);
    latency_us.push_back(static_cast<double>(times_us.front()));
  }
  std::printf("latency of a 0.3 ln step at luminance");
  for (std::size_t i = 0; i < luminances.size(); ++i)
    std::printf(" %g: %.0f us", luminances[i], latency_us[i]);
  std::printf("\n");
  for (std::size_t i = 1; i < 4; ++i) {
    const double slope = std::log10((latency_us[i] - 15.0) / (latency_us[i - 1] - 15.0));
    EXPECT_NEAR(slope, -1.0, 0.02);
  }
  EXPECT_NEAR(latency_us.back(), 15.0, 1.0);
}

TEST(EmulatorStages, DroppedEventsOfTheRefractoryPeriodMoveTheReference) {
  // 100 ln/s: a crossing every 2 ms. Events within 5 ms after an event are dropped: every third one remains.
  EmulatorConfig config = ideal();
  config.refractory_us = 5000;
  config.refractory_mode = RefractoryMode::drop;
  EventEmulator emulator(config, {1, 1}, 1);
  std::vector<Event> events;
  for (int k = 0; k <= 60; ++k) {
    const auto luminance = static_cast<float>(1e-2 * std::exp(0.1 * k));
    emulator.process_image({&luminance, 1}, k * 1000, events);
  }
  ASSERT_GE(events.size(), 9U);
  for (std::size_t i = 1; i < events.size(); ++i) {
    EXPECT_NEAR(static_cast<double>(events[i].t_us - events[i - 1].t_us), 6000.0, 1.0);
  }
}

TEST(EmulatorStages, NoPixelIsFasterThanItsRefractoryPeriodForAnyCause) {
  for (const RefractoryMode mode : {RefractoryMode::reset, RefractoryMode::drop}) {
    EmulatorConfig config = ideal();
    config.refractory_us = 3000;
    config.refractory_mode = mode;
    config.shot_noise_rate_hz = 200.0;
    config.leak_rate_hz = 40.0;
    config.hot_pixel_share = 0.2;
    config.hot_pixel_rate_hz = 2000.0;
    const ImageSize size{16, 16};
    EventEmulator emulator(config, size, 3);
    std::vector<Event> events;
    std::vector<float> image(256);
    const RandomStream random(4, "flicker");
    for (int k = 0; k <= 2000; ++k) {
      for (std::size_t i = 0; i < 256; ++i) {
        image[i] = static_cast<float>(20.0 + 200.0 * random.uniform(i, static_cast<std::uint64_t>(k / 7)));
      }
      emulator.process_image(image, k * 1000, events);
    }
    std::vector<std::int64_t> last_us(256, -1'000'000);
    std::int64_t shortest_us = 1'000'000;
    for (const Event& e : events) {
      std::int64_t& last = last_us[static_cast<std::size_t>(e.y * 16 + e.x)];
      shortest_us = std::min(shortest_us, e.t_us - last);
      last = e.t_us;
    }
    std::printf("%s: shortest interval %lld us of %zu events\n", word_of(mode).data(),
                static_cast<long long>(shortest_us), events.size());
    EXPECT_GE(shortest_us, 3000);
    EXPECT_LT(shortest_us, 3100);
  }
}

TEST(EmulatorStages, PixelsLeakOnEventsAtTheirRate) {
  EmulatorConfig config = ideal();
  config.leak_rate_hz = 0.1;
  std::vector<std::size_t> counts;
  for (const std::int64_t dt_us : {1000, 100'000}) {
    const LabelledCounts out = in_still_light(config, {64, 64}, 100.0F, 100.0, dt_us);
    const double rate_hz = static_cast<double>(out.counts.on) / 4096.0 / 100.0;
    std::printf("leak, dt %lld ms: %.4f Hz per pixel (law 0.1027)\n", static_cast<long long>(dt_us / 1000),
                rate_hz);
    EXPECT_EQ(out.counts.off, 0);
    EXPECT_EQ(out.counts.by_cause[static_cast<int>(EventCause::leak)], out.counts.on);
    EXPECT_NEAR(rate_hz, 0.1027, 0.02 * 0.1027);
    counts.push_back(out.events.size());
  }
  EXPECT_EQ(counts[0], counts[1]);
}

TEST(EmulatorStages, ShotNoiseHasItsRateAndDistribution) {
  EmulatorConfig config = ideal();
  config.shot_noise_rate_hz = 5.0;
  config.threshold_mismatch = 0.03;
  std::vector<std::vector<Event>> streams;
  for (const std::int64_t dt_us : {100, 1000, 10'000, 33'000}) {
    const double duration_s = 9.9;
    const LabelledCounts out = in_still_light(config, {64, 64}, 120.0F, duration_s, dt_us);
    const double rate_hz = static_cast<double>(out.events.size()) / 4096.0 / duration_s;
    const double law_hz = 5.0 * (1.0 - 0.75 * (120.0 + 20.0) / 275.0);
    const double ratio = static_cast<double>(out.counts.on) / static_cast<double>(out.counts.off);
    std::printf("shot, dt %5.1f ms: %.4f Hz per pixel (law %.4f), ON:OFF %.4f\n",
                static_cast<double>(dt_us) * 1e-3, rate_hz, law_hz, ratio);
    EXPECT_NEAR(rate_hz, law_hz, 0.02 * law_hz);
    EXPECT_NEAR(ratio, 1.0, 0.02);
    // Uniform inside the interval between images.
    double mean = 0.0;
    for (const Event& e : out.events) {
      const std::int64_t into = (e.t_us - 1) % dt_us + 1;
      mean += static_cast<double>(into) / static_cast<double>(dt_us) / static_cast<double>(out.events.size());
    }
    EXPECT_NEAR(mean, 0.5 + 0.5 / static_cast<double>(dt_us), 0.01);
    streams.push_back(out.events);
  }
  for (const auto& stream : streams) EXPECT_EQ(stream, streams.front());  // not only similar: identical
  // Kolmogorov-Smirnov against the exponential law, intervals of all pixels (their rates differ by mismatch only).
  EmulatorConfig one = ideal();
  one.shot_noise_rate_hz = 50.0;
  const LabelledCounts out = in_still_light(one, {8, 8}, 120.0F, 5.0, 1000, 7);
  std::map<int, std::int64_t> last_us;
  std::vector<double> intervals_s;
  for (const Event& e : out.events) {
    const int pixel = e.y * 8 + e.x;
    if (last_us.contains(pixel)) intervals_s.push_back(static_cast<double>(e.t_us - last_us[pixel]) * 1e-6);
    last_us[pixel] = e.t_us;
  }
  std::sort(intervals_s.begin(), intervals_s.end());
  const double rate_hz = 50.0 * (1.0 - 0.75 * 140.0 / 275.0);
  const auto n = static_cast<double>(intervals_s.size());
  double distance = 0.0;
  for (std::size_t i = 0; i < intervals_s.size(); ++i) {
    const double law = 1.0 - std::exp(-rate_hz * intervals_s[i]);
    distance = std::max({distance, std::abs(law - static_cast<double>(i) / n),
                         std::abs(law - static_cast<double>(i + 1) / n)});
  }
  std::printf("intervals: Kolmogorov-Smirnov distance %.4f of %.0f, p = 0.01 at %.4f\n", distance, n,
              1.628 / std::sqrt(n));
  EXPECT_LT(distance, 1.628 / std::sqrt(n));
}

TEST(EmulatorStages, HotPixelsHaveTheirShareAndRate) {
  EmulatorConfig config = ideal();
  config.hot_pixel_share = 0.01;
  config.hot_pixel_rate_hz = 200.0;
  const LabelledCounts out = in_still_light(config, {100, 100}, 100.0F, 1.0, 1000);
  std::set<std::pair<int, int>> hot;
  for (const Event& e : out.events) hot.insert({e.x, e.y});
  std::printf("%zu of 10,000 pixels hot, %.0f Hz each\n", hot.size(),
              static_cast<double>(out.events.size()) / static_cast<double>(hot.size()));
  EXPECT_NEAR(static_cast<double>(hot.size()), 100.0, 40.0);  // 4 sigma
  EXPECT_NEAR(static_cast<double>(out.events.size()) / static_cast<double>(hot.size()), 200.0, 6.0);
  EXPECT_EQ(out.counts.by_cause[static_cast<int>(EventCause::hot)], out.counts.events());
  EXPECT_EQ(out.counts.off, 0);
}

/// Events per second of each pixel of 64 x 64 in 200 s.
std::vector<double> still_rates(const EmulatorConfig& config, float luminance, std::int64_t dt_us = 100'000) {
  const LabelledCounts out = in_still_light(config, {64, 64}, luminance, 200.0, dt_us);
  std::vector<double> rates(4096);
  for (const Event& e : out.events) rates[static_cast<std::size_t>(e.y * 64 + e.x)] += 1.0 / 200.0;
  return rates;
}

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

TEST(EmulatorStages, LightAddsToTheLeakInProportion) {
  EmulatorConfig config = ideal();
  config.leak_rate_hz = 0.05;
  config.leak_spread_decades = 0.0;
  config.leak_light_hz = 0.4;
  for (const float luminance : {1.0F, 51.0F, 255.0F}) {
    const double law_hz = 0.05 + 0.4 * static_cast<double>(luminance) / 255.0;
    EXPECT_NEAR(mean_of(still_rates(config, luminance)), law_hz, 0.01 * law_hz) << luminance;
  }
}

TEST(EmulatorStages, ChangingLightMovesTheLeakAndNothingElse) {
  // One pixel that never crosses by signal: +-2 % of light, 10 s each. Images may be close or far apart.
  EmulatorConfig config = ideal();
  config.leak_rate_hz = 0.0;
  config.leak_light_hz = 2.0;
  config.contrast_threshold_on = config.contrast_threshold_off = 0.3;
  config.interpolation = Interpolation::held;
  std::vector<std::size_t> counts;
  for (const std::int64_t dt_us : {10'000, 500'000}) {
    EventEmulator emulator(config, {32, 32}, 1);
    std::vector<Event> events;
    for (std::int64_t t_us = 0; t_us <= 100'000'000; t_us += dt_us) {
      const bool bright = (t_us / 10'000'000) % 2 != 0;
      const std::vector<float> image(1024, bright ? 150.0F : 147.0F);
      emulator.process_image(image, t_us, events);
    }
    emulator.finish(events);
    const double rate_hz = static_cast<double>(events.size()) / 1024.0 / 100.0;
    const double law_hz = 2.0 * 148.5 / 255.0;
    for (const Event& e : events) EXPECT_TRUE(e.on);
    EXPECT_NEAR(rate_hz, law_hz, 0.02 * law_hz);
    counts.push_back(events.size());
  }
  EXPECT_NEAR(static_cast<double>(counts[0]), static_cast<double>(counts[1]), 2.0);
}

TEST(EmulatorStages, LeakyPixelsAreRegularAndHaveTheirShareAndSpread) {
  EmulatorConfig config = ideal();
  config.leaky_pixel_share = 0.1;
  config.leaky_pixel_rate_hz = 3.0;
  config.leaky_pixel_spread_decades = 0.2;
  std::vector<double> logs;
  for (const double rate_hz : still_rates(config, 100.0F)) {
    if (rate_hz > 0.0) logs.push_back(std::log10(rate_hz));
  }
  const double mean = mean_of(logs);
  double square = 0.0;
  for (const double v : logs) square += (v - mean) * (v - mean) / static_cast<double>(logs.size());
  EXPECT_NEAR(static_cast<double>(logs.size()) / 4096.0, 0.1, 0.02);
  EXPECT_NEAR(mean, std::log10(3.0), 0.04);
  EXPECT_NEAR(std::sqrt(square), 0.2, 0.03);
}

TEST(EmulatorStages, ShotNoiseHasItsSpreadShareAndFallWithLight) {
  EmulatorConfig config = ideal();
  config.shot_noise_rate_hz = 10.0;
  config.shot_noise_light = 20.0;
  config.shot_noise_on_share = 0.7;
  const LabelledCounts out = in_still_light(config, {64, 64}, 30.0F, 50.0, 100'000);
  const double law_hz = 10.0 * std::exp(-1.5);
  EXPECT_NEAR(static_cast<double>(out.counts.events()) / 4096.0 / 50.0, law_hz, 0.02 * law_hz);
  EXPECT_NEAR(static_cast<double>(out.counts.on) / static_cast<double>(out.counts.events()), 0.7, 0.01);
  config.shot_noise_spread_decades = 0.25;
  std::vector<double> logs;
  for (const double rate_hz : still_rates(config, 0.0F)) logs.push_back(std::log10(rate_hz));
  const double mean = mean_of(logs);
  double square = 0.0;
  for (const double v : logs) square += (v - mean) * (v - mean) / static_cast<double>(logs.size());
  EXPECT_NEAR(mean, 1.0, 0.02);
  EXPECT_NEAR(std::sqrt(square), 0.25, 0.02);
}

/// The smallest rates that the configuration accepts are far below one event in the age of the universe.
TEST(EmulatorStages, RatesNearZeroMakeNoEvent) {
  for (const double rate_hz : {1e-9, 1e-15, 1e-25, 1e-40}) {
    EmulatorConfig config = ideal();
    config.shot_noise_rate_hz = rate_hz;
    config.hot_pixel_share = 1.0;
    config.hot_pixel_rate_hz = rate_hz;
    const LabelledCounts out = in_still_light(config, {8, 8}, 100.0F, 1.0, 10'000);
    EXPECT_EQ(out.counts.events(), 0) << rate_hz;
  }
}

TEST(EmulatorStages, APixelWithALeakRateNearZeroSeesItsSignal) {
  for (const double rate_hz : {1e-9, 1e-15, 1e-25}) {
    EmulatorConfig config = ideal();
    config.leak_rate_hz = rate_hz;
    EventEmulator emulator(config, {16, 16}, 1);
    std::vector<Event> events;
    emulator.process_image(std::vector<float>(256, 50.0F), 0, events);
    emulator.process_image(std::vector<float>(256, 100.0F), 1000, events);
    // ln 2 is 3.5 thresholds, and the random phase of the leakage adds up to one more.
    EXPECT_GE(events.size(), 3U * 256U) << rate_hz;
    EXPECT_LE(events.size(), 4U * 256U) << rate_hz;
  }
}

TEST(EmulatorStages, AReadoutRateNearZeroDelaysEventsBeyondEveryImage) {
  EmulatorConfig config = ideal();
  config.readout_rate_hz = 1e-15;
  EventEmulator emulator(config, {4, 4}, 1);
  std::vector<Event> events;
  emulator.process_image(std::vector<float>(16, 50.0F), 0, events);
  emulator.process_image(std::vector<float>(16, 100.0F), 1000, events);
  emulator.process_image(std::vector<float>(16, 100.0F), 1'000'000'000'000, events);
  EXPECT_EQ(events.size(), 0U);
  EXPECT_EQ(emulator.counts().waiting, 3 * 16);
}

TEST(EmulatorStages, LabelsNameTheCauseAndTheObject) {
  EmulatorConfig config = ideal();
  config.shot_noise_rate_hz = 30.0;
  EventEmulator emulator(config, {2, 1}, 1);
  std::vector<Event> events;
  std::vector<EventLabel> labels;
  for (int k = 0; k <= 2000; ++k) {
    const std::vector<float> image = {static_cast<float>(10.0 * std::exp(0.005 * k)), 50.0F};
    const std::vector<std::uint8_t> objects = {static_cast<std::uint8_t>(k % 2 == 0 ? 3 : 4), 9};
    emulator.process_image(image, k * 1000, events, &labels, objects);
  }
  ASSERT_EQ(labels.size(), events.size());
  int signal = 0;
  for (std::size_t i = 0; i < events.size(); ++i) {
    EXPECT_EQ(labels[i].object, events[i].x == 0 ? 3 : 9);  // the smaller of the two images'
    if (events[i].x == 1) {
      EXPECT_EQ(labels[i].cause, EventCause::shot);
    }
    signal += labels[i].cause == EventCause::signal ? 1 : 0;
  }
  // A shot event resets the pixel: the ramp of 10 ln makes fewer than 50 signal events.
  EXPECT_GT(signal, 15);
  EXPECT_LE(signal, 50);
}

TEST(EmulatorStages, TheBusServesOneEventAfterTheOther) {
  const ImageSize size{128, 128};
  const auto after_a_flash = [&](const EmulatorConfig& config) {
    EventEmulator emulator(config, size, 1);
    LabelledCounts out;
    emulator.process_image(std::vector<float>(16384, 50.0F), 0, out.events, &out.labels);
    emulator.process_image(std::vector<float>(16384, 50.0F * std::exp(0.25F)), 1, out.events, &out.labels);
    EXPECT_EQ(out.counts.waiting, 0);
    emulator.process_image(std::vector<float>(16384, 50.0F * std::exp(0.25F)), 5000, out.events, &out.labels);
    EXPECT_EQ(emulator.counts().events() + emulator.counts().waiting + emulator.counts().dropped, 16384);
    for (const Event& e : out.events) EXPECT_LE(e.t_us, 5000);
    emulator.finish(out.events, &out.labels);
    out.counts = emulator.counts();
    return out;
  };
  EmulatorConfig config = ideal();
  config.readout_rate_hz = 1e6;
  const LabelledCounts all = after_a_flash(config);
  ASSERT_EQ(all.events.size(), 16384U);
  std::printf("16,384 events at once at 1 Mevent/s: the last after %lld us, %lld lost\n",
              static_cast<long long>(all.events.back().t_us - 1), static_cast<long long>(all.counts.dropped));
  EXPECT_EQ(all.events.back().t_us, 1 + 16384);
  EXPECT_EQ(all.counts.dropped, 0);
  for (std::size_t i = 1; i < all.events.size(); ++i)
    EXPECT_EQ(all.events[i].t_us, all.events[i - 1].t_us + 1);

  config.readout_queue_events = 1000;
  const LabelledCounts some = after_a_flash(config);
  EXPECT_EQ(some.counts.events(), 1000);
  EXPECT_EQ(some.counts.events() + some.counts.dropped, 16384);
  EXPECT_EQ(some.labels.size(), some.events.size());

  config.readout_queue_events = 0;
  config.readout_rate_hz = 3e6;
  EXPECT_EQ(after_a_flash(config).events.back().t_us, 1 + 5462);  // 16384 / 3 = 5461.3 us
}

TEST(EmulatorStages, EventsOfAPixelLieATickApart) {
  for (const double readout_rate_hz : {0.0, 5e6}) {
    EmulatorConfig config = ideal();
    config.timestamp_resolution_us = 100;
    config.readout_rate_hz = readout_rate_hz;
    EventEmulator emulator(config, {8, 8}, 1);
    std::vector<Event> events;
    for (int k = 0; k <= 50; ++k) {
      std::vector<float> image(64);
      for (std::size_t i = 0; i < 64; ++i) {
        // Up to 20 thresholds per millisecond, twice the ticks, in turns of 5 ms.
        const double level = (k / 5 % 2 == 0 ? k % 5 : 5 - k % 5) * 0.06 * static_cast<double>(i);
        image[i] = static_cast<float>(20.0 * std::exp(level));
      }
      emulator.process_image(image, k * 1000, events);
    }
    emulator.finish(events);
    std::set<std::tuple<std::int64_t, int, int>> seen;
    for (std::size_t i = 0; i < events.size(); ++i) {
      EXPECT_EQ(events[i].t_us % 100, 0);
      EXPECT_TRUE(seen.insert({events[i].t_us, events[i].x, events[i].y}).second);
      if (i > 0) {
        EXPECT_GE(events[i].t_us, events[i - 1].t_us);
      }
    }
    EXPECT_GT(events.size(), 5000U);
  }
}

TEST(EmulatorStages, LinLogIsLinearInTheDark) {
  // One ON event per 0.2 of the response: x ln(20)/20 up to 20 grey levels, ln x above.
  EmulatorConfig config = ideal();
  config.response = LightResponse::lin_log;
  const auto count = [&](float from, float to) {
    EventEmulator emulator(config, {1, 1}, 1);
    std::vector<Event> events;
    emulator.process_image({&from, 1}, 0, events);
    emulator.process_image({&to, 1}, 1'000'000, events);
    return events.size();
  };
  EXPECT_EQ(count(0.0F, 20.0F), 14U);    // ln 20 = 2.996
  EXPECT_EQ(count(0.0F, 10.0F), 7U);     // half of it: 1.498
  EXPECT_EQ(count(20.0F, 250.0F), 12U);  // ln 12.5 = 2.526
  config.white = 1.0;
  EXPECT_EQ(count(0.0F, 20.0F / 255.0F), 14U);
}

TEST(EmulatorStages, EveryPresetRunsAndNamesItself) {
  for (const std::string& name : emulator_presets()) {
    const EmulatorConfig config = emulator_preset(name);
    EXPECT_EQ(config.preset, name);
    const LabelledCounts out = in_still_light(config, {32, 32}, 80.0F, 1.0, 1000);
    std::printf("%s: %.2f events per pixel and second in still light\n", name.c_str(),
                static_cast<double>(out.events.size()) / 1024.0);
    EXPECT_EQ(out.events.empty(), name == "ideal");
  }
  EXPECT_THROW(static_cast<void>(emulator_preset("perfect")), InputError);
}

}  // namespace
}  // namespace saccade
