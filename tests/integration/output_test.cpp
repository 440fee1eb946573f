// What becomes of output that cannot be written, of runs that a signal ends, and of mistyped words.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/integration/run_shell.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

const std::string scenario = SACCADE_SOURCE_DIR "/scenarios/look_at_ball.yaml";
const std::string program = "'" SACCADE_BINARY "' ";

class Output : public testing::Test {
 protected:
  [[nodiscard]] std::string at(const std::string& name) const { return (folder_ / name).string(); }
  void expect_lost(const std::string& arguments) const {
    const Outcome full = run_shell(program + arguments + " > /dev/full");
    EXPECT_EQ(full.status, 1) << arguments;
    EXPECT_THAT(full.text, HasSubstr("saccade: standard output: cannot be written")) << arguments;
  }

  TempFolder folder_;
};

TEST_F(Output, ThatCannotBeWrittenIsAFailureOfEveryCommandThatPrints) {
  folder_.write("events.csv", "t_us,x,y,p\n1000,3,4,1\n2000,3,5,0\n3000,4,5,0\n");
  folder_.write("truth.csv", "t_us,x_px,y_px,r_px\n2000,4,4,8\n");
  folder_.write("seen.csv", "t_us,detector,x_px,y_px,r_px,score\n2000,ring,4,4,8,0.5\n");
  for (const char* arguments : {"--help", "run --help", "--version", "keys", "keys lab"})
    expect_lost(arguments);
  expect_lost("info " + at("events.csv") + " --size 128x128");
  expect_lost("info " + at("events.csv") + " --size 128x128 --json");
  expect_lost("detect " + at("events.csv") + " --size 128x128");
  expect_lost("detect " + at("events.csv") + " --size 128x128 --json");
  expect_lost("score " + at("seen.csv") + " --truth " + at("truth.csv") + " --json");
  const Outcome closed = run_shell(program + "keys lab >&-");
  EXPECT_EQ(closed.status, 1);
  EXPECT_THAT(closed.text, HasSubstr("standard output: cannot be written"));
  EXPECT_EQ(run_shell(program + "keys lab > /dev/null").status, 0);
}

TEST_F(Output, BeyondTheLimitOfTheShellFailsWithAMessageThatNamesTheFile) {
  const Outcome run = run_shell("bash -c 'ulimit -f 40; exec " SACCADE_BINARY " run " + scenario +
                                " --set expect={} --set run.duration_s=2 --out " + at("run") + "'");
  EXPECT_EQ(run.status, 1) << run.text;
  EXPECT_THAT(run.text, HasSubstr("cannot be written: File too large"));
}

TEST_F(Output, OfARunWhoseTerminalHangsUpIsAReadableRunFolder) {
  const std::string console = at("console.txt");
  const Outcome run = signal_when(
      "grep -q 'x real time' " + console, "HUP",
      program + "run '" + scenario + "' --set expect={} --set run.duration_s=30 --out " + at("run"), console);
  EXPECT_EQ(run.status, 1) << run.text;
  const auto metrics = nlohmann::json::parse(bytes_of(folder_ / "run/metrics.json"));
  EXPECT_EQ(metrics["interrupted"], true);
  EXPECT_LT(metrics["duration_s"].get<double>(), 30.0);
  EXPECT_TRUE(fs::exists(folder_ / "run/report.html"));
  for (const auto& entry : fs::directory_iterator(folder_ / "run"))
    EXPECT_NE(entry.path().extension(), ".part");
}

TEST_F(Output, UnderNohupARunGoesOnAfterTheHangUp) {
  const std::string console = at("console.txt");
  const Outcome run = signal_when(
      "grep -q 'x real time' " + console, "HUP",
      "nohup " + program + "run '" + scenario + "' --set expect={} --set run.duration_s=1 --out " + at("run"),
      console);
  EXPECT_EQ(run.status, 0) << run.text;
}

TEST_F(Output, OfAKilledRunCanBeReportedAndDetectedOnAfterItsRepair) {
  const std::string console = at("console.txt");
  const Outcome killed = signal_when(
      "test $(stat -c %s " + at("run/detections.csv.part") + " || echo 0) -gt 200000", "KILL",
      program + "run '" + scenario + "' --set expect={} --set run.duration_s=60 --out " + at("run"), console);
  ASSERT_EQ(killed.status, 137) << killed.text;
  ASSERT_FALSE(fs::exists(folder_ / "run/metrics.json"));
  const Outcome refused = run_shell(program + "report " + at("run"));
  EXPECT_EQ(refused.status, 2);
  EXPECT_THAT(refused.text, HasSubstr("`saccade repair " + at("run") + "` makes one"));

  const Outcome repair = run_shell(program + "repair " + at("run"));
  EXPECT_THAT(repair.text, HasSubstr(at("run/report.html") + ": scored as far as its tables go"));
  const auto metrics = nlohmann::json::parse(bytes_of(folder_ / "run/metrics.json"));
  EXPECT_EQ(metrics["interrupted"], true);
  EXPECT_EQ(metrics["scenario"], "look_at_ball");
  const auto& own = metrics["detectors"]["paper_directed"];
  EXPECT_GT(own["chances"].get<int>(), 100);
  const Outcome report = run_shell(program + "report " + at("run"));
  EXPECT_EQ(report.status, 0) << report.text;
  const Outcome detect = run_shell(program + "detect " + at("run") + " --json 2>/dev/null");
  ASSERT_EQ(detect.status, 0) << detect.text;
  const auto again = nlohmann::json::parse(detect.text)["detectors"]["paper_directed"];
  EXPECT_NEAR(own["average_precision"].get<double>(), again["average_precision"].get<double>(), 0.1);
}

TEST(Words, ThatAreMistypedOnTheCommandLineHaveASuggestion) {
  const auto refused = [](const std::string& arguments, const std::string& message) {
    const Outcome outcome = run_shell(program + arguments);
    EXPECT_EQ(outcome.status, 2) << arguments;
    EXPECT_THAT(outcome.text, HasSubstr(message)) << arguments;
  };
  refused("rnu scene.yaml",
          "saccade: rnu: found an unknown command, expected a known command; did you mean run?");
  refused("zebra", "saccade: zebra: found an unknown command, expected one of run, detect, ");
  refused("run scene.yaml --sede 3",
          "saccade run: --sede: found an unknown option, expected a known option; did you "
          "mean --seed?");
  refused("calibrate run --out left.yaml --no_jonts", "did you mean --no-joints?");
  refused("guard robot.yaml --duration -1", "--duration: found -1, expected a number above 0\n");
  refused("guard robot.yaml --duration soon", "--duration: found soon, expected a number above 0\n");
  refused("label a.aedat4 --step-ms 0", "--step-ms: found 0, expected a number in [0.001, 1e+06]\n");
  refused("run '" + scenario + "' --set detectors.bset.threshold=0.5",
          "; did you mean the name best for the block?");
}

TEST(Words, OfOptionsTakeUnderscoresForHyphens) {
  const Outcome outcome =
      run_shell(program + "calibrate nowhere.aedat4 --no_joints --max_speed_px_s 60 --out a.yaml");
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.text, HasSubstr("nowhere.aedat4"));
  EXPECT_THAT(outcome.text, Not(HasSubstr("option")));
}

}  // namespace
}  // namespace saccade
