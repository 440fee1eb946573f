#include "core/hough_detector.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "core/detector_factory.h"
#include "tests/core/allocation_counter.h"
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
  config.window_events = window;
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
               static_cast<std::size_t>(config.window_events),
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

TEST(HoughDetector, EqualsTheReferenceHoweverOftenItIsAsked) {
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

TEST(HoughDetector, GivesTheSameAnswerAskedRarelyInOneBatchOrInMany) {
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

TEST(HoughDetector, FindsAMovingBall) {
  for (const std::string& preset : detector_presets()) {
    DetectorConfig config = detector_preset(preset);
    config.hough.window_events = 400;  // an outline of r = 20 is about 8 events per pixel of motion
    const auto detector = make_detector(config, PinholeCamera{});
    const streams::MovingDisc disc{35, 50, 400, 200, 20};
    EXPECT_FALSE(detector->estimate().valid);
    const std::vector<Event> events = disc.events({128, 128}, 0.12);
    std::size_t next = 0;
    double worst_px = 0.0;
    double worst_r_px = 0.0;
    for (std::int64_t now = 1000; now <= 120'000; now += 1000) {
      std::size_t end = next;
      while (end < events.size() && events[end].t_us <= now) ++end;
      detector->process(std::span(events).subspan(next, end - next), nullptr);
      detector->advance_to(now, nullptr);
      next = end;
      if (now < 20'000) continue;
      const Estimate e = detector->estimate();
      ASSERT_TRUE(e.valid);
      EXPECT_FALSE(e.held);
      worst_px =
          std::max(worst_px, std::hypot(e.circle.x_px - disc.x_at(now), e.circle.y_px - disc.y_at(now)));
      worst_r_px = std::max(worst_r_px, std::abs(e.circle.r_px - 20));
    }
    std::printf("%s: worst error %.2f px, radius %.2f px\n", preset.c_str(), worst_px, worst_r_px);
    // The window lags half its length: 400 events are about 7 px of motion of both edges.
    EXPECT_LT(worst_px, 6.0);
    EXPECT_LT(worst_r_px, 2.0);
  }
}

TEST(HoughDetector, CountsEventsItCannotUseAndIsNotChangedByThem) {
  const ImageSize size{128, 128};
  HoughDetector clean(config_of(true, 10, 20, 300), size);
  HoughDetector soiled(config_of(true, 10, 20, 300), size);
  const std::vector<Event> events = streams::MovingDisc{50, 50, 300, 0, 15}.events(size, 0.1);
  std::int64_t strays = 0;
  for (const Event& e : events) {
    clean.process({&e, 1}, nullptr);
    const std::array<Event, 4> with_strays = {Event{e.t_us, 128, 5, true, 0}, e,
                                              Event{e.t_us - 1, 40, 40, true, 0},
                                              Event{e.t_us + 1'000'000, 7, 65535, true, 0}};
    soiled.process(with_strays, nullptr);
    ++strays;
    expect_same(soiled.estimate(), clean.estimate());
  }
  EXPECT_EQ(soiled.rejected().outside_image, 2 * strays);
  EXPECT_EQ(soiled.rejected().back_in_time, strays);
  EXPECT_EQ(clean.rejected().outside_image, 0);
  EXPECT_EQ(clean.rejected().back_in_time, 0);
}

TEST(HoughDetector, TakesEventsThatRepeatATime) {
  HoughDetector detector(config_of(false, 3, 6, 50), {32, 32});
  const std::vector<Event> events(80, streams::event_at(5, 16, 16, true));
  detector.process(events, nullptr);
  EXPECT_EQ(detector.rejected().back_in_time, 0);
  EXPECT_EQ(detector.estimate().score, 50.0 / HoughTransform({32, 32}, 3, 3, 1.0).ring_pixels(3));
}

TEST(HoughDetector, SaysTheSameUntilMoreIsProcessed) {
  HoughDetector detector(config_of(true, 5, 9, 100), {64, 64});
  detector.process(streams::random({64, 64}, 300, 4), nullptr);
  const Estimate before = detector.estimate();
  detector.process({}, nullptr);
  detector.advance_to(10'000'000, nullptr);
  expect_same(detector.estimate(), before);
}

TEST(HoughDetector, DoesNotAllocateInTheTick) {
  const ImageSize size{128, 128};
  const std::vector<Event> events = streams::cluttered(size, 30'000, 0.3, 1);
  for (const std::string& preset : detector_presets()) {
    const auto detector = make_detector(detector_preset(preset), PinholeCamera{});
    const std::int64_t before = allocation_count();
    for (std::size_t i = 0; i < events.size(); i += 97) {
      detector->process(std::span(events).subspan(i, std::min<std::size_t>(97, events.size() - i)), nullptr);
      detector->advance_to(events[i].t_us, nullptr);
      static_cast<void>(detector->estimate());
    }
    EXPECT_EQ(allocation_count() - before, 0) << preset;
  }
  const std::int64_t before = allocation_count();
  static_cast<void>(make_detector(detector_preset("paper_directed"), PinholeCamera{}));
  EXPECT_GT(allocation_count() - before, 5);  // the count works
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
  EXPECT_THAT(message([](auto& c) { c.radius_px = {10}; }), HasSubstr("expected 2 numbers"));
  EXPECT_EQ(message([](auto& c) {
              c.radius_px = {0, 10};
            }),
            "detector.radius_px: found 0, expected a finite number in [1, 255]");
  EXPECT_THAT(message([](auto& c) { c.window_events = 0; }), HasSubstr("detector.window.events: found 0"));
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

TEST(DetectorFactory, KnowsThePapersPresets) {
  EXPECT_THAT(detector_presets(), testing::ElementsAre("paper_full", "paper_directed"));
  for (const std::string& name : detector_presets()) {
    const DetectorConfig config = detector_preset(name);
    EXPECT_EQ(config.preset, name);
    EXPECT_EQ(config.hough.directed, name == "paper_directed");
    EXPECT_EQ(config.hough.window_events, 1500);
    EXPECT_EQ(config.hough.arc_deg, 10.0);
    EXPECT_THAT(config.hough.radius_px, testing::ElementsAre(10, 35));
  }
  EXPECT_THROW(static_cast<void>(detector_preset("paper")), InputError);
}

}  // namespace
}  // namespace saccade
