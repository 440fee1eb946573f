// What every shipped detector does, and the registry of detectors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <ostream>

#include "core/baselines/blob_filter.h"
#include "core/baselines/cluster.h"
#include "core/baselines/eros.h"
#include "core/baselines/multi_kernel.h"
#include "core/baselines/original_2016.h"
#include "core/baselines/particle_filter.h"
#include "core/baselines/scarf.h"
#include "core/detector.h"
#include "core/detectors/built_in_detectors.h"
#include "core/hough/hough_detector.h"
#include "core/tracker/ball_tracker.h"
#include "head/icub_cameras.h"
#include "tests/core/allocation_counter.h"
#include "tests/core/streams.h"

namespace saccade {

static bool operator==(const Estimate& a, const Estimate& b) {
  return a.valid == b.valid && a.held == b.held && a.circle.x_px == b.circle.x_px &&
         a.circle.y_px == b.circle.y_px && a.circle.r_px == b.circle.r_px && a.score == b.score;
}
static std::ostream& operator<<(std::ostream& out, const Estimate& e) {
  return out << (e.valid ? "" : "no ") << "circle " << e.circle.x_px << " " << e.circle.y_px << " "
             << e.circle.r_px << ", score " << e.score;
}

namespace {

constexpr ImageSize image{128, 128};

std::unique_ptr<Detector> make(const std::string& preset) {
  return make_detector(built_in_detectors().config(preset), icub_left_2016);
}

/// With a window that suits a ball alone: 400 events are about 7 px of motion of both edges of r = 23.
std::unique_ptr<Detector> make_for_ball_alone(const std::string& preset) {
  DetectorConfig config = built_in_detectors().config(preset);
  if (auto* hough = config.get_if<HoughDetectorConfig>()) hough->window.events = 400;
  if (auto* original = config.get_if<Original2016Config>()) original->window_events = 400;
  return make_detector(config, icub_left_2016);
}

class EveryDetector : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Presets, EveryDetector, testing::ValuesIn(built_in_detectors().names()),
                         [](const auto& test) { return test.param; });

TEST_P(EveryDetector, FindsAMovingBall) {
  const auto detector = make_for_ball_alone(GetParam());
  EXPECT_FALSE(detector->estimate().valid);
  // single_radius finds 23 px only.
  const streams::MovingDisc disc{35, 50, 400, 200, 22.5};
  const std::vector<Event> events = disc.events(image, 0.12);
  std::size_t next = 0;
  double worst_px = 0.0;
  double worst_r_px = 0.0;
  double least_score = std::numeric_limits<double>::infinity();
  for (std::int64_t now = 1000; now <= 120'000; now += 1000) {
    std::size_t end = next;
    while (end < events.size() && events[end].t_us <= now) ++end;
    detector->process(std::span(events).subspan(next, end - next), nullptr);
    detector->advance_to(now, nullptr);
    next = end;
    if (now < 30'000) continue;
    const Estimate e = detector->estimate();
    ASSERT_TRUE(e.valid);
    worst_px = std::max(worst_px, std::hypot(e.circle.x_px - disc.x_at(now), e.circle.y_px - disc.y_at(now)));
    worst_r_px = std::max(worst_r_px, std::abs(e.circle.r_px - disc.r_px));
    least_score = std::min(least_score, e.score);
  }
  std::printf("%s: worst error %.2f px, radius %.2f px, least score %.2f\n", GetParam().c_str(), worst_px,
              worst_r_px, least_score);
  EXPECT_LT(worst_px, 6.0);
  EXPECT_LT(worst_r_px, 2.0);
}

TEST_P(EveryDetector, GivesTheSameEstimatesForAnyBatchSize) {
  const std::vector<Event> events = streams::cluttered(image, 6000, 0.4, 2);
  const auto at_once = make(GetParam());
  const auto one_by_one = make(GetParam());
  const auto asked_often = make(GetParam());
  for (std::size_t i = 0; i < events.size(); i += 600) {
    const auto part = std::span(events).subspan(i, 600);
    at_once->process(part, nullptr);
    for (std::size_t k = 0; k < part.size(); ++k) {
      one_by_one->process(part.subspan(k, 1), nullptr);
      asked_often->process(part.subspan(k, 1), nullptr);
      if (k % 7 == 0) static_cast<void>(asked_often->estimate());
    }
    const Estimate first = at_once->estimate();
    EXPECT_EQ(one_by_one->estimate(), first);
    EXPECT_EQ(asked_often->estimate(), first);
    EXPECT_EQ(at_once->estimate(), first);
  }
}

TEST_P(EveryDetector, AcceptsTheEarliestAndTheLatestTimeStamps) {
  const std::vector<Event> events = streams::cluttered(image, 6000, 0.4, 2);
  for (const std::int64_t shift_us : streams::shifts_to_the_ends_of_time(events.back().t_us)) {
    const auto detector = make(GetParam());
    for (const Event& e : streams::shifted(events, shift_us)) detector->process({&e, 1}, nullptr);
    EXPECT_TRUE(detector->estimate().valid) << shift_us;
    EXPECT_EQ(detector->rejected().back_in_time, 0);
    // The jump to the end takes no longer than any other.
    detector->advance_to(std::numeric_limits<std::int64_t>::max(), nullptr);
    static_cast<void>(detector->estimate());
  }
}

TEST_P(EveryDetector, GivesTheSameEstimatesAtTheEarliestAndTheLatestTimeStamps) {
  if (GetParam() == "cluster" || GetParam() == "multi_kernel") {
    GTEST_SKIP() << "this detector keeps time in floating point";
  }
  const std::vector<Event> events = streams::cluttered(image, 6000, 0.4, 2);
  for (const std::int64_t shift_us : streams::shifts_to_the_ends_of_time(events.back().t_us)) {
    const auto original = make(GetParam());
    const auto shifted = make(GetParam());
    const std::vector<Event> shifted_events = streams::shifted(events, shift_us);
    for (std::size_t i = 0; i < events.size(); i += 100) {
      original->process(std::span(events).subspan(i, 100), nullptr);
      shifted->process(std::span(shifted_events).subspan(i, 100), nullptr);
      ASSERT_EQ(shifted->estimate(), original->estimate())
          << "event " << i << ", shift " << shift_us << " us";
    }
  }
}

TEST_P(EveryDetector, ACopyContinuesLikeTheOriginal) {
  const std::vector<Event> events = streams::cluttered(image, 6000, 0.4, 2);
  const auto detector = make(GetParam());
  detector->process(std::span(events).first(3000), nullptr);
  detector->advance_to(events[2999].t_us, nullptr);
  static_cast<void>(detector->estimate());
  const auto copy = copy_of(*detector);
  int compared = 0;
  for (std::size_t i = 3000; i < events.size(); i += 300) {
    for (Detector* each : {detector.get(), copy.get()}) {
      each->process(std::span(events).subspan(i, 300), nullptr);
      each->advance_to(events[i + 299].t_us, nullptr);
    }
    const Estimate expected = detector->estimate();
    EXPECT_EQ(copy->estimate(), expected) << i;
    compared += expected.valid ? 1 : 0;
  }
  EXPECT_GT(compared, 5);
}

TEST_P(EveryDetector, CountsRejectedEventsAndIsNotChangedByThem) {
  const auto clean = make(GetParam());
  const auto soiled = make(GetParam());
  std::int64_t strays = 0;
  for (const Event& e : streams::MovingDisc{50, 50, 300, 0, 15}.events(image, 0.1)) {
    clean->process({&e, 1}, nullptr);
    const std::array<Event, 4> with_strays = {Event{e.t_us, 128, 5, true, 0}, e,
                                              Event{e.t_us - 1, 40, 40, true, 0},
                                              Event{e.t_us + 1'000'000, 7, 65535, true, 0}};
    soiled->process(with_strays, nullptr);
    ++strays;
    ASSERT_EQ(soiled->estimate(), clean->estimate());
  }
  EXPECT_EQ(soiled->rejected().outside_image, 2 * strays);
  EXPECT_EQ(soiled->rejected().back_in_time, strays);
  EXPECT_EQ(clean->rejected().outside_image, 0);
  EXPECT_EQ(clean->rejected().back_in_time, 0);
}

TEST_P(EveryDetector, WorksAfterAnyStreamOfEvents) {
  // Repeated, backward and far-ahead stamps, pixels inside and far outside.
  const auto detector = make_for_ball_alone(GetParam());
  const RandomStream random(8, "wild");
  std::int64_t offered = 0;
  std::int64_t usable = 0;
  std::int64_t newest = 0;
  for (std::uint64_t i = 0; i < 20'000; ++i, ++offered) {
    const auto wild = [&](std::uint64_t stream) {
      const auto bits = random.bits(stream, i);
      return static_cast<std::uint16_t>(bits % 8 == 0 ? bits >> 40 : (bits >> 40) % 128);
    };
    const auto jump = static_cast<std::int64_t>(random.bits(2, i) % 200);
    const std::int64_t t = random.bits(3, i) % 500 == 0 ? jump * 1'000'000'000 : newest + jump - 60;
    const Event e{t, wild(0), wild(1), random.bits(4, i) % 2 == 0, 0};
    detector->process({&e, 1}, nullptr);
    if (i % 50 == 0) detector->advance_to(e.t_us - 500, nullptr);
    if (i % 20 == 0) static_cast<void>(detector->estimate());
    if (e.x < 128 && e.y < 128 && (usable == 0 || e.t_us >= newest)) {
      newest = e.t_us;
      ++usable;
    }
  }
  EXPECT_GT(usable, 5000);
  EXPECT_EQ(detector->rejected().outside_image + detector->rejected().back_in_time, offered - usable);
  const Estimate e = detector->estimate();
  if (e.valid) {
    EXPECT_TRUE(std::isfinite(e.circle.x_px) && std::isfinite(e.circle.y_px) && std::isfinite(e.score));
  }
  // Nothing is corrupt: a ball that comes later is found as by a detector that saw nothing else.
  const auto fresh = make_for_ball_alone(GetParam());
  std::vector<Event> ball = streams::MovingDisc{35, 64, 400, 0, 23}.events(image, 0.1);
  for (Event& b : ball) b.t_us += newest + 1'000'000;
  detector->process(ball, nullptr);
  fresh->process(ball, nullptr);
  EXPECT_NEAR(detector->estimate().circle.x_px, fresh->estimate().circle.x_px, 2);
  EXPECT_NEAR(detector->estimate().circle.y_px, fresh->estimate().circle.y_px, 2);
  EXPECT_NEAR(detector->estimate().circle.r_px, fresh->estimate().circle.r_px, 2);
}

TEST_P(EveryDetector, DoesNotAllocateInTheTick) {
  const std::vector<Event> events = streams::cluttered(image, 30'000, 0.3, 1);
  const auto detector = make(GetParam());
  const std::int64_t before = allocation_count();
  for (std::size_t i = 0; i < events.size(); i += 97) {
    detector->process(std::span(events).subspan(i, std::min<std::size_t>(97, events.size() - i)), nullptr);
    detector->advance_to(events[i].t_us + 1000, nullptr);
    static_cast<void>(detector->estimate());
  }
  EXPECT_EQ(allocation_count() - before, 0);
  static_cast<void>(make(GetParam()));
  EXPECT_GT(allocation_count() - before, 1);  // the count works
}

TEST_P(EveryDetector, ACopyDoesNotAllocateInTheTick) {
  const std::vector<Event> events = streams::cluttered(image, 30'000, 0.3, 1);
  const auto part = [&](std::size_t i) {
    return std::span(events).subspan(i, std::min<std::size_t>(97, events.size() - i));
  };
  const auto detector = make(GetParam());
  const auto of_new = copy_of(*detector);
  const auto of_copy = copy_of(*of_new);
  for (std::size_t i = 0; i < 3'000; i += 97) detector->process(part(i), nullptr);
  const auto of_used = copy_of(*detector);
  const std::int64_t before = allocation_count();
  for (std::size_t i = 0; i < events.size(); i += 97) {
    for (Detector* copy : {of_new.get(), of_copy.get(), of_used.get()}) {
      copy->process(part(i), nullptr);
      copy->advance_to(events[i].t_us + 1000, nullptr);
      static_cast<void>(copy->estimate());
      copy->work_ahead();
    }
  }
  EXPECT_EQ(allocation_count() - before, 0);
}

TEST_P(EveryDetector, ShowsABallInItsHoughSpaceIfItHasOne) {
  const auto detector = make_for_ball_alone(GetParam());
  detector->process(streams::MovingDisc{35, 50, 400, 200, 22.5}.events(image, 0.08), nullptr);
  const Estimate e = detector->estimate();
  std::vector<float> space(static_cast<std::size_t>(image.pixels()), -1.0F);
  if (!hough_space_of(*detector, space)) {
    EXPECT_THAT(space, testing::Each(-1.0F));
    return;
  }
  EXPECT_THAT(space, testing::Each(testing::Ge(0.0F)));
  const auto peak = std::max_element(space.begin(), space.end()) - space.begin();
  EXPECT_LT(std::hypot(static_cast<double>(peak % image.width) - e.circle.x_px,
                       static_cast<double>(peak / image.width) - e.circle.y_px),
            4.0);
}

template <class... Configs>
void set_radius_px(DetectorConfig& config, const std::array<double, 2>& radius_px) {
  const auto set = [&](auto* fields) {
    if (fields != nullptr) fields->radius_px = radius_px;
    return fields != nullptr;
  };
  ASSERT_EQ((0 + ... + static_cast<int>(set(config.get_if<Configs>()))), 1);
}

TEST_P(EveryDetector, AcceptsARangeOfRadii) {
  DetectorConfig config = built_in_detectors().config(GetParam());
  const auto set =
      set_radius_px<HoughDetectorConfig, BallTrackerConfig, Original2016Config, ClusterConfig,
                    MultiKernelConfig, ErosConfig, ScarfConfig, ParticleFilterConfig, BlobFilterConfig>;
  set(config, {4, 25});
  EXPECT_NO_THROW(static_cast<void>(make_detector(config, icub_left_2016)));
  for (const auto& wrong : {std::array<double, 2>{25, 4}, {4.5, 25}, {0, 25}, {4, 256}}) {
    set(config, wrong);
    EXPECT_THROW(static_cast<void>(make_detector(config, icub_left_2016)), InputError);
  }
}

TEST_P(EveryDetector, ScalesItsThresholdWithinItsRange) {
  DetectorConfig config = built_in_detectors().config(GetParam());
  const double threshold = make(GetParam())->threshold();
  EXPECT_TRUE(config.scale_threshold(0.5));
  EXPECT_EQ(make_detector(config, icub_left_2016)->threshold(), 0.5 * threshold);
  EXPECT_FALSE(config.scale_threshold(-1.0));
  EXPECT_EQ(make_detector(config, icub_left_2016)->threshold(), 0.5 * threshold);
}

TEST(DetectorRegistry, HoldsTheShippedDetectorsByPreset) {
  const DetectorRegistry registry = built_in_detectors();
  EXPECT_THAT(registry.names(),
              testing::ElementsAre("paper_full", "paper_directed", "best", "lifetime", "single_radius",
                                   "original_2016", "cluster", "multi_kernel", "eros", "scarf",
                                   "particle_filter", "blob_filter"));
  EXPECT_THAT(registry.defaults, testing::ElementsAre("paper_full", "paper_directed", "best"));
  for (const DetectorRow& row : registry.rows()) {
    EXPECT_EQ(registry.config(row.name).preset(), row.name);
    EXPECT_FALSE(row.description.empty()) << row.name;
  }
  for (const bool directed : {false, true}) {
    const DetectorConfig config = registry.config(directed ? "paper_directed" : "paper_full");
    const auto& hough = config.get<HoughDetectorConfig>();
    EXPECT_EQ(hough.directed, directed);
    EXPECT_EQ(hough.window.kind, WindowKind::count);
    EXPECT_EQ(hough.window.events, 1500);
    EXPECT_EQ(hough.arc_deg, 10.0);
    EXPECT_THAT(hough.radius_px, testing::ElementsAre(10, 35));
  }
  EXPECT_THROW(static_cast<void>(registry.config("paper")), InputError);
}

TEST(DetectorRegistry, GivesTheWindowOfADetectorInWords) {
  DetectorConfig directed = built_in_detectors().config("paper_directed");
  EXPECT_EQ(directed.window(), "1500 events");
  directed.get<HoughDetectorConfig>().window.kind = WindowKind::time;
  EXPECT_EQ(directed.window(), "20 ms");
  EXPECT_EQ(built_in_detectors().config("lifetime").window(), "lifetime");
  EXPECT_EQ(built_in_detectors().config("original_2016").window(), "1000 events");
  EXPECT_EQ(built_in_detectors().config("best").window(), "");
}

DetectorRow named_row(const std::string& name) {
  return detector_row(name, "for this test", ClusterConfig{},
                      [](const ClusterConfig& config, const Camera& camera) {
                        return std::make_unique<ClusterDetector>(config, camera.size);
                      });
}

TEST(DetectorRegistry, TakesRowsOfAProgram) {
  DetectorRegistry registry = built_in_detectors();
  const DetectorConfig before = registry.config("best");
  ClusterConfig many;
  many.clusters = 7;
  DetectorRow row = named_row("many-clusters");
  row.config = TypeErasedConfig(many);
  registry.add(row);
  EXPECT_EQ(registry.names().back(), "many-clusters");
  const DetectorConfig config = registry.config("many-clusters");
  EXPECT_EQ(config.get<ClusterConfig>().clusters, 7);
  EXPECT_NE(make_detector(config, icub_left_2016), nullptr);
  EXPECT_NE(make_detector(before, icub_left_2016), nullptr);  // configs outlive changes of their registry
}

TEST(DetectorRegistry, RejectsANameThatIsTakenOrThatTablesAndFilesCannotHold) {
  DetectorRegistry registry = built_in_detectors();
  for (const char* name : {"best", "", "a,b", "a.b", "a/b", "../evil", "a b", "none", "caf\u00e9", "a\nb"}) {
    EXPECT_THROW(registry.add(named_row(name)), InputError) << name;
  }
  EXPECT_THROW(registry.add(named_row(std::string(65, 'a'))), InputError);
  EXPECT_NO_THROW(registry.add(named_row(std::string(64, 'a'))));
  EXPECT_EQ(registry.rows().size(), built_in_detectors().rows().size() + 1);
}

TEST(DetectorConfig, KeepsItsValuesApartFromThoseOfItsCopy) {
  DetectorConfig config = built_in_detectors().config("cluster");
  const DetectorConfig copy = config;
  config.get<ClusterConfig>().clusters = 3;
  EXPECT_EQ(copy.get<ClusterConfig>().clusters, ClusterConfig{}.clusters);
  EXPECT_EQ(config.get_if<BallTrackerConfig>(), nullptr);
}

}  // namespace
}  // namespace saccade
