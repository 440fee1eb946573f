#include "emulator/event_emulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <set>
#include <tuple>

#include "core/random.h"

namespace saccade {
namespace {

using testing::HasSubstr;

constexpr double dark = 1.0;  ///< dark current of the tests

EmulatorConfig config_of(double mismatch, std::int64_t refractory_us) {
  EmulatorConfig config = emulator_preset("ideal");
  config.threshold_mismatch = mismatch;
  config.refractory_us = refractory_us;
  config.dark_current = dark;
  return config;
}

/// The luminance whose log with dark current is `log_level` above that of a dark pixel's, 0.
float luminance_of(double log_level) { return static_cast<float>(std::exp(log_level + 0.5) - dark); }

/// Log luminance of a pixel over time, which the emulator receives sampled.
using Course = std::function<double(std::size_t pixel, double t_s)>;

std::vector<Event> emulate(EventEmulator& emulator, std::size_t pixels, const Course& course,
                           double duration_s, double images_per_s, std::int64_t t0_us = 0) {
  std::vector<Event> events;
  std::vector<float> image(pixels);
  const auto images = static_cast<int>(std::lround(duration_s * images_per_s));
  for (int k = 0; k <= images; ++k) {
    const std::int64_t t_us = std::llround(k * 1e6 / images_per_s);
    for (std::size_t i = 0; i < pixels; ++i)
      image[i] = luminance_of(course(i, static_cast<double>(t_us) * 1e-6));
    emulator.process_image(image, t0_us + t_us, events);
  }
  return events;
}

std::vector<Event> emulate_patch(const EmulatorConfig& config, ImageSize size, const Course& course,
                                 double duration_s, double images_per_s, std::uint64_t seed = 1) {
  EventEmulator emulator(config, size, seed);
  return emulate(emulator, static_cast<std::size_t>(size.pixels()), course, duration_s, images_per_s);
}

std::vector<std::array<int, 2>> counts_per_pixel(const std::vector<Event>& events, ImageSize size) {
  std::vector<std::array<int, 2>> counts(static_cast<std::size_t>(size.pixels()));
  for (const Event& e : events) ++counts[static_cast<std::size_t>(e.y * size.width + e.x)][e.on ? 1 : 0];
  return counts;
}

/// A texture of three scales, interpolated between seeded corners with basic arithmetic only, so that it is
/// the same everywhere. Linear light, 0..255.
float texture_at(double x, double y) {
  const RandomStream random(77, "texture");
  double value = 0.0;
  for (const int cell : {3, 8, 21}) {
    const double u = x / cell;
    const double v = y / cell;
    const double fu = u - std::floor(u);
    const double fv = v - std::floor(v);
    const auto corner = [&](int i, int k) {
      return random.uniform(
          static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(u)) + i + 5000) * 64 +
              static_cast<std::uint64_t>(cell),
          static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(v)) + k + 5000));
    };
    value += (1 - fv) * ((1 - fu) * corner(0, 0) + fu * corner(1, 0)) +
             fv * ((1 - fu) * corner(0, 1) + fu * corner(1, 1));
  }
  return static_cast<float>(85.0 * value);
}

/// The image of a head that sweeps over the texture, at t_s from 0 to 0.2 s.
void render_sweep(ImageSize size, double t_s, std::vector<float>& image) {
  // Position by a polynomial: smooth, back and forth, up to 400 px/s.
  const double s = t_s * 10.0;
  const double x = 40.0 * s * (1.0 - s) * (1.0 + s);
  const double y = 15.0 * s * s;
  image.resize(static_cast<std::size_t>(size.pixels()));
  std::size_t i = 0;
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column, ++i) image[i] = texture_at(column + x, row + y);
  }
}

constexpr std::array<double, 4> rates = {50, 200, 1000, 5000};

TEST(EventEmulator, CountsTheExactNumberOfCrossings) {
  const ImageSize size{4, 4};
  for (const double rate : rates) {
    const auto rise = emulate_patch(
        config_of(0, 0), size, [](std::size_t, double t) { return 2.05 * t; }, 1, rate);
    const auto fall = emulate_patch(
        config_of(0, 0), size, [](std::size_t, double t) { return 2.05 - 2.05 * t; }, 1, rate);
    for (const auto& [off, on] : counts_per_pixel(rise, size)) {
      EXPECT_EQ(on, 10) << rate;
      EXPECT_EQ(off, 0) << rate;
    }
    for (const auto& [off, on] : counts_per_pixel(fall, size)) {
      EXPECT_EQ(on, 0) << rate;
      EXPECT_EQ(off, 10) << rate;
    }
  }
  std::printf("+2.05 ln: 10 ON, 0 OFF; -2.05 ln: 10 OFF, 0 ON, at 50, 200, 1000 and 5000 images/s\n");
}

TEST(EventEmulator, StampsTheCrossingTimeToATick) {
  double worst_us = 0.0;
  for (const double rate : rates) {
    const auto events = emulate_patch(
        config_of(0, 0), {1, 1}, [](std::size_t, double t) { return 2.05 * t; }, 1, rate);
    ASSERT_EQ(events.size(), 10U);
    for (std::size_t k = 0; k < events.size(); ++k) {
      const double crossing_us = 1e6 * 0.2 / 2.05 * static_cast<double>(k + 1);
      worst_us = std::max(worst_us, std::abs(static_cast<double>(events[k].t_us) - crossing_us));
    }
  }
  std::printf("worst crossing time error: %.2f us\n", worst_us);
  EXPECT_LE(worst_us, 1.0);
}

/// A triangle wave per pixel with random slope and phase.
Course random_triangles(std::uint64_t seed) {
  return [random = RandomStream(seed, "triangles")](std::size_t i, double t) {
    // Turns at multiples of 20 ms, where all rates have an image; +-(2..30) ln/s.
    const double slope = random.uniform(2.0, 30.0, i, 0) * (random.uniform(i, 1) < 0.5 ? -1.0 : 1.0);
    const double phase = std::floor(random.uniform(i, 2) * 10) * 0.02;
    const double s = std::fmod(t + phase + 1e-12, 0.4);
    return 7.0 + slope * std::min(s, 0.4 - s);
  };
}

TEST(EventEmulator, DoesNotDependOnTheImageRateAndAlwaysEnds) {
  const ImageSize size{32, 32};
  const Course course = random_triangles(4);
  std::vector<std::array<int, 2>> counts_at_first;
  std::size_t total = 0;
  for (const double rate : rates) {
    EventEmulator emulator(config_of(0.03, 0), size, 6);
    std::vector<Event> events;
    std::vector<float> image(1024);
    double worst = 0.0;  // |L - reference| / threshold
    for (int k = 0; k <= static_cast<int>(rate); ++k) {
      const std::int64_t t_us = std::llround(k * 1e6 / rate);
      for (std::size_t i = 0; i < image.size(); ++i)
        image[i] = luminance_of(course(i, static_cast<double>(t_us) * 1e-6));
      emulator.process_image(image, t_us, events);
      for (std::size_t i = 0; i < image.size(); ++i) {
        worst = std::max(worst, std::abs(emulator.output_log(i) - emulator.reference_log(i)));
      }
    }
    EXPECT_LT(worst, 0.2 * (1 + 5 * 0.03)) << rate;  // no pixel's threshold is 5 sigma high
    const auto counts = counts_per_pixel(events, size);
    if (counts_at_first.empty()) {
      counts_at_first = counts;
      total = events.size();
    }
    EXPECT_EQ(counts, counts_at_first) << rate;
  }
  EXPECT_GT(total, 40'000U);
  std::printf("%zu events, the same count at every pixel at 50, 200, 1000 and 5000 images/s\n", total);
}

TEST(EventEmulator, HasTheDistributionOfMismatchedThresholds) {
  struct Law {
    double mismatch, mean, deviation;
  };
  const ImageSize size{400, 250};
  const double n = size.pixels();
  for (const Law law : {Law{0.021, 9.884, 0.322}, Law{0.03, 9.810, 0.421}, Law{0.15, 9.999, 1.727}}) {
    for (const bool rising : {true, false}) {
      const auto events = emulate_patch(
          config_of(law.mismatch, 0), size,
          [&](std::size_t, double t) { return 2.05 * (rising ? t : 1 - t); }, 1, 1);
      double sum = 0.0;
      for (const auto& c : counts_per_pixel(events, size)) sum += c[rising ? 1 : 0];
      const double mean = sum / n;
      double second = 0.0;
      double fourth = 0.0;
      for (const auto& c : counts_per_pixel(events, size)) {
        const double d = c[rising ? 1 : 0] - mean;
        second += d * d / n;
        fourth += d * d * d * d / n;
      }
      const double deviation = std::sqrt(second);
      const double error_of_mean = deviation / std::sqrt(n);
      const double error_of_deviation = std::sqrt((fourth / second - second) / n) / 2.0;
      std::printf("%s, mismatch %.1f %%: mean %.3f (law %.3f), sd %.3f (law %.3f)\n", rising ? "ON" : "OFF",
                  100 * law.mismatch, mean, law.mean, deviation, law.deviation);
      // 4 standard errors, and the law itself is given to three digits.
      EXPECT_NEAR(mean, law.mean, 4 * error_of_mean + 0.0005);
      EXPECT_NEAR(deviation, law.deviation, 4 * error_of_deviation + 0.0005);
    }
  }
}

TEST(EventEmulator, KeepsItsHysteresisWithoutDrift) {
  // A triangle of 2.05 peak to peak that starts 0.1 above its bottom: 9 + 9 per cycle once it is steady.
  const Course triangle = [](std::size_t, double t) {
    const double s = std::fmod(t + 0.5 * 0.1 / 2.05, 1.0);
    return 2.05 * (s < 0.5 ? 2 * s : 2 - 2 * s);
  };
  for (const double rate : {200.0, 1000.0}) {
    const auto events = emulate_patch(config_of(0, 0), {1, 1}, triangle, 20, rate);
    for (int cycle = 2; cycle < 19; ++cycle) {
      const auto in_cycle = [&](bool on) {
        return std::count_if(events.begin(), events.end(), [&](const Event& e) {
          return e.on == on && e.t_us > cycle * 1'000'000 && e.t_us <= (cycle + 1) * 1'000'000;
        });
      };
      ASSERT_EQ(in_cycle(true), 9) << "cycle " << cycle;
      ASSERT_EQ(in_cycle(false), 9) << "cycle " << cycle;
    }
  }
  std::printf("9 ON + 9 OFF in every steady cycle\n");
}

TEST(EventEmulator, ItsEventsReconstructTheImage) {
  // |L - L_rec| < C at every pixel and image of a sweep over a texture; L_rec from the events alone.
  const ImageSize size{64, 48};
  const EmulatorConfig config = config_of(0, 0);
  EventEmulator emulator(config, size, 1);
  std::vector<float> image;
  std::vector<Event> events;
  std::vector<double> rebuilt;
  std::size_t used = 0;
  double worst = 0.0;
  for (int k = 0; k <= 200; ++k) {
    render_sweep(size, k * 1e-3, image);
    emulator.process_image(image, k * 1000, events);
    if (k == 0) {
      for (const float l : image) rebuilt.push_back(std::log(static_cast<double>(l) + dark));
    }
    for (; used < events.size(); ++used) {
      const Event& e = events[used];
      rebuilt[static_cast<std::size_t>(e.y * size.width + e.x)] += e.on ? 0.2 : -0.2;
    }
    for (std::size_t i = 0; i < image.size(); ++i) {
      worst = std::max(worst, std::abs(std::log(static_cast<double>(image[i]) + dark) - rebuilt[i]));
    }
  }
  std::printf("worst |L - L_rec| = %.6f of C = 0.2 over 200 images, %zu events\n", worst, events.size());
  EXPECT_LT(worst, 0.2 + 1e-9);  // a pixel may be within rounding of its threshold
  EXPECT_GT(worst, 0.19);        // the bound is tight: no event is early
  EXPECT_GT(events.size(), 50'000U);
}

TEST(EventEmulator, HoldsPixelsInResetForTheRefractoryPeriod) {
  // Interval = refractory period + threshold / slope, each rounded up to a microsecond.
  const double slope = 100.0;  // 2 ms per threshold
  for (const std::int64_t refractory_us : {1, 300, 500, 7000}) {
    for (const double rate : {200.0, 1000.0, 5000.0}) {
      const auto events = emulate_patch(
          config_of(0, refractory_us), {1, 1}, [&](std::size_t, double t) { return slope * t; }, 0.06, rate);
      ASSERT_GT(events.size(), 5U);
      for (std::size_t i = 1; i < events.size(); ++i) {
        const double interval_us = static_cast<double>(events[i].t_us - events[i - 1].t_us);
        EXPECT_NEAR(interval_us, static_cast<double>(refractory_us) + 0.2 / slope * 1e6, 1.0);
      }
    }
  }
  // Never shorter than the period and the steepest way (30 ln/s) to a threshold 5 sigma low, for any input.
  const ImageSize size{32, 32};
  EventEmulator emulator(config_of(0.03, 20'000), size, 2);
  const auto events = emulate(emulator, 1024, random_triangles(9), 1, 1000);
  std::vector<std::int64_t> last(1024, -1'000'000);
  std::int64_t shortest = 1'000'000;
  for (const Event& e : events) {
    std::int64_t& before = last[static_cast<std::size_t>(e.y * size.width + e.x)];
    shortest = std::min(shortest, e.t_us - before);
    before = e.t_us;
  }
  std::printf("shortest interval with 20000 us: %lld us over %zu events\n", static_cast<long long>(shortest),
              events.size());
  EXPECT_GE(shortest, 20'000 + static_cast<std::int64_t>(0.2 * (1 - 5 * 0.03) / 30 * 1e6));
  EXPECT_LT(shortest, 27'000);
}

TEST(EventEmulator, DoesNotDependOnTheImageRateWithARefractoryPeriod) {
  const ImageSize size{16, 16};
  std::vector<std::vector<std::array<int, 2>>> counts;
  for (const double rate : rates) {
    EventEmulator emulator(config_of(0.03, 450), size, 6);
    counts.push_back(counts_per_pixel(emulate(emulator, 256, random_triangles(4), 1, rate), size));
    EXPECT_EQ(counts.back(), counts.front()) << rate;
  }
}

TEST(EventEmulator, SortsEventsAndNeverRepeatsAPixelWithinAMicrosecond) {
  const ImageSize size{64, 48};
  // For any interval between images, 1 us to 200 ms.
  EventEmulator emulator(config_of(0.1, 0), size, 3);
  const RandomStream random(8, "intervals");
  std::vector<float> image;
  std::vector<Event> events;
  std::int64_t t_us = -5'000'000;
  for (std::uint64_t k = 0; k < 120; ++k) {
    const std::int64_t before = t_us;
    t_us += std::array<std::int64_t, 4>{1, 37, 5'000, 200'000}[k % 4];
    const std::size_t old = events.size();
    render_sweep(size, random.uniform(0, k) * 0.2, image);
    emulator.process_image(image, t_us, events);
    for (std::size_t i = old; i < events.size(); ++i) {
      ASSERT_GT(events[i].t_us, before);
      ASSERT_LE(events[i].t_us, t_us);
    }
  }
  const auto key = [](const Event& e) { return std::tuple(e.t_us, e.y, e.x); };
  for (std::size_t i = 1; i < events.size(); ++i) ASSERT_LT(key(events[i - 1]), key(events[i]));
  EXPECT_GT(events.size(), 100'000U);
  EXPECT_EQ(emulator.counts().events(), static_cast<std::int64_t>(events.size()));
}

TEST(EventEmulator, KeepsEveryCrossingOfAMicrosecond) {
  // Five thresholds within 1 us: one event per microsecond, the rest with the images that follow.
  EventEmulator emulator(config_of(0, 0), {1, 1}, 1);
  std::vector<Event> events;
  const auto show = [&](double level, std::int64_t t_us) {
    const float luminance = luminance_of(level);
    emulator.process_image({&luminance, 1}, t_us, events);
  };
  show(0.0, 0);
  show(1.01, 1);
  EXPECT_EQ(events.size(), 1U);
  show(1.01, 2);
  show(1.01, 100);
  ASSERT_EQ(events.size(), 5U);
  for (std::size_t i = 0; i < 5; ++i) EXPECT_EQ(events[i].t_us, static_cast<std::int64_t>(i + 1));
}

/// A preset without noise and leakage.
EmulatorConfig without_noise(const std::string& preset) {
  EmulatorConfig config = emulator_preset(preset);
  config.leak_rate_hz = config.shot_noise_rate_hz = config.hot_pixel_share = 0.0;
  return config;
}

TEST(EventEmulator, MakesNoEventInAStaticSceneWithoutNoise) {
  const ImageSize size{64, 48};
  std::vector<float> image;
  render_sweep(size, 0.05, image);
  for (const std::string& preset : emulator_presets()) {
    EventEmulator emulator(without_noise(preset), size, 1);
    std::vector<Event> events;
    for (int k = 0; k < 1000; ++k) emulator.process_image(image, k * 1000, events);
    emulator.finish(events);
    EXPECT_TRUE(events.empty()) << preset;
    EXPECT_EQ(emulator.counts().events(), 0) << preset;
  }
}

TEST(EventEmulator, MakesNoEventOfOneGreyLevel) {
  // With a sensor's dark current, not even between black and the first of 255 grey levels.
  for (const std::string& preset : emulator_presets()) {
    if (preset == "ideal") continue;
    EventEmulator emulator(without_noise(preset), {16, 16}, 1);
    std::vector<Event> events;
    for (int k = 0; k < 20; ++k) {
      emulator.process_image(std::vector<float>(256, static_cast<float>(k % 2)), k * 1000, events);
    }
    emulator.finish(events);
    EXPECT_TRUE(events.empty()) << preset;
  }
}

struct Labelled {
  std::vector<Event> events;
  std::vector<EventLabel> labels;

  friend bool operator==(const Labelled&, const Labelled&) = default;
};

Labelled sweep_of(const EmulatorConfig& config, std::uint64_t seed, std::int64_t t0_us = 0, int threads = 1) {
  const ImageSize size{64, 48};
  EventEmulator emulator(config, size, seed, threads);
  std::vector<float> image;
  Labelled sweep;
  for (int k = 0; k <= 100; ++k) {
    render_sweep(size, k * 2e-3, image);
    emulator.process_image(image, t0_us + k * 2000, sweep.events, &sweep.labels);
  }
  emulator.finish(sweep.events, &sweep.labels);
  return sweep;
}

/// All stages switched on.
EmulatorConfig everything() {
  EmulatorConfig config = emulator_preset("dvs128");
  config.cutoff_hz = 400.0;
  config.leak_rate_hz = 5.0;
  config.shot_noise_rate_hz = 20.0;
  config.hot_pixel_share = 0.01;
  config.readout_rate_hz = 400e3;
  config.readout_queue_events = 2000;
  return config;
}

TEST(EventEmulator, MakesTheSameEventsForTheSameSeedAndAnyNumberOfThreads) {
  const Labelled sweep = sweep_of(everything(), 5);
  EXPECT_NE(sweep_of(everything(), 6).events, sweep.events);
  for (const int threads : {1, 2, 3, 7}) EXPECT_EQ(sweep_of(everything(), 5, 0, threads), sweep) << threads;
  EXPECT_EQ(sweep.labels.size(), sweep.events.size());
}

TEST(EventEmulator, KeepsItsTimesFarFromZero) {
  for (const EmulatorConfig& config : {emulator_preset("dvs128"), everything()}) {
    const Labelled at_zero = sweep_of(config, 5);
    const std::int64_t t0_us = 1'000'000'000'000;  // 1e6 s
    Labelled later = sweep_of(config, 5, t0_us);
    for (Event& e : later.events) e.t_us -= t0_us;
    EXPECT_EQ(later, at_zero);
    std::printf("t0 = 0 and 1e6 s: %zu events, all apart by exactly t0\n", later.events.size());
  }
}

TEST(EventEmulator, RejectsInvalidImagesAndIsNotChangedByThem) {
  const ImageSize size{8, 6};
  EventEmulator clean(config_of(0.02, 300), size, 1);
  EventEmulator soiled(config_of(0.02, 300), size, 1);
  std::vector<Event> clean_events;
  std::vector<Event> soiled_events;
  std::vector<float> image;
  const auto complaint = [&](const std::vector<float>& bad, std::int64_t t_us) -> std::string {
    try {
      soiled.process_image(bad, t_us, soiled_events);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  for (int k = 0; k < 60; ++k) {
    render_sweep(size, k * 3e-3, image);
    std::vector<float> bad = image;
    bad[19] = -0.5F;
    EXPECT_EQ(complaint(bad, k * 1000),
              "image at " + std::to_string(k * 1000) +
                  " us, pixel (3, 2): found -0.5, expected a finite luminance of at least 0");
    bad[19] = std::numeric_limits<float>::quiet_NaN();
    EXPECT_THAT(complaint(bad, k * 1000), HasSubstr("pixel (3, 2): found nan"));
    bad[19] = std::numeric_limits<float>::infinity();
    EXPECT_THAT(complaint(bad, k * 1000), HasSubstr("found inf"));
    if (k > 0) {
      EXPECT_THAT(complaint(image, k * 1000 - 1000), HasSubstr("expected a time after"));
      EXPECT_THAT(complaint(image, k * 1000 - 5000), HasSubstr("time that does not advance"));
    }
    clean.process_image(image, k * 1000, clean_events);
    soiled.process_image(image, k * 1000, soiled_events);
  }
  EXPECT_EQ(soiled_events, clean_events);
  EXPECT_FALSE(clean_events.empty());
}

TEST(EventEmulator, RejectsTimesWhoseDifferencesOverflow) {
  constexpr std::int64_t longest_us = std::int64_t{1} << 60;
  EventEmulator emulator(config_of(0.02, 300), {1, 1}, 1);
  std::vector<Event> events;
  const std::vector<float> dim = {50.0F};
  const std::vector<float> bright = {100.0F};
  EXPECT_THROW(emulator.process_image(dim, std::numeric_limits<std::int64_t>::min(), events), InputError);
  emulator.process_image(dim, -longest_us, events);
  EXPECT_THROW(emulator.process_image(bright, std::numeric_limits<std::int64_t>::max(), events), InputError);
  emulator.process_image(bright, longest_us, events);
  EXPECT_FALSE(events.empty());
  for (const Event& event : events) EXPECT_LE(event.t_us, longest_us);
}

TEST(EventEmulator, ComputesTheLogarithmOfEveryLuminance) {
  // Against std::log, over the whole range of a float image.
  const ImageSize size{1000, 1};
  EventEmulator emulator(config_of(0, 0), size, 1);
  std::vector<float> image;
  const RandomStream random(1, "luminance");
  for (std::uint64_t i = 0; i < 1000; ++i) {
    image.push_back(static_cast<float>(std::exp(random.uniform(-20.0, 80.0, 0, i))));
  }
  image[0] = 0.0F;
  image[1] = std::numeric_limits<float>::max();
  image[2] = std::numeric_limits<float>::denorm_min();
  std::vector<Event> events;
  emulator.process_image(image, 0, events);
  double worst = 0.0;
  for (std::size_t i = 0; i < image.size(); ++i) {
    const double expected = std::log(static_cast<double>(image[i]) + dark);
    worst = std::max(worst, std::abs(emulator.output_log(i) - expected) / std::max(1.0, std::abs(expected)));
  }
  std::printf("worst error of the logarithm: %.1e\n", worst);
  EXPECT_LT(worst, 6e-8);  // the rounding of a float
}

TEST(EventEmulator, ReportsTheKeysOfAnInvalidConfiguration) {
  EmulatorConfig config;
  config.contrast_threshold_on = 0.0;
  config.threshold_mismatch = std::nan("");
  config.refractory_us = -1;
  config.dark_current = -1.0;
  try {
    EventEmulator emulator(config, {8, 8}, 1);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(error.problems().size(), 4U);
    EXPECT_THAT(error.what(),
                HasSubstr("emulator.contrast_threshold_on: found 0, expected a finite number in [0.01, 5]"));
    EXPECT_THAT(error.what(), HasSubstr("emulator.threshold_mismatch: found nan"));
    EXPECT_THAT(error.what(), HasSubstr("emulator.refractory_us: found -1"));
    EXPECT_THAT(error.what(), HasSubstr("emulator.dark_current: found -1"));
  }
  config = {};
  config.preset = "perfect";
  EXPECT_THROW(EventEmulator(config, {8, 8}, 1), InputError);
  EXPECT_THROW(static_cast<void>(emulator_preset("perfect")), InputError);
}

}  // namespace
}  // namespace saccade
