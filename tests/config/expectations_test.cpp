#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/scenario.h"
#include "core/error.h"
#include "tests/config/built_in.h"

namespace saccade {
namespace {

using testing::HasSubstr;

Scenario scenario_with(const std::string& expect) {
  return read_scenario(SACCADE_SOURCE_DIR "/scenarios/look_at_ball.yaml", {"expect=" + expect}, std::nullopt,
                       built_in());
}

std::string problems_of(const std::string& expect) {
  try {
    static_cast<void>(scenario_with(expect));
  } catch (const InputError& error) {
    return error.what();
  }
  return {};
}

TEST(Expectations, ALowerAndAnUpperBoundInAListPassThemselves) {
  const Scenario scenario = scenario_with("{gaze.moves: [1, 5]}");
  ASSERT_EQ(scenario.expect.size(), 1U);
  const Expectation& e = scenario.expect.front();
  EXPECT_TRUE(e.holds(1.0) && e.holds(5.0));
  EXPECT_FALSE(e.holds(0.99) || e.holds(5.01));
  EXPECT_EQ(e.text(), "1 to 5");
}

TEST(Expectations, ABoundMayBeOneSidedAndMayExcludeItself) {
  const Scenario scenario = scenario_with(
      "{gaze.acquire_s: {below: 1}, gaze.moves: {at_least: 2}, events.count: {above: 0, at_most: 7}}");
  ASSERT_EQ(scenario.expect.size(), 3U);
  const auto& [acquire, moves, events] = std::tie(scenario.expect[0], scenario.expect[1], scenario.expect[2]);
  EXPECT_TRUE(acquire.holds(-1e9) && acquire.holds(0.999));
  EXPECT_FALSE(acquire.holds(1.0));
  EXPECT_EQ(acquire.text(), "below 1");
  EXPECT_TRUE(moves.holds(2.0) && moves.holds(1e9));
  EXPECT_FALSE(moves.holds(1.999));
  EXPECT_TRUE(events.holds(7.0) && events.holds(1e-9));
  EXPECT_FALSE(events.holds(0.0) || events.holds(7.1));
  EXPECT_EQ(events.text(), "above 0 and at most 7");
}

TEST(Expectations, TheResolvedScenarioKeepsEveryKindOfBound) {
  const Scenario first =
      scenario_with("{gaze.moves: [1, 5], gaze.acquire_s: {below: 1}, events.count: {above: 0}}");
  const std::string yaml = resolved_scenario(first);
  const Scenario again = read_scenario(parse_yaml(yaml, "again.yaml"), ".", built_in());
  ASSERT_EQ(again.expect.size(), 3U);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(again.expect[i].metric, first.expect[i].metric);
    EXPECT_EQ(again.expect[i].text(), first.expect[i].text());
  }
  EXPECT_EQ(resolved_scenario(again), yaml);
}

TEST(Expectations, MistakesAreReportedWithTheKey) {
  EXPECT_THAT(problems_of("{gaze.moves: {at_leest: 1}}"), HasSubstr("did you mean at_least"));
  EXPECT_THAT(problems_of("{gaze.moves: {}}"), HasSubstr("gaze.moves: found no bound"));
  EXPECT_THAT(problems_of("{gaze.moves: [5, 1]}"),
              HasSubstr("a lower bound that is not above the upper one"));
  EXPECT_THAT(problems_of("{gaze.moves: {above: 5, below: 1}}"),
              HasSubstr("a lower bound that is not above"));
  EXPECT_THAT(problems_of("{gaze.moovs: {above: 5}}"), HasSubstr("no such figure"));
}

TEST(Expectations, AFigureThatDoesNotApplyMeetsNothing) {
  const Scenario scenario = scenario_with("{gaze.acquire_s: {at_least: 0}, gaze.moves: {at_least: 0}}");
  Metrics metrics;
  metrics.gaze.emplace();  // acquired never
  const std::vector<JudgedExpectation> judged = judge(scenario.expect, metrics);
  ASSERT_EQ(judged.size(), 2U);
  EXPECT_FALSE(judged[0].met());
  EXPECT_EQ(judged[0].text(), "gaze.acquire_s is null, expected at least 0");
  EXPECT_TRUE(judged[1].met());
}

}  // namespace
}  // namespace saccade
