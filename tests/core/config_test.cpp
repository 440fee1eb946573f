#include "core/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/camera.h"
#include "head/icub_cameras.h"

namespace saccade {
namespace {

using testing::HasSubstr;

struct Everything {
  double angle_deg = 1.0;
  std::int64_t count = 3;
  bool wanted = true;
  std::string name = "any";
  std::string kind = "round";
  std::array<double, 2> pair = {1, 2};
  std::vector<std::array<double, 3>> path = {{0, 0, 0}};
  double inner_s = 0.5;
};

void describe(FieldVisitor& v, Everything& e) {
  v.real("angle_deg", e.angle_deg, {-90, 90}, "");
  v.integer("count", e.count, {1, 10}, "");
  v.boolean("wanted", e.wanted, "");
  v.text("name", e.name, "");
  v.choice("kind", e.kind, {"round", "square"}, "");
  v.reals("pair", e.pair, {0.0}, "");
  v.points("path", e.path, {-1, 1}, "");
  v.section(
      "deep",
      [&](FieldVisitor& w) {
        w.real("inner_s", e.inner_s, {0, 1}, "");
      },
      "");
  v.require(e.pair[0] < e.pair[1], "pair", "two in the wrong order", "a rising pair");
}

/// The message of check_config for a change of the defaults; empty if it is valid.
template <class Change>
std::string complaint(Change change) {
  Everything e;
  change(e);
  try {
    check_config("thing", e);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(CheckConfig, AcceptsValuesAtTheEndsOfTheirRanges) {
  EXPECT_EQ(complaint([](auto&) {}), "");
  EXPECT_EQ(complaint([](auto& e) { e.angle_deg = -90; }), "");
  EXPECT_EQ(complaint([](auto& e) { e.count = 10; }), "");
  EXPECT_EQ(complaint([](auto& e) { e.path.clear(); }), "");
}

TEST(CheckConfig, NamesKeyValueAndExpectation) {
  EXPECT_EQ(complaint([](auto& e) { e.angle_deg = 90.5; }),
            "thing.angle_deg: found 90.5, expected a finite number in [-90, 90]");
  EXPECT_EQ(complaint([](auto& e) { e.angle_deg = std::nan(""); }),
            "thing.angle_deg: found nan, expected a finite number in [-90, 90]");
  EXPECT_EQ(complaint([](auto& e) { e.count = 0; }),
            "thing.count: found 0, expected a whole number in [1, 10]");
  EXPECT_EQ(complaint([](auto& e) { e.kind = "triangular"; }),
            "thing.kind: found triangular, expected one of round, square");
  EXPECT_EQ(complaint([](auto& e) { e.kind = ""; }),
            "thing.kind: found nothing, expected one of round, square");
  EXPECT_EQ(complaint([](auto& e) {
              e.pair = {-1, 2};
            }),
            "thing.pair: found -1, expected a finite number of at least 0");
  EXPECT_EQ(complaint([](auto& e) { e.pair[1] = std::numeric_limits<double>::infinity(); }),
            "thing.pair: found inf, expected a finite number of at least 0");
  EXPECT_EQ(complaint([](auto& e) {
              e.pair = {2, 1};
            }),
            "thing.pair: found two in the wrong order, expected a rising pair");
}

TEST(CheckConfig, NamesTheSectionOfAKey) {
  EXPECT_EQ(complaint([](auto& e) { e.inner_s = 2; }),
            "thing.deep.inner_s: found 2, expected a finite number in [0, 1]");
}

TEST(CheckConfig, ReportsEveryProblemAtOnce) {
  Everything e;
  e.angle_deg = 100;
  e.count = 11;
  e.path = {{2, 0, 0}, {0, -2, 0}};
  try {
    check_config("thing", e);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    ASSERT_EQ(error.problems().size(), 4U);
    EXPECT_EQ(error.problems()[0].place, "thing.angle_deg");
    EXPECT_EQ(error.problems()[3].value, "-2");
    EXPECT_EQ(std::count(error.what(), error.what() + std::string(error.what()).size(), '\n'), 3);
  }
}

TEST(CheckConfig, DoesNotChangeTheConfiguration) {
  const Everything e;
  check_config("thing", e);
  EXPECT_EQ(e.pair, Everything{}.pair);
  Camera camera = icub_left_2016;
  camera.size = {4, 128};
  EXPECT_THROW(check_config("camera", camera), InputError);
}

TEST(TextOf, IsTheShortestTextThatReadsBack) {
  EXPECT_EQ(text_of(0.1), "0.1");
  EXPECT_EQ(text_of(1500.0), "1500");
  EXPECT_EQ(text_of(-std::numeric_limits<double>::infinity()), "-inf");
  for (const double value : {1.0 / 3, 6.02214076e23, -5e-324, 0.30000000000000004}) {
    EXPECT_EQ(std::stod(text_of(1.0 / 3)), 1.0 / 3);
    EXPECT_EQ(std::strtod(text_of(value).c_str(), nullptr), value);
  }
}

TEST(InputError, NamesPlaceValueAndExpectation) {
  EXPECT_EQ(std::string(InputError("a.yaml:3: ball.r_m", "-1", "a number of at least 0").what()),
            "a.yaml:3: ball.r_m: found -1, expected a number of at least 0");
  EXPECT_EQ(std::string(InputError("a.yaml: ball", "", "this key").what()),
            "a.yaml: ball: expected this key");
}

TEST(SaccadeCheck, AbortsWithConditionAndPlaceInEveryBuild) {
  SACCADE_CHECK(1 + 1 == 2);
  EXPECT_DEATH(SACCADE_CHECK(1 + 1 == 3), "broken invariant at .*config_test.cpp:[0-9]+: 1 \\+ 1 == 3");
}

}  // namespace
}  // namespace saccade
