#include "config/migrate.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/scenario.h"
#include "config/yaml_tree.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

const std::string old_scenario =
    "# Two people walk by.  \r\n"
    "name: old\r\n"
    "things:   # what else moves\n"
    "    walker: {shape: person,   rgb: [0.1, 0.2, 0.3]}\n"
    "    things: {shape: box}      # an object of that name\n"
    "\n"
    "run: {duration_s: 1}\n"
    "ball:\n"
    "  trajectory: {kind: hold, points_m: [[-0.5, 0, 0.347]]}\n"
    "detectors: {best: {}}\n"
    "# the end";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
  return text;
}

std::string message_of(const std::string& text) {
  try {
    static_cast<void>(migrate(text, "old.yaml"));
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Migrate, RenamesTheKeyAndKeepsEveryOtherByte) {
  const Migration migration = migrate(old_scenario, "old.yaml");
  EXPECT_EQ(migration.text, replaced(old_scenario, "things:   #", "objects:   #"));
  ASSERT_EQ(migration.renames.size(), 1u);
  EXPECT_EQ(migration.renames[0].line, 3);
  EXPECT_EQ(migration.renames[0].old_text, "things");
  EXPECT_EQ(migration.renames[0].new_text, "objects");
}

TEST(Migrate, AMigratedFileHasNothingLeftToRename) {
  const std::string once = migrate(old_scenario, "old.yaml").text;
  const Migration twice = migrate(once, "old.yaml");
  EXPECT_EQ(twice.text, once);
  EXPECT_TRUE(twice.renames.empty());
}

TEST(Migrate, FindsAKeyInQuotesInAFlowMapAndAfterLettersOfSeveralBytes) {
  EXPECT_EQ(migrate("\"things\": {a: {}}\n", "f").text, "\"objects\": {a: {}}\n");
  EXPECT_EQ(migrate("{name: a, 'things': {}}\n", "f").text, "{name: a, 'objects': {}}\n");
  EXPECT_EQ(migrate("{name: \xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80, things: {}}", "f").text,
            "{name: \xc3\xa9\xe2\x82\xac\xf0\x9f\x98\x80, objects: {}}");
  EXPECT_EQ(migrate("\xef\xbb\xbfthings: {}\n", "f").text, "\xef\xbb\xbfobjects: {}\n");
}

TEST(Migrate, RenamesThePathsOfASweep) {
  const std::string sweep =
      "name: s\n"
      "scenario: a.yaml\n"
      "set: {things.cup.size_m: [1, 1, 1], ball.diameter_m: 0.1}\n"
      "axes:\n"
      "  things.cup.trajectory.speed_m_s: {range: [0.1, 1], steps: 3}  # how fast\n"
      "  things: [{cup: {}}, {}]\n"
      "  scene:\n"
      "    cases:\n"
      "      empty: {things: null}\n"
      "      one: {things.cup.shape: box}\n"
      "except:\n"
      "  - {things.cup.trajectory.speed_m_s: {above: 0.5}}\n";
  const Migration migration = migrate(sweep, "s.yaml");
  EXPECT_EQ(migration.text, replaced(sweep, "things", "objects"));
  EXPECT_EQ(migration.renames.size(), 6u);
  EXPECT_EQ(migration.renames[1].new_text, "objects.cup.trajectory.speed_m_s");
}

TEST(Migrate, RejectsAnOldKeyBesideItsNewOneAndWhatIsNoYaml) {
  EXPECT_THAT(message_of("things: {}\nobjects: {}\n"),
              AllOf(HasSubstr("old.yaml:1: things"), HasSubstr("beside its new one, objects")));
  EXPECT_THAT(message_of("things: [\n"), HasSubstr("old.yaml"));
}

}  // namespace
}  // namespace saccade
