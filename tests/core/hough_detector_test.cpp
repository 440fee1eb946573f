#include "core/hough/hough_detector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/core/reference_hough.h"
#include "tests/core/streams.h"

namespace saccade {
namespace {

using testing::HasSubstr;

bool operator==(const Circle& a, const Circle& b) {
  return a.x_px == b.x_px && a.y_px == b.y_px && a.r_px == b.r_px;
}

void expect_same(const Estimate& a, const Estimate& b) {
  ASSERT_EQ(a.valid, b.valid);
  ASSERT_EQ(a.held, b.held);
  ASSERT_TRUE(a.circle == b.circle) << a.circle.x_px << " " << a.circle.y_px << " " << a.circle.r_px
                                    << " against " << b.circle.x_px << " " << b.circle.y_px << " "
                                    << b.circle.r_px;
  ASSERT_EQ(a.score, b.score);
}

HoughDetectorConfig config_of(bool directed, double r_min, double r_max, std::int64_t window) {
  HoughDetectorConfig config;
  config.directed = directed;
  config.radius_px = {r_min, r_max};
  config.window.events = window;
  config.flow.min_inliers = 3;  // random streams have few planes
  return config;
}

/// The detector as the paper words it: flow at each event when it comes, and the plain transform.
class PlainDetector {
 public:
  PlainDetector(const HoughDetectorConfig& config, ImageSize size)
      : config_(config),
        flow_(config.flow, size),
        hough_(size, static_cast<int>(config.radius_px[0]), static_cast<int>(config.radius_px[1]),
               static_cast<std::size_t>(config.window.events),
               config.directed ? std::optional(config.arc_deg * std::numbers::pi / 180.0) : std::nullopt) {}

  void push(const Event& e) {
    flow_.add(e);
    std::optional<double> direction_rad;
    if (const auto flow = flow_.at(e)) {
      direction_rad = HoughTransform::direction_of(flow->dt_dx_us_px, flow->dt_dy_us_px) * std::numbers::pi /
                      HoughTransform::direction_count;
      ++with_flow;
    }
    hough_.push(e.x, e.y, direction_rad);
  }
  [[nodiscard]] Estimate estimate() const {
    const ReferenceHough::Peak peak = hough_.peak();
    if (peak.votes == 0) return {};
    return {true,
            false,
            {static_cast<double>(peak.x), static_cast<double>(peak.y), static_cast<double>(peak.r)},
            static_cast<double>(peak.votes) / hough_.ring_pixels(peak.r)};
  }
  [[nodiscard]] const ReferenceHough& hough() const { return hough_; }

  std::int64_t with_flow = 0;

 private:
  HoughDetectorConfig config_;
  PlaneFitFlow flow_;
  ReferenceHough hough_;
};

TEST(HoughDetector, EqualsTheReferenceForAnyIntervalBetweenEstimates) {
  const ImageSize size{29, 22};
  for (const bool directed : {false, true}) {
    std::int64_t with_flow = 0;
    std::size_t asked = 0;
    for (const std::string_view kind : {"random", "clustered", "border_hugging"}) {
      for (const std::int64_t window : {1, 30, 400}) {
        const HoughDetectorConfig config = config_of(directed, 3, 8, window);
        const std::vector<Event> events = streams::named(kind, size, 300, 8);
        for (const std::size_t batch : {1, 7, 29, 30, 31, 60, 75}) {
          SCOPED_TRACE(std::string(kind) + ", window " + std::to_string(window) + ", asked every " +
                       std::to_string(batch));
          HoughDetector fast(config, size);
          PlainDetector plain(config, size);
          for (std::size_t i = 0; i < events.size(); i += batch) {
            const auto part = std::span(events).subspan(i, std::min(batch, events.size() - i));
            fast.process(part, nullptr);
            for (const Event& e : part) plain.push(e);
            expect_same(fast.estimate(), plain.estimate());
            std::size_t k = 0;
            for (int r = 3; r <= 8; ++r) {
              for (int y = 0; y < size.height; ++y) {
                for (int x = 0; x < size.width; ++x, ++k) {
                  ASSERT_EQ(fast.transform().votes(x, y, r), plain.hough().votes()[k]);
                }
              }
            }
            ++asked;
          }
          with_flow += plain.with_flow;
        }
      }
    }
    EXPECT_GT(with_flow, 1000);
    std::printf("%s: equal at %zu asked instants\n", directed ? "directed" : "full", asked);
  }
}

TEST(HoughDetector, GivesTheSameEstimateForAnyIntervalAndBatchSize) {
  // A real size, and batches whose rejected events must not shift the window.
  const ImageSize size{128, 128};
  for (const bool directed : {false, true}) {
    HoughDetectorConfig config = config_of(directed, 10, 20, 300);
    std::vector<Event> events = streams::cluttered(size, 4000, 0.4, 2);
    const RandomStream random(3, "rejected");
    for (std::size_t i = 100; i < events.size(); ++i) {
      if (random.uniform(0, i) < 0.1) events[i].x = 128;
      if (random.uniform(1, i) < 0.1) events[i].t_us -= 1000;
    }
    HoughDetector each(config, size);
    HoughDetector rarely(config, size);
    HoughDetector in_parts(config, size);
    std::size_t begin = 0;
    std::size_t step = 1;
    std::size_t asked = 0;
    while (begin < events.size()) {
      const std::size_t end = std::min(events.size(), begin + step);
      Estimate last;
      for (std::size_t i = begin; i < end; ++i) {
        each.process({&events[i], 1}, nullptr);
        last = each.estimate();
      }
      rarely.process(std::span(events).subspan(begin, end - begin), nullptr);
      for (std::size_t i = begin; i < end; i += 3) {
        in_parts.process(std::span(events).subspan(i, std::min<std::size_t>(3, end - i)), nullptr);
      }
      expect_same(rarely.estimate(), last);
      expect_same(in_parts.estimate(), last);
      begin = end;
      step = 1 + random.bits(2, asked) % 700;
      ++asked;
    }
    EXPECT_GT(each.rejected().outside_image, 100);
    EXPECT_GT(each.rejected().back_in_time, 100);
    EXPECT_EQ(rarely.rejected().outside_image, each.rejected().outside_image);
    EXPECT_EQ(rarely.rejected().back_in_time, each.rejected().back_in_time);
  }
}

TEST(HoughDetector, AcceptsEqualTimeStamps) {
  HoughDetector detector(config_of(false, 3, 6, 50), {32, 32});
  const std::vector<Event> events(80, streams::event_at(5, 16, 16, true));
  detector.process(events, nullptr);
  EXPECT_EQ(detector.rejected().back_in_time, 0);
  EXPECT_EQ(detector.estimate().score, 50.0 / HoughTransform({32, 32}, 3, 3, 1.0).divisor(3));
}

/// The expected estimate: a new transform of the events inside the window.
Estimate from_scratch(const HoughDetectorConfig& config, ImageSize size, std::span<const Event> events,
                      std::int64_t now_us) {
  const EventWindowConfig& window = config.window;
  HoughTransform hough(size, static_cast<int>(config.radius_px[0]), static_cast<int>(config.radius_px[1]),
                       config.arc_deg * std::numbers::pi / 180.0);
  PlaneFitFlow surface(config.flow, size);
  for (std::size_t i = 0; i < events.size(); ++i) {
    const Event& e = events[i];
    surface.add(e);
    const auto flow = surface.at(e);
    double lifetime_us = static_cast<double>(window.duration_us);
    if (window.kind == WindowKind::lifetime) {
      if (!flow) continue;
      lifetime_us = std::round(
          std::clamp(window.crossing_px * std::hypot(flow->dt_dx_us_px, flow->dt_dy_us_px),
                     static_cast<double>(window.shortest_us), static_cast<double>(window.longest_us)));
    }
    const bool newest = std::ssize(events) - static_cast<std::int64_t>(i) <= window.events;
    const bool alive = window.kind == WindowKind::count || static_cast<double>(now_us - e.t_us) < lifetime_us;
    if (!newest || !alive) continue;
    if (!config.directed) hough.vote_ring<1>(e.x, e.y);
    if (config.directed && flow) {
      hough.vote_arcs<1>(e.x, e.y, HoughTransform::direction_of(flow->dt_dx_us_px, flow->dt_dy_us_px));
    }
  }
  const HoughTransform::Peak peak = hough.peak();
  if (peak.votes == 0) return {};
  return {true,
          false,
          {static_cast<double>(peak.x), static_cast<double>(peak.y), static_cast<double>(peak.r)},
          peak.response};
}

TEST(HoughDetector, VotesWithTheEventsInsideTheWindowAsTimePasses) {
  const ImageSize size{48, 40};
  const std::vector<Event> events = streams::cluttered(size, 1500, 0.4, 5);
  for (const bool directed : {false, true}) {
    for (const WindowKind kind : {WindowKind::count, WindowKind::time, WindowKind::lifetime}) {
      HoughDetectorConfig config = config_of(directed, 12, 20, 1);
      config.window.kind = kind;
      for (const std::int64_t most : {60, 5000}) {
        config.window.events = most;
        config.window.duration_us = 9'000;
        config.window.longest_us = 20'000;
        HoughDetector detector(config, size);
        const RandomStream random(6, "asked");
        std::size_t done = 0;
        std::int64_t now_us = 0;
        std::int64_t by_time_alone = 0;
        for (std::uint64_t asked = 0; done < events.size(); ++asked) {
          SCOPED_TRACE(std::string(word_of(kind)) + (directed ? ", directed, " : ", full, ") +
                       std::to_string(most) + " events, asked " + std::to_string(asked));
          const std::size_t batch = random.bits(0, asked) % 4 == 0 ? 0 : random.bits(1, asked) % 90;
          const std::size_t end = std::min(events.size(), done + batch);
          detector.process(std::span(events).subspan(done, end - done), nullptr);
          done = end;
          if (done > 0) now_us = std::max(now_us, events[done - 1].t_us);
          if (random.bits(2, asked) % 2 == 0) {
            // At most 5 ms past the next event, which then comes late.
            std::int64_t later_us = now_us + static_cast<std::int64_t>(random.bits(3, asked) % 5000);
            if (done < events.size()) later_us = std::min(later_us, events[done].t_us + 5000);
            now_us = std::max(now_us, later_us);
            detector.advance_to(now_us, nullptr);
          }
          const Estimate before = from_scratch(config, size, std::span(events).first(done), now_us);
          expect_same(detector.estimate(), before);
          if (asked % 8 != 0) continue;
          now_us += 4000;
          detector.advance_to(now_us, nullptr);
          const Estimate after = from_scratch(config, size, std::span(events).first(done), now_us);
          expect_same(detector.estimate(), after);
          by_time_alone += after.score < before.score ? 1 : 0;
        }
        EXPECT_EQ(by_time_alone > 0, kind != WindowKind::count);
        detector.advance_to(now_us + 20'000, nullptr);
        EXPECT_EQ(detector.estimate().valid, kind == WindowKind::count);
      }
    }
  }
}

TEST(HoughDetector, ASingleRadiusIsTheMiddleOfTheRange) {
  HoughDetectorConfig config = config_of(false, 10, 35, 300);
  config.single_radius = true;
  HoughDetector single(config, {128, 128});
  HoughDetector plain(config_of(false, 23, 23, 300), {128, 128});
  const std::vector<Event> events = streams::cluttered({128, 128}, 2000, 0.5, 9);
  single.process(events, nullptr);
  plain.process(events, nullptr);
  expect_same(single.estimate(), plain.estimate());
}

TEST(HoughDetector, EqualsTheReferenceWithAnySingleRadius) {
  // The table of a plane has room for the ring that reaches furthest outside, whatever its radius.
  const ImageSize size{37, 35};
  const std::vector<Event> events = streams::border_hugging(size, 200, 12);
  for (int r = 1; r <= 33; ++r) {
    const HoughDetectorConfig config = config_of(false, r, r, 150);
    HoughDetector fast(config, size);
    PlainDetector plain(config, size);
    fast.process(events, nullptr);
    for (const Event& e : events) plain.push(e);
    SCOPED_TRACE(r);
    expect_same(fast.estimate(), plain.estimate());
  }
}

TEST(HoughDetector, ShowsTheLargestResponseAtEachPixel) {
  const ImageSize size{64, 48};
  HoughDetector detector(config_of(false, 5, 9, 200), size);
  detector.process(streams::clustered(size, 300, 4), nullptr);
  const Estimate best = detector.estimate();
  std::vector<float> space(static_cast<std::size_t>(size.pixels()), -1.0F);
  ASSERT_TRUE(detector.hough_space(space));
  const auto most = std::max_element(space.begin(), space.end());
  EXPECT_FLOAT_EQ(*most, static_cast<float>(best.score));
  EXPECT_FLOAT_EQ(space[static_cast<std::size_t>(best.circle.y_px * size.width + best.circle.x_px)],
                  static_cast<float>(best.score));
  const HoughTransform& hough = detector.transform();
  for (const auto& [x, y] : {std::pair(0, 0), std::pair(30, 20), std::pair(63, 47)}) {
    double largest = 0.0;
    for (int r = 5; r <= 9; ++r) {
      largest = std::max(largest, static_cast<double>(hough.votes(x, y, r)) / hough.divisor(r));
    }
    EXPECT_FLOAT_EQ(space[static_cast<std::size_t>(y * size.width + x)], static_cast<float>(largest));
  }
}

TEST(HoughDetector, GivesTheSameEstimateUntilMoreEventsAreProcessed) {
  HoughDetector detector(config_of(true, 5, 9, 100), {64, 64});
  detector.process(streams::random({64, 64}, 300, 4), nullptr);
  const Estimate before = detector.estimate();
  detector.process({}, nullptr);
  detector.advance_to(10'000'000, nullptr);
  expect_same(detector.estimate(), before);
}

TEST(HoughDetector, NamesTheKeysOfABadConfiguration) {
  const auto message = [](auto change) -> std::string {
    HoughDetectorConfig config;
    change(config);
    try {
      HoughDetector detector(config, {128, 128});
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message([](auto& c) {
              c.radius_px = {20, 10};
            }),
            "detector.radius_px: found [20, 10], expected two whole numbers, the smaller one first");
  EXPECT_THAT(message([](auto& c) {
                c.radius_px = {10.5, 20};
              }),
              HasSubstr("detector.radius_px: found [10.5, 20]"));
  EXPECT_EQ(message([](auto& c) {
              c.radius_px = {0, 10};
            }),
            "detector.radius_px: found 0, expected a finite number in [1, 255]");
  EXPECT_THAT(message([](auto& c) { c.window.events = 0; }), HasSubstr("detector.window.events: found 0"));
  EXPECT_THAT(message([](auto& c) { c.window.kind = static_cast<WindowKind>(7); }),
              HasSubstr("detector.window.kind: found nothing"));
  EXPECT_THAT(message([](auto& c) { c.arc_deg = std::nan(""); }), HasSubstr("detector.arc_deg: found nan"));
  EXPECT_THAT(message([](auto& c) { c.flow.half_width_px = 9; }),
              HasSubstr("detector.flow.half_width_px: found 9"));
  const std::string both = message([](auto& c) {
    c.threshold = -1;
    c.flow.inlier_px = 0;
  });
  EXPECT_THAT(both, HasSubstr("detector.threshold: found -1"));
  EXPECT_THAT(both, HasSubstr("detector.flow.inlier_px: found 0"));
  // What the full transform does not use is not its user's to get right.
  EXPECT_EQ(message([](auto& c) {
              c.directed = false;
              c.arc_deg = -3;
              c.flow.half_width_px = 100;
            }),
            "accepted");
}

}  // namespace
}  // namespace saccade
