#include "apps/deploy/edge_check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "robot/fake/fake_robot.h"
#include "tests/control/genova02.h"

namespace saccade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::SizeIs;

constexpr int width = 64, height = 48;

/// How the images of a robot's cameras change after the second in which they are to be at rest.
struct Scene {
  double speed_px_s = 40.0;  ///< of a vertical edge from the left border; 0: none
  bool leading_on = true;
  double noise_hz = 1.0;  ///< per pixel
  std::int64_t edge_begins_us = 1'500'000;
  std::vector<std::uint8_t> cameras = {0};
};

/// A fake robot whose cameras see an edge, and after 12 pixels the edge at which it becomes as dark as before.
class EdgeRobot final : public Robot, public EventSource {
 public:
  explicit EdgeRobot(const Scene& scene) : world_(script()), scene_(scene) {}

  Clock& clock() override { return world_; }
  EventSource& events() override { return *this; }
  HeadPort* head() override { return nullptr; }
  [[nodiscard]] ImageSize image_size() const override { return {width, height}; }
  PortStatus read_until(std::int64_t t_us, std::vector<Event>& events) override {
    std::bernoulli_distribution noisy(scene_.noise_hz * 1e-3), is_on(0.5);
    for (; next_us_ <= t_us; next_us_ += 1'000) {
      for (const std::uint8_t camera : scene_.cameras) {
        for (std::uint16_t y = 0; y < height; ++y) {
          for (std::uint16_t x = 0; x < width; ++x) {
            if (crosses(x)) events.push_back({next_us_, x, y, scene_.leading_on, camera});
            if (crosses(x + 12.0)) events.push_back({next_us_, x, y, !scene_.leading_on, camera});
            if (noisy(random_)) events.push_back({next_us_, x, y, is_on(random_), camera});
          }
        }
      }
    }
    return PortStatus::ok;
  }
  [[nodiscard]] std::int64_t heard_us() const override { return world_.now_us(); }
  [[nodiscard]] EventTraffic traffic() const override { return {}; }

 private:
  static FakeRobotScript script() {
    FakeRobotScript script;
    script.limits = genova02_limits();
    return script;
  }
  /// Whether the edge crosses x within the millisecond before next_us_.
  [[nodiscard]] bool crosses(double x) const {
    const auto place = [&](std::int64_t t_us) {
      return 1e-6 * static_cast<double>(t_us - scene_.edge_begins_us) * scene_.speed_px_s;
    };
    return place(next_us_ - 1'000) < x && x <= place(next_us_);
  }

  FakeRobot world_;
  Scene scene_;
  std::mt19937_64 random_{7};  // NOLINT(cert-msc32-c,cert-msc51-cpp): the same in each run
  std::int64_t next_us_ = 0;
};

StartUpCheck only_check(const Scene& scene) {
  EdgeRobot robot(scene);
  const auto checks = edge_checks(robot, 5.0, "swap it");
  EXPECT_THAT(checks, SizeIs(1));
  return checks.front();
}

TEST(EdgeCheck, ABrighterEdgeThatMakesOnEventsPasses) {
  const StartUpCheck check = only_check({});
  EXPECT_TRUE(check.passed) << check.found;
  EXPECT_EQ(check.what, "ON means brighter (left camera)");
  EXPECT_THAT(check.found, HasSubstr("made ON at")) << "of a fifth of the pixels or more";
}

TEST(EdgeCheck, ABrighterEdgeThatMakesOffEventsNamesTheRemedy) {
  const StartUpCheck check = only_check({.leading_on = false});
  EXPECT_FALSE(check.passed);
  EXPECT_THAT(check.found, AllOf(HasSubstr("ON means darker"), HasSubstr("; swap it")));
}

TEST(EdgeCheck, TheEdgeAtWhichItBecomesDarkAgainDoesNotCount) {
  for (const double speed_px_s : {40.0, 300.0}) {
    EdgeRobot robot({.speed_px_s = speed_px_s, .noise_hz = 0.0});
    EdgePolarity polarity(robot.image_size());
    std::vector<Event> events;
    robot.read_until(10'000'000, events);
    for (const Event& event : events) polarity.add(event);
    EXPECT_GT(polarity.on(), width * height * 9 / 10) << speed_px_s << " px/s";
    EXPECT_EQ(polarity.off(), 0);
  }
}

TEST(EdgeCheck, NoiseAloneIsNoEdge) {
  const StartUpCheck check = only_check({.speed_px_s = 0.0, .noise_hz = 2.0});
  EXPECT_FALSE(check.passed);
  EXPECT_THAT(check.found, HasSubstr("of 3072 pixels, expected 154 or more"));
}

TEST(EdgeCheck, AnImageThatIsNotAtRestFails) {
  const StartUpCheck check = only_check({.edge_begins_us = 200'000});
  EXPECT_FALSE(check.passed);
  EXPECT_THAT(check.found, HasSubstr("a scene at rest"));
}

TEST(EdgeCheck, EachCameraThatSendsEventsIsChecked) {
  EdgeRobot robot({.cameras = {0, 1}});
  const auto checks = edge_checks(robot, 5.0, {});
  ASSERT_THAT(checks, SizeIs(2));
  EXPECT_EQ(checks[1].what, "ON means brighter (right camera)");
  EXPECT_TRUE(checks[0].passed && checks[1].passed);
}

TEST(EdgeCheck, APolarityThatDiffersBetweenPixelsIsUndecided) {
  EdgePolarity polarity({width, height});
  const Scene scene{.noise_hz = 0.0};
  EdgeRobot bright(scene), dark({.leading_on = false, .noise_hz = 0.0});
  std::vector<Event> of_bright, of_dark;
  bright.read_until(4'000'000, of_bright);
  dark.read_until(4'000'000, of_dark);
  ASSERT_EQ(of_bright.size(), of_dark.size());
  for (std::size_t i = 0; i < of_bright.size(); ++i)
    polarity.add(of_bright[i].y < height / 2 ? of_bright[i] : of_dark[i]);
  EXPECT_GT(polarity.on(), width * height / 3);
  EXPECT_GT(polarity.off(), width * height / 3);
}

}  // namespace
}  // namespace saccade
