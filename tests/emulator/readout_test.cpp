// The bus alone: which requests it transmits, in which order, and when.
#include "emulator/readout.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>

#include "emulator/event_emulator.h"

namespace saccade {
namespace {

constexpr std::uint32_t width = 64;
constexpr std::uint32_t pixels = width * width;

/// `per_us` requests of different pixels in each of `duration_us` microseconds, uniform over the image, in the order of time
/// and pixel; both polarities alike.
std::vector<PixelEvent> uniform_requests(double per_us, std::int64_t duration_us, std::uint64_t seed) {
  const RandomStream random(seed, "requests");
  std::vector<PixelEvent> requests;
  double owed = 0.0;
  std::uint64_t drawn = 0;
  for (std::int64_t t_us = 1; t_us <= duration_us; ++t_us) {
    owed += per_us;
    std::set<std::uint32_t> chosen;
    for (; owed >= 1.0; owed -= 1.0) {
      while (!chosen.insert(static_cast<std::uint32_t>(random.bits(1, drawn++) % pixels)).second) {
      }
    }
    for (const std::uint32_t pixel : chosen)
      requests.push_back({t_us, pixel, random.bits(2, drawn++) % 2 == 0, 0, 0});
  }
  return requests;
}

std::vector<PixelEvent> transmitted(const EmulatorConfig& config, std::span<const PixelEvent> requests) {
  Readout readout(config, pixels, 1);
  std::vector<PixelEvent> events;
  readout.process(requests, requests.back().t_us, events);
  readout.finish(events);
  EXPECT_EQ(static_cast<std::int64_t>(events.size()) + readout.dropped(),
            static_cast<std::int64_t>(requests.size()));
  return events;
}

/// Expects that the share of the requests that are transmitted is the same in every group of pixels within 5 standard
/// deviations of a binomial distribution.
template <class Group>
void expect_equal_shares(const std::string& what, std::span<const PixelEvent> requests,
                         std::span<const PixelEvent> events, Group group_of) {
  std::array<double, width> asked = {};
  std::array<double, width> kept = {};
  for (const PixelEvent& e : requests) ++asked[group_of(e)];
  for (const PixelEvent& e : events) ++kept[group_of(e)];
  const double share = static_cast<double>(events.size()) / static_cast<double>(requests.size());
  for (std::size_t k = 0; k < asked.size(); ++k) {
    if (asked[k] == 0.0) continue;
    const double deviation = std::sqrt(share * (1.0 - share) / asked[k]);
    EXPECT_NEAR(kept[k] / asked[k], share, 5.0 * deviation) << what << " " << k;
  }
}

TEST(Readout, AnOverloadedBusPrefersNoRowColumnQuarterOrPolarity) {
  for (const std::string& preset : emulator_presets()) {
    EmulatorConfig config = emulator_preset(preset);
    if (config.readout_rate_hz == 0.0) continue;
    // 64 x 64 pixels make at most 4096 requests in a microsecond: buses that transmit more are slowed down.
    config.readout_rate_hz = std::min(config.readout_rate_hz, 66e6);
    const double rate_per_us = config.readout_rate_hz * 1e-6;
    for (const double load : {1.5, 2.0, 10.0, 30.0}) {
      const auto duration_us = static_cast<std::int64_t>(80'000 / rate_per_us);
      const std::vector<PixelEvent> requests = uniform_requests(load * rate_per_us, duration_us, 7);
      const std::vector<PixelEvent> events = transmitted(config, requests);
      ASSERT_LT(events.size(), requests.size());
      const std::string what = preset + " at " + std::to_string(load) + " times the bus's rate: ";
      expect_equal_shares(what + "row", requests, events,
                          [](const PixelEvent& e) { return e.pixel / width; });
      expect_equal_shares(what + "column", requests, events,
                          [](const PixelEvent& e) { return e.pixel % width; });
      expect_equal_shares(what + "quarter", requests, events, [](const PixelEvent& e) {
        return e.pixel / (pixels / 2) * 2 + e.pixel % width / (width / 2);
      });
      expect_equal_shares(what + "polarity", requests, events,
                          [](const PixelEvent& e) { return e.on ? 1U : 0U; });
    }
  }
}

TEST(Readout, RequestsThatDoNotWaitKeepTheirOrder) {
  EmulatorConfig config = emulator_preset("davis346");  // 12 requests in a microsecond, 3 us of latency
  const std::vector<PixelEvent> requests = uniform_requests(9.0, 2000, 3);
  const std::vector<PixelEvent> events = transmitted(config, requests);
  ASSERT_EQ(events.size(), requests.size());
  for (std::size_t i = 0; i < events.size(); ++i) {
    EXPECT_EQ(events[i].pixel, requests[i].pixel);
    EXPECT_EQ(events[i].t_us, requests[i].t_us + config.latency_us + 1);
  }
}

TEST(Readout, TheOrderDependsOnSeedAndTimeAloneNotOnHowCallsAreCut) {
  EmulatorConfig config = emulator_preset("dvs128");
  const std::vector<PixelEvent> requests = uniform_requests(8.0, 5000, 5);
  const std::vector<PixelEvent> whole = transmitted(config, requests);
  Readout readout(config, pixels, 1);
  std::vector<PixelEvent> parts;
  for (std::size_t first = 0, end = 0; first < requests.size(); first = end) {
    const std::int64_t until_us = requests[first].t_us + requests[first].t_us % 7;
    while (end < requests.size() && requests[end].t_us <= until_us) ++end;
    readout.process(std::span(requests).subspan(first, end - first), until_us, parts);
  }
  readout.finish(parts);
  ASSERT_EQ(parts.size(), whole.size());
  for (std::size_t i = 0; i < whole.size(); ++i) {
    EXPECT_EQ(parts[i].pixel, whole[i].pixel);
    EXPECT_EQ(parts[i].t_us, whole[i].t_us);
  }

  Readout other(config, pixels, 2);
  std::vector<PixelEvent> otherwise;
  other.process(requests, requests.back().t_us, otherwise);
  other.finish(otherwise);
  ASSERT_EQ(otherwise.size(), whole.size());
  EXPECT_FALSE(std::equal(whole.begin(), whole.end(), otherwise.begin(),
                          [](const PixelEvent& a, const PixelEvent& b) { return a.pixel == b.pixel; }));
}

/// A random texture that moves down and right by half a pixel per millisecond.
std::vector<float> moving_texture(ImageSize size, std::int64_t t_us) {
  static const RandomStream random(11, "texture");
  const double shift = 0.0005 * static_cast<double>(t_us);
  const auto whole = static_cast<std::uint64_t>(shift);
  const double part = shift - static_cast<double>(whole);
  std::vector<float> image;
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const auto tone = [&](std::uint64_t step) {
        const auto column = static_cast<std::uint64_t>(x) + 100'000 - step;
        const auto row = static_cast<std::uint64_t>(y) + 100'000 - step;
        return 20.0 + 200.0 * random.uniform(column, row);
      };
      image.push_back(static_cast<float>((1.0 - part) * tone(whole) + part * tone(whole + 1)));
    }
  }
  return image;
}

TEST(Readout, UpperAndLowerHalfOfAnOverloadedCameraKeepTheSameShare) {
  const ImageSize size{96, 96};
  for (const bool regular : {true, false}) {
    std::array<std::array<double, 2>, 2> counts = {};  // by bus and half
    for (const bool limited : {false, true}) {
      EmulatorConfig config = emulator_preset("dvs128");
      config.readout_rate_hz = limited ? 250e3 : 0.0;
      EventEmulator camera(config, size, 1);
      std::vector<Event> events;
      for (std::int64_t t_us = 0, k = 0; t_us < 200'000; ++k) {
        camera.process_image(moving_texture(size, t_us), t_us, events);
        t_us += regular ? 1000 : std::array{150, 400, 2350, 1100}[static_cast<std::size_t>(k % 4)];
      }
      for (const Event& e : events) ++counts[limited ? 1 : 0][e.y < size.height / 2 ? 0 : 1];
    }
    const double upper = counts[1][0] / counts[0][0];
    const double lower = counts[1][1] / counts[0][1];
    EXPECT_LT(upper + lower, 0.8) << "the bus is not overloaded";
    // A pixel's requests do not depend on the bus: the halves differ by chance alone, about 0.3 points here.
    EXPECT_NEAR(upper, lower, 0.02);
  }
}

}  // namespace
}  // namespace saccade
