#include "config/key_values.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/scenario.h"
#include "core/detectors/built_in_detectors.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

struct Example {
  double speed_m_s = 2.5;
  std::int64_t count = 3;
  std::string word = "a";
  std::array<double, 2> radius_px = {4, 25};
  std::vector<double> points = {1, 2, 3, 4};
  bool has_extra = false;
};

void describe(FieldVisitor& v, Example& e) {
  v.real("speed_m_s", e.speed_m_s, {}, "");
  v.section(
      "window",
      [&](FieldVisitor& w) {
        w.integer("count", e.count, {}, "");
        w.text("word", e.word, "");
      },
      "");
  v.reals("radius_px", e.radius_px, {}, "");
  v.point_list("points", e.points, 2, {}, "");
  v.when(e.has_extra, "has_extra", [&] { v.real("extra", e.speed_m_s, {}, ""); });
}

KeyValues keys_of(Example example) {
  KeyValues keys;
  describe(keys, example);
  return keys;
}

TEST(KeyValues, HasKeysAndSectionsByTheirPaths) {
  const KeyValues keys = keys_of({});
  for (const char* path : {"speed_m_s", "window", "window.count", "window.word", "radius_px", "points"})
    EXPECT_TRUE(keys.has(path)) << path;
  for (const char* path : {"", "count", "window.", "window.speed_m_s", "speed_m_s.x", "extra"})
    EXPECT_FALSE(keys.has(path)) << path;
}

TEST(KeyValues, HasKeysThatDependOnOthersWhereTheyAre) {
  EXPECT_TRUE(keys_of({.has_extra = true}).has("extra"));
}

TEST(KeyValues, ReturnsNumbersOfAnyKind) {
  const KeyValues keys = keys_of({});
  EXPECT_THAT(keys.numbers("speed_m_s"), ElementsAre(2.5));
  EXPECT_THAT(keys.numbers("window.count"), ElementsAre(3));
  EXPECT_THAT(keys.numbers("radius_px"), ElementsAre(4, 25));
  EXPECT_THAT(keys.numbers("points"), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(keys.numbers("window.word"), IsEmpty());
  EXPECT_THAT(keys.numbers("window"), IsEmpty());
  EXPECT_THAT(keys.numbers("nothing"), IsEmpty());
}

TEST(KeyValues, ReadsThoseOfDetectors) {
  const KeyValues keys = keys_of_detectors({{"mine", built_in_detectors().config("paper_full")}});
  EXPECT_TRUE(keys.has("detectors.mine.window.events"));
  EXPECT_EQ(keys.numbers("detectors.mine.radius_px").size(), 2U);
  EXPECT_FALSE(keys.has("detectors.mine.hold_s"));
}

}  // namespace
}  // namespace saccade
