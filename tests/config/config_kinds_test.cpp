// Enumerations, fixed arrays, optional and named sections, and defaults that follow other keys.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Core>

#include "config/yaml_reader.h"
#include "config/yaml_tree.h"
#include "config/yaml_writer.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

enum class Shape { box, cylinder };
constexpr auto words_of(Shape) {
  return std::to_array<Word<Shape>>({{Shape::box, "box"}, {Shape::cylinder, "cylinder"}});
}

struct Body {
  Shape shape = Shape::box;
  Eigen::Vector3d size_m{1.0, 2.0, 3.0};
  double height_m = 0.5;
};

void describe(FieldVisitor& v, Body& body) {
  v.choice("shape", body.shape, "what it looks like");
  v.reals("size_m", body.size_m, {0.0, 10.0}, "its extent");
  v.when(body.shape == Shape::cylinder, "shape: cylinder", [&] {
    v.real("height_m", body.height_m, {0.0, 1.0}, "of the cylinder");
  });
}

struct Scene {
  double diameter_m = 1.0;
  double assumed_diameter_m = 0.0;
  std::vector<std::array<double, 2>> path_m = {{0.0, 0.0}};
  std::optional<Body> board;
  std::vector<std::pair<std::string, Body>> bodies;
  std::optional<std::string> file;
};

void describe(FieldVisitor& v, Scene& scene) {
  v.real("diameter_m", scene.diameter_m, {0.0, 10.0}, "of the ball");
  if (v.fills_defaults()) scene.assumed_diameter_m = scene.diameter_m;
  v.real("assumed_diameter_m", scene.assumed_diameter_m, {0.0, 10.0}, "of the ball, assumed");
  v.points("path_m", scene.path_m, {-1.0, 1.0}, "the path");
  v.optional_section("board", scene.board, "a board");
  v.named_sections("bodies", scene.bodies, "bodies by name", "a body");
  if (auto file = v.file("file", "another file")) scene.file = file;
}

Scene read(std::string_view yaml, const std::vector<std::string>& sets = {}) {
  YamlTree tree = parse_yaml(yaml, "a.yaml");
  for (const std::string& set : sets) set_value(tree, set);
  YamlReader reader(tree, {}, "folder");
  Scene scene;
  describe(reader, scene);
  reader.finish();
  return scene;
}

std::vector<std::string> problems_of(std::string_view yaml) {
  std::vector<std::string> lines;
  try {
    static_cast<void>(read(yaml));
  } catch (const InputError& error) {
    for (const Problem& problem : error.problems()) lines.push_back(problem.text());
  }
  return lines;
}

TEST(ConfigKinds, ReadAnEnumerationByItsWordAndVectorsOfFixedSize) {
  const Scene scene = read(
      "path_m: [[0, 0.5], [1, -1]]\n"
      "board: {shape: cylinder, size_m: [3, 2, 1], height_m: 0.25}\n");
  ASSERT_TRUE(scene.board.has_value());
  EXPECT_EQ(scene.board->shape, Shape::cylinder);
  EXPECT_EQ(scene.board->size_m, Eigen::Vector3d(3.0, 2.0, 1.0));
  EXPECT_EQ(scene.board->height_m, 0.25);
  EXPECT_THAT(scene.path_m, ElementsAre(std::array{0.0, 0.5}, std::array{1.0, -1.0}));
}

TEST(ConfigKinds, AnOptionalSectionIsAbsentUntilTheFileHasIt) {
  EXPECT_FALSE(read("diameter_m: 2").board.has_value());
  EXPECT_TRUE(read("board: {}").board.has_value());
  EXPECT_TRUE(read("diameter_m: 2", {"board.shape=box"}).board.has_value());
  EXPECT_THAT(
      problems_of("boards: {}"),
      ElementsAre(HasSubstr("boards: found an unknown key, expected a known key; did you mean board?")));
}

TEST(ConfigKinds, NamedSectionsKeepTheOrderOfTheFile) {
  const Scene scene = read("bodies:\n  table: {}\n  cup: {shape: cylinder}\n");
  ASSERT_EQ(scene.bodies.size(), 2u);
  EXPECT_EQ(scene.bodies[0].first, "table");
  EXPECT_EQ(scene.bodies[1].first, "cup");
  EXPECT_EQ(scene.bodies[1].second.shape, Shape::cylinder);
}

TEST(ConfigKinds, ANameWithACommaADotOrASlashIsRejected) {
  for (const char* name : {"a,b", "a.b", "../evil", "a b"}) {
    EXPECT_THAT(problems_of("bodies: {\"" + std::string(name) + "\": {}}"),
                ElementsAre(testing::AllOf(StartsWith("a.yaml:1: bodies." + std::string(name)),
                                           HasSubstr("letters, digits, _ and -"))));
  }
  EXPECT_THAT(problems_of("bodies: {" + std::string(65, 'a') + ": {}}"), testing::SizeIs(1));
  EXPECT_THAT(problems_of("bodies: {a_b-3: {}}"), ElementsAre());
}

TEST(ConfigKinds, ADefaultFollowsTheKeyItDependsOn) {
  EXPECT_EQ(read("diameter_m: 3").assumed_diameter_m, 3.0);
  EXPECT_EQ(read("diameter_m: 3\nassumed_diameter_m: 2").assumed_diameter_m, 2.0);
  Scene scene;
  scene.diameter_m = 3.0;
  scene.assumed_diameter_m = 2.0;
  EXPECT_THAT(write_config(scene), HasSubstr("assumed_diameter_m: 2\n"));
}

TEST(ConfigKinds, AFileIsRelativeToTheFolderOfTheFileThatNamesIt) {
  EXPECT_EQ(read("file: left.yaml").file, "folder/left.yaml");
  EXPECT_EQ(read("file: /left.yaml").file, "/left.yaml");
  EXPECT_EQ(read("diameter_m: 1", {"file=left.yaml"}).file, "left.yaml");
  EXPECT_THAT(problems_of("file: [1]"),
              ElementsAre("a.yaml:1: file: found a list, expected the name of a file"));
}

TEST(ConfigKinds, WhatIsWrittenReadsBackTheSame) {
  const std::string text =
      write_config(read("path_m: [[0, 0.5], [1, -1]]\n"
                        "board: {shape: cylinder, size_m: [3, 2, 1]}\n"
                        "bodies: {table: {size_m: [1, 1, 1]}}\n"));
  EXPECT_EQ(write_config(read(text)), text);
  EXPECT_THAT(text, HasSubstr("shape: cylinder\n"));
  EXPECT_THAT(text, HasSubstr("  - [0, 0.5]\n"));
}

TEST(ConfigKinds, WrongValuesNameKeyAndExpectation) {
  EXPECT_THAT(
      problems_of("board: {shape: round, size_m: [1, 2]}\npath_m: [[0, 2]]"),
      ElementsAre("a.yaml:1: board.shape: found round, expected one of box, cylinder",
                  "a.yaml:1: board.size_m: found a list of 2, expected a list of 3 finite numbers in [0, 10]",
                  "a.yaml:2: path_m[0][1]: found 2, expected a finite number in [-1, 1]"));
}

TEST(ConfigKinds, ACheckRejectsAnEnumerationWithoutAWordAndNumbersOutOfRange) {
  Body body;
  body.shape = static_cast<Shape>(7);
  body.size_m.y() = 11.0;
  try {
    check_config("body", body);
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()),
              "body.shape: found nothing, expected one of box, cylinder\n"
              "body.size_m: found 11, expected a finite number in [0, 10]");
  }
}

}  // namespace
}  // namespace saccade
