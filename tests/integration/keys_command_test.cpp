// saccade keys and saccade migrate, from the command line.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/integration/run_shell.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::AllOf;
using testing::HasSubstr;

Outcome saccade(const std::string& arguments) { return run_shell("'" SACCADE_BINARY "' " + arguments); }

std::string text_of_file(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

const std::string old_scenario =
    "name: old  # a comment\n"
    "run: {duration_s: 0.05}\n"
    "ball: {trajectory: {kind: hold}}\n"
    "things:\n"
    "  cup: {shape: cylinder}\n"
    "detectors: {best: {}}\n";

TEST(Keys, PrintsASectionWithTypeUnitRangeAndDefault) {
  const Outcome outcome = saccade("keys ball");
  EXPECT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_THAT(outcome.text,
              AllOf(HasSubstr("diameter_m\n"), HasSubstr("number, m in [0.03, 0.2]; default 0.095\n"),
                    HasSubstr("only with kind: circle")));
  EXPECT_THAT(saccade("keys emulator --markdown").text, HasSubstr("| `latency_us` | whole number in [0, "));
}

TEST(Keys, ListsTheSectionsAndNamesThemForAnUnknownOne) {
  for (const char* section :
       {"scenario", "gaze", "detectors.best", "emulator", "robot", "robot.yarp", "sweep"}) {
    EXPECT_THAT(saccade("keys").text, HasSubstr(section));
    EXPECT_EQ(saccade("keys " + std::string(section)).status, 0) << section;
  }
  EXPECT_THAT(saccade("keys truth.csv --markdown").text,
              AllOf(HasSubstr("| column | type | |\n|---|---|---|\n"),
                    HasSubstr("| `z_m` | number, m | the ball's centre, root frame |\n")));
  EXPECT_THAT(saccade("keys metrics.detectors").text, HasSubstr("precision\n    inliers / observations\n"));
  EXPECT_THAT(saccade("keys metrics.gaze").text,
              AllOf(HasSubstr("acquire_s\n"), testing::Not(HasSubstr("eye_movements"))));
  EXPECT_THAT(saccade("keys").text,
              HasSubstr("truth.csv                   table of a run folder, 8 columns\n"));
  const Outcome unknown = saccade("keys gase");
  EXPECT_EQ(unknown.status, 2);
  EXPECT_THAT(unknown.text,
              AllOf(HasSubstr("found gase, expected one of scenario, world, run,"), HasSubstr(", gaze,")));
}

TEST(Migrate, RewritesAnOldScenarioWhichRunsThen) {
  const TempFolder folder;
  const std::filesystem::path file = folder.write("old.yaml", old_scenario);
  const Outcome before = saccade("run " + file.string() + " --out " + (folder / "run").string());
  EXPECT_EQ(before.status, 2);
  EXPECT_THAT(before.text,
              AllOf(HasSubstr("old.yaml:4: things: found a key that was renamed, expected objects"),
                    HasSubstr("saccade migrate")));

  const Outcome outcome = saccade("migrate " + file.string());
  EXPECT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_THAT(outcome.text, AllOf(HasSubstr("old.yaml:4: things -> objects\n"), HasSubstr("old.yaml.bak")));
  EXPECT_EQ(text_of_file(folder / "old.yaml.bak"), old_scenario);
  std::string expected = old_scenario;
  expected.replace(expected.find("things"), 6, "objects");
  EXPECT_EQ(text_of_file(file), expected);
  EXPECT_THAT(saccade("migrate " + file.string()).text, HasSubstr("nothing to do"));
  const Outcome after = saccade("run " + file.string() + " --out " + (folder / "run").string());
  EXPECT_EQ(after.status, 0) << after.text;
}

TEST(Migrate, LeavesAFileAloneWhoseBackupExists) {
  const TempFolder folder;
  const std::filesystem::path file = folder.write("old.yaml", old_scenario);
  folder.write("old.yaml.bak", "precious");
  const Outcome outcome = saccade("migrate " + file.string());
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.text, HasSubstr("old.yaml.bak: found a file that exists"));
  EXPECT_EQ(text_of_file(file), old_scenario);
  EXPECT_EQ(text_of_file(folder / "old.yaml.bak"), "precious");
  EXPECT_EQ(saccade("migrate " + (folder / "gone.yaml").string()).status, 2);
}

TEST(Warnings, AreOnTheTerminalAndInTheLogOfTheRun) {
  const TempFolder folder;
  std::string text = old_scenario;
  text.replace(text.find("things"), 6, "objects");
  const std::filesystem::path file = folder.write("small_ball.yaml", text);
  const std::string warning = "warning: detectors.best.radius_px: the ball's radius in the image is ";
  const Outcome outcome =
      saccade("run " + file.string() + " --set ball.diameter_m=0.03 --out " + (folder / "run").string());
  EXPECT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_THAT(outcome.text, HasSubstr(warning));
  EXPECT_THAT(text_of_file(folder / "run/log.txt"), HasSubstr(warning));
}

}  // namespace
}  // namespace saccade
