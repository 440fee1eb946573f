#include "config/key_reference.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/scenario.h"
#include "core/detectors/built_in_detectors.h"
#include "core/hough/event_window.h"

namespace saccade {
namespace {

using testing::Contains;
using testing::HasSubstr;

struct Motion {
  std::string kind = "hold";
  std::string profile = "smooth";
  double speed_m_s = 0.1;
  double ramp_s = 0.2;
  std::array<double, 2> range_px = {1.0, 2.0};
};

void describe(FieldVisitor& v, Motion& m) {
  v.choice("kind", m.kind, {"hold", "line", "circle"}, "the motion");
  if (m.kind == "line") {
    v.choice("profile", m.profile, {"smooth", "constant"}, "speed along the line");
    v.real("speed_m_s", m.speed_m_s, {0.0, 5.0}, "mean speed");
  }
  if (m.kind == "circle" || (m.kind == "line" && m.profile == "constant"))
    v.real("ramp_s", m.ramp_s, {0.0}, "time to full speed");
  v.reals("range_px", m.range_px, {1.0, 255.0}, "two radii | in order");
}

std::vector<KeyRow> motion_rows() {
  return list_keys([](FieldVisitor& v) {
    Motion motion;
    v.section("motion", motion, "a motion");
  });
}

TEST(KeyReference, FindsTheKeysThatExistOnlyForSomeValueOfAnother) {
  const std::vector<KeyRow> rows = motion_rows();
  std::vector<std::string> paths;
  for (const KeyRow& row : rows) paths.push_back(row.path);
  EXPECT_THAT(paths, testing::ElementsAre("motion.kind", "motion.profile", "motion.speed_m_s",
                                          "motion.ramp_s", "motion.range_px"));
  EXPECT_EQ(rows[0].condition, "");
  EXPECT_EQ(rows[1].condition, "kind: line");
  EXPECT_EQ(rows[3].condition, "kind: circle, or profile: constant");
}

TEST(KeyReference, GivesTypeUnitRangeAndDefault) {
  const std::vector<KeyRow> rows = motion_rows();
  EXPECT_EQ(rows[0].type, "word");
  EXPECT_EQ(rows[0].takes, "hold, line, circle");
  EXPECT_EQ(rows[0].default_value, "hold");
  EXPECT_EQ(rows[2].unit, "m/s");
  EXPECT_EQ(rows[2].takes, "in [0, 5]");
  EXPECT_EQ(rows[3].takes, "of at least 0");
  EXPECT_EQ(rows[4].type, "list of 2 numbers");
  EXPECT_EQ(rows[4].default_value, "[1, 2]");
}

TEST(KeyReference, TheUnitIsThatOfTheWholeEnding) {
  EXPECT_EQ(unit_of_key("image_motion_px_s"), "px/s");
  EXPECT_EQ(unit_of_key("var_x_px2"), "px²");
  EXPECT_EQ(unit_of_key("duration_s"), "s");
  EXPECT_EQ(unit_of_key("frames"), "");
}

TEST(KeyReference, ATableEscapesTheBarAndTheTextIsWrapped) {
  EXPECT_THAT(
      keys_as_markdown(motion_rows()),
      HasSubstr(
          "| `motion.range_px` | list of 2 numbers in [1, 255], px | `[1, 2]` | two radii \\| in order |\n"));
  const std::string text = keys_as_text(motion_rows(), 40);
  EXPECT_THAT(text, HasSubstr("motion.speed_m_s\n    mean speed\n    number, m/s in [0, 5]; default 0.1;\n"));
}

TEST(KeyReference, EveryKeyOfAResolvedDetectorIsListed) {
  for (const std::string& preset : built_in_detectors().names()) {
    const std::vector<KeyRow> rows = list_keys([&](FieldVisitor& v) {
      DetectorConfig config = built_in_detectors().config(preset);
      describe(v, config);
    });
    std::vector<std::string> paths;
    for (const KeyRow& row : rows) {
      paths.push_back(row.path);
      EXPECT_FALSE(row.doc.empty()) << preset << " " << row.path;
    }
    EXPECT_THAT(paths, Contains("radius_px"));
    EXPECT_THAT(paths, Contains("threshold"));
  }
}

TEST(KeyReference, UnitsComeFromTheEndOfAKey) {
  EXPECT_EQ(unit_of_key("speed_deg_s"), "deg/s");
  EXPECT_EQ(unit_of_key("duration_us"), "us");
  EXPECT_EQ(unit_of_key("threshold"), "");
}

}  // namespace
}  // namespace saccade
