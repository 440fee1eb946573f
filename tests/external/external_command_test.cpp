// Detectors in programs of their own, in the commands.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/integration/run_shell.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;
using testing::Not;

const std::string source = SACCADE_SOURCE_DIR;
const std::string python_detector = source + "/examples/external/ring_mean_shift.py:RingMeanShift";
const std::string scenario = "'" + source +
                             "/examples/scenario/slow_line.yaml' --set run.duration_s=0.8 --set expect={} "
                             "--set output.pictures=1 ";

Outcome saccade(const std::string& arguments) { return run_shell("'" SACCADE_BINARY "' " + arguments); }

nlohmann::json metrics_of(const std::string& folder) {
  return nlohmann::json::parse(bytes_of(std::filesystem::path(folder) / "metrics.json"));
}

class ExternalCommand : public testing::Test {
 protected:
  [[nodiscard]] std::string out(const std::string& name) const { return (folder_ / name).string(); }
  /// A program that answers `ticks` ticks and then does `then`.
  [[nodiscard]] std::string program(int ticks, const std::string& then) const {
    const std::string path = out("program");
    std::ofstream(path)
        << "#!/bin/sh\nread a; read b; echo ready 0.5\nk=0\nwhile [ $k -lt " << ticks
        << " ] && read tick t count; do i=0; while [ $i -lt $count ]; do read e; i=$((i+1)); done; "
           "echo circle 64 64 10 0.9; k=$((k+1)); done\n"
        << then << "\n";
    ::chmod(path.c_str(), 0755);
    return path;
  }

  TempFolder folder_;
};

TEST_F(ExternalCommand, RunsDetectorsInPythonAndInCBesideTheOthersAndTwiceGivesTheSameBytes) {
  const std::string arguments = "run " + scenario + "--set detectors.mine.python='" + python_detector +
                                "' --set detectors.c.command='" SACCADE_RING_MEAN_SHIFT "' --out ";
  const Outcome run = saccade(arguments + out("run"));
  ASSERT_EQ(run.status, 0) << run.text;
  ASSERT_EQ(saccade(arguments + out("again")).status, 0);
  EXPECT_EQ(bytes_of(folder_ / "run" / "figures.json"), bytes_of(folder_ / "again" / "figures.json"));
  const auto detectors = metrics_of(out("run"))["detectors"];
  // The scenario has a ball before a plain wall; what the example finds there, and that both find the same.
  EXPECT_GT(detectors["mine"]["average_precision"].get<double>(), 0.2);
  EXPECT_NEAR(detectors["mine"]["average_precision"].get<double>(),
              detectors["c"]["average_precision"].get<double>(), 0.02);
  EXPECT_FALSE(detectors["mine"].contains("failure"));
  EXPECT_THAT(bytes_of(folder_ / "run" / "report.html"), HasSubstr("mine"));
  EXPECT_THAT(bytes_of(folder_ / "run" / "scenario.yaml"), HasSubstr("preset: command"));
}

TEST_F(ExternalCommand, DetectsInARecordingWithPathsRelativeToTheFileThatNamesThem) {
  ASSERT_EQ(saccade("run " + scenario + "--out " + out("run")).status, 0);
  const Outcome detect = saccade("detect " + out("run") + " --config '" + source +
                                 "/examples/external/detectors.yaml' --out " + out("detect"));
  ASSERT_EQ(detect.status, 0) << detect.text;
  EXPECT_TRUE(metrics_of(out("detect"))["detectors"].contains("mine"));
}

TEST_F(ExternalCommand, ANameIsSoughtInPathAndArgumentsAreRelativeToTheFileThatNamesTheProgram) {
  std::filesystem::create_directories(folder_ / "scene");
  folder_.write("scene/detector.sh",
                "read a; read b; echo ready 0.5\nread score < score.txt\n"
                "while read tick t count; do i=0; while [ $i -lt $count ]; do read e; i=$((i+1)); done; "
                "echo circle 64 64 10 $score; done\n");
  folder_.write("scene/score.txt", "0.75\n");
  const auto file =
      folder_.write("scene/scene.yaml",
                    "name: a\nrun: {duration_s: 0.1}\nlab: {density: 0}\n"
                    "ball: {trajectory: {kind: waypoints, points_m: [[-0.5, -0.1, 0.3], [-0.5, 0.1, 0.3]], "
                    "speed_m_s: 0.1}}\n"
                    "detectors: {mine: {command: sh, arguments: detector.sh}}\ngaze: {detector: none}\n"
                    "output: {pictures: 0}\n");
  const Outcome run = run_shell("cd / && '" SACCADE_BINARY "' run " + file.string() + " --out " + out("run"));
  ASSERT_EQ(run.status, 0) << run.text;
  EXPECT_THAT(bytes_of(folder_ / "run/detections.csv"), HasSubstr(",mine,64,64,10,0.75,"));
  // The resolved scenario is the same run from another folder.
  const Outcome again =
      run_shell("cd / && '" SACCADE_BINARY "' run " + out("run/scenario.yaml") + " --out " + out("again"));
  ASSERT_EQ(again.status, 0) << again.text;
  EXPECT_EQ(bytes_of(folder_ / "run/figures.json"), bytes_of(folder_ / "again/figures.json"));
  // From --set to the working directory.
  const Outcome from_set =
      run_shell("cd " + out("scene") + " && '" SACCADE_BINARY "' run " + source +
                "/examples/scenario/slow_line.yaml --set run.duration_s=0.05 --set expect={} --set "
                "'detectors.mine={command: sh, arguments: detector.sh}' --out " +
                out("set"));
  EXPECT_EQ(from_set.status, 0) << from_set.text;
  const Outcome absent =
      saccade("run " + file.string() + " --set detectors.mine.command=no_such_program --out " + out("x"));
  EXPECT_EQ(absent.status, 2);
  EXPECT_THAT(absent.text,
              HasSubstr("detectors.mine.command: found no_such_program, expected a file beside"));

  // What the program and its files hold is listed.
  const auto digest_of = [](const nlohmann::json& metrics, const std::string& name) {
    for (const auto& read : metrics["files"]) {
      if (read["file"] == name) return read["digest"].get<std::string>();
    }
    return std::string("not listed");
  };
  const auto before = nlohmann::json::parse(bytes_of(folder_ / "run/figures.json"));
  folder_.write("scene/score.txt", "0.5\n");
  ASSERT_EQ(saccade("run " + file.string() + " --out " + out("edited")).status, 0);
  const auto after = nlohmann::json::parse(bytes_of(folder_ / "edited/figures.json"));
  EXPECT_NE(digest_of(before, "score.txt"), "not listed") << before["files"];
  EXPECT_NE(digest_of(before, "score.txt"), digest_of(after, "score.txt"));
  EXPECT_EQ(digest_of(before, "detector.sh"), digest_of(after, "detector.sh"));
  const Outcome report = saccade("report " + out("run") + " " + out("edited") + " --out " + out("report"));
  EXPECT_EQ(report.status, 0) << report.text;
  EXPECT_THAT(report.text, Not(HasSubstr("repeats")));
}

TEST_F(ExternalCommand, ASweepMakesItsRunsAgainAfterTheDetectorsFileHasChanged) {
  folder_.write("mine.py",
                "class Mine:\n  def __init__(self, size): self.threshold = 0.5\n"
                "  def process(self, events, motion): pass\n  def estimate(self): return 64, 64, 10, 0.9\n");
  const auto file = folder_.write("sweep.yaml",
                                  "name: s\nscenario: look_at_ball\nset: {run.duration_s: 0.03, lab.density: "
                                  "0, render.max_interval_ms: 5, 'detectors.mine': {python: " +
                                      out("mine.py") + ":Mine}}\naxes: {seed: [1]}\nreport: {worst: 0}\n");
  const std::string sweep = "sweep " + file.string() + " --out " + out("sweep");
  EXPECT_EQ(saccade(sweep).status, 0);
  EXPECT_THAT(saccade(sweep).text, HasSubstr("1 have a result"));
  folder_.write("mine.py", bytes_of(folder_ / "mine.py") + "# another\n");
  const Outcome changed = saccade(sweep);
  EXPECT_EQ(changed.status, 0) << changed.text;
  EXPECT_THAT(changed.text, HasSubstr("0 have a result"));
}

class InterruptedCommand : public ExternalCommand {
 protected:
  /// The name of a detector that stops for a second after 100 ticks, when `mark` appears.
  [[nodiscard]] std::string pausing() const {
    const std::string path = out("pausing");
    std::ofstream(path)
        << "#!/bin/sh\nread a; read b; echo ready 0.5\nk=0\nwhile read tick t count; do i=0; while [ $i "
           "-lt $count ]; do read e; i=$((i+1)); done; k=$((k+1)); if [ $k -eq 100 ]; then : > '"
        << out("mark") << "'; sleep 1; fi; echo circle 64 64 10 0.9; done\n";
    ::chmod(path.c_str(), 0755);
    return path;
  }
  [[nodiscard]] Outcome interrupted(const std::string& arguments) const {
    return signal_when("[ -e " + out("mark") + " ]", "INT", "'" SACCADE_BINARY "' " + arguments,
                       out("console"));
  }
};

TEST_F(InterruptedCommand, DetectScoresWhatWasProcessedAndSaysSo) {
  ASSERT_EQ(saccade("run " + scenario + "--out " + out("run")).status, 0);
  const auto config = folder_.write(
      "detectors.yaml", "detectors:\n  paper_directed: {}\n  slow: {command: " + pausing() + "}\n");
  const Outcome outcome =
      interrupted("detect " + out("run") + " --config " + config.string() + " --out " + out("detect"));
  EXPECT_EQ(outcome.status, 1) << outcome.text;
  const auto metrics = metrics_of(out("detect"));
  EXPECT_EQ(metrics["interrupted"], true);
  const double duration_s = metrics["duration_s"].get<double>();
  EXPECT_LT(duration_s, 0.5);
  EXPECT_LE(metrics["detectors"]["slow"]["chances"].get<double>(), 1000.0 * duration_s + 2.0);
  EXPECT_GT(metrics["detectors"]["slow"]["chances"].get<int>(), 50);
  EXPECT_THAT(bytes_of(folder_ / "detect/report.html"), HasSubstr("This run was interrupted after 0.1"));
  EXPECT_THAT(outcome.text, HasSubstr("interrupted after 0.1"));
  const auto whole = metrics_of(out("run"));
  EXPECT_EQ(whole["interrupted"], false);
}

TEST_F(InterruptedCommand, RunSaysSo) {
  const Outcome outcome =
      interrupted("run " + scenario + "--set detectors.slow.command=" + pausing() + " --out " + out("run"));
  EXPECT_EQ(outcome.status, 1) << outcome.text;
  const auto metrics = metrics_of(out("run"));
  EXPECT_EQ(metrics["interrupted"], true);
  EXPECT_LT(metrics["duration_s"].get<double>(), 0.5);
  EXPECT_THAT(bytes_of(folder_ / "run/report.html"), HasSubstr("id=\"interrupted\""));
}

TEST_F(ExternalCommand, DrivesTheGaze) {
  const Outcome run =
      saccade("run " + scenario +
              "--set detectors.mine.command='" SACCADE_RING_MEAN_SHIFT "' --set gaze.detector=mine --out " +
              out("run"));
  ASSERT_EQ(run.status, 0) << run.text;
  EXPECT_EQ(metrics_of(out("run"))["gaze"]["detector"], "mine");
  EXPECT_GT(metrics_of(out("run"))["gaze"]["moves"].get<int>(), 0);
}

/// A gaze controller in the shell that answers `steps` questions with the neck at 0 and the eyes at 0.1 rad, and then does
/// `then`.
std::string controller_program(const TempFolder& folder, int steps, const std::string& then) {
  const std::string path = (folder / "controller").string();
  std::ofstream(path) << "#!/bin/sh\nread a; read b; echo ready\nk=0\nwhile [ $k -lt " << steps
                      << " ] && read question; do echo reference 0 0 0 0.1 0.1 0; k=$((k+1)); done\n"
                      << then << "\n";
  ::chmod(path.c_str(), 0755);
  return path;
}

TEST_F(ExternalCommand, AGazeControllerThatIsAProgramMovesTheHead) {
  const Outcome run = saccade(
      "run " + scenario + "--set gaze.detector=paper_directed --set gaze.controller=command " +
      "--set gaze.command.command='" + controller_program(folder_, 10'000, "") + "' --out " + out("run"));
  ASSERT_EQ(run.status, 0) << run.text;
  EXPECT_EQ(metrics_of(out("run"))["gaze"]["controller"], "command");
  EXPECT_FALSE(metrics_of(out("run"))["gaze"].contains("failure"));
  // The last row of the joints: neck at 0, tilt and version near 0.1 rad.
  const std::string joints = bytes_of(folder_ / "run" / "joints.csv");
  const std::string last = joints.substr(joints.rfind('\n', joints.size() - 2) + 1);
  double row[10] = {};
  std::size_t begin = 0;
  for (double& value : row) {
    value = std::stod(last.substr(begin));
    begin = last.find(',', begin) + 1;
  }
  for (const int joint : {4, 5, 6}) EXPECT_NEAR(row[joint], 0.0, 0.02) << joint;
  for (const int joint : {7, 8}) EXPECT_NEAR(row[joint], 0.1, 0.02) << joint;
}

TEST_F(ExternalCommand, AGazeControllerThatCrashesIsReportedAndTheHeadStays) {
  const Outcome run =
      saccade("run " + scenario + "--set gaze.detector=paper_directed --set gaze.controller=command " +
              "--set gaze.command.command='" + controller_program(folder_, 200, "kill -SEGV $$") +
              "' --out " + out("run"));
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.text, HasSubstr("gaze controller: controller ended at 0.2"));
  const auto metrics = metrics_of(out("run"));
  EXPECT_THAT(metrics["gaze"]["failure"].get<std::string>(), HasSubstr("by signal 11"));
  EXPECT_GT(metrics["detectors"]["paper_directed"]["observations"].get<int>(), 0);
  EXPECT_THAT(bytes_of(folder_ / "run" / "report.html"), HasSubstr("gaze controller ended before the end"));
  EXPECT_THAT(bytes_of(folder_ / "run" / "log.txt"), HasSubstr("gaze controller: controller ended"));
}

TEST_F(ExternalCommand, ACrashIsReportedAndChangesNothingElse) {
  ASSERT_EQ(saccade("run " + scenario + "--out " + out("without")).status, 0);
  const Outcome run = saccade("run " + scenario + "--set detectors.mine.command='" +
                              program(300, "kill -SEGV $$") + "' --out " + out("run"));
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.text, testing::ContainsRegex("detector mine: program ended at 0\\.[0-9]+ s, by signal 11"));
  const auto with = metrics_of(out("run"))["detectors"], without = metrics_of(out("without"))["detectors"];
  EXPECT_THAT(with["mine"]["failure"].get<std::string>(), HasSubstr("by signal 11"));
  for (const char* figure : {"average_precision", "observations", "pr_curve"})
    EXPECT_EQ(with["paper_directed"][figure], without["paper_directed"][figure]) << figure;
  EXPECT_EQ(bytes_of(folder_ / "run" / "events.aedat"), bytes_of(folder_ / "without" / "events.aedat"));
  EXPECT_THAT(bytes_of(folder_ / "run" / "report.html"), HasSubstr("mine ended before the end of the run"));
  EXPECT_THAT(bytes_of(folder_ / "run" / "log.txt"), HasSubstr("detector mine: program ended"));
}

TEST_F(ExternalCommand, AHangEndsTheDetectorAfterItsLimit) {
  const Outcome run =
      saccade("run " + scenario + "--set detectors.mine='{command: \"" + program(100, "exec sleep 600") +
              "\", answer_limit_s: 0.2}' --out " + out("run"));
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.text, testing::ContainsRegex("gave no answer at 0\\.[0-9]+ s within 200 ms"));
  EXPECT_GT(metrics_of(out("run"))["detectors"]["paper_directed"]["observations"].get<int>(), 0);
}

TEST_F(ExternalCommand, AClassInPythonBehindASocketGivesTheFiguresOfTheSameClassBehindAPipe) {
  const std::string socket = out("worker.sock");
  // The worker ends with the shell's command.
  const std::string worker =
      "/usr/bin/python3 '" SACCADE_WORKER "' --listen '" + socket + "' '" + python_detector + "' & ";
  const std::string arguments = "run " + scenario + "--set detectors.mine.";
  const Outcome over_pipe = saccade(arguments + "python='" + python_detector + "' --out " + out("pipe"));
  ASSERT_EQ(over_pipe.status, 0) << over_pipe.text;
  const Outcome over_socket =
      run_shell(worker + "worker=$!; '" SACCADE_BINARY "' " + arguments + "socket='" + socket + "' --out " +
                out("socket") + "; status=$?; kill $worker; wait $worker; exit $status");
  ASSERT_EQ(over_socket.status, 0) << over_socket.text;
  EXPECT_EQ(metrics_of(out("socket"))["detectors"]["mine"]["pr_curve"],
            metrics_of(out("pipe"))["detectors"]["mine"]["pr_curve"]);
  EXPECT_GT(metrics_of(out("socket"))["detectors"]["mine"]["average_precision"].get<double>(), 0.2);
}

struct RobotCase {
  const char* name;
  const char* driver;
  const char* then;  ///< what the program does after 20 ticks
  const char* why;
};
void PrintTo(const RobotCase& c, std::ostream* out) { *out << c.name; }

class ExternalOnARobot : public ExternalCommand, public testing::WithParamInterface<RobotCase> {};

TEST_P(ExternalOnARobot, IsReportedWhereItFailsWhileTheHeadIsActiveAndTheRunGoesOn) {
  // Watchdog times that a busy machine keeps, and a detector beside it that is cheap with sanitizers too: while a tick is
  // late, only the driving detector is asked.
  const std::string patient =
      " --set deploy.watchdog.safe_within_ms=1000 --set deploy.watchdog.tick_late_ms=490 --set "
      "deploy.watchdog.camera_silent_ms=500 --set deploy.watchdog.joints_stale_ms=500 --set "
      "deploy.watchdog.hang_ms=480 ";
  const Outcome deployed =
      saccade("deploy '" + source + "/scenarios/robots/practice.yaml' --activate --duration 1.5 --set " +
              "deploy.guard=none --set practice.head=test_" + std::to_string(::getpid()) + patient +
              "--set detectors='{paper_directed: {}, mine: {command: \"" + program(20, GetParam().then) +
              "\", answer_limit_s: 0.2}}' --set gaze.detector=" + GetParam().driver + " --out " + out("run"));
  EXPECT_EQ(deployed.status, 1) << deployed.text;
  const std::string message = std::string("detector mine: program ") + GetParam().why;
  EXPECT_THAT(deployed.text, testing::ContainsRegex(message));
  EXPECT_THAT(bytes_of(folder_ / "run" / "log.txt"), testing::ContainsRegex(message));
  EXPECT_THAT(bytes_of(folder_ / "run" / "report.html"), HasSubstr("mine ended before the end of the run"));
  const auto facts = nlohmann::json::parse(bytes_of(folder_ / "run" / "deploy.json"));
  ASSERT_EQ(facts["ended"].size(), 1u) << facts["ended"];
  EXPECT_EQ(facts["ended"][0]["what"], "detector mine");
  EXPECT_EQ(facts["states"].back()["cause"], "the run is over") << "nothing stopped the head before";
  const auto detectors = metrics_of(out("run"))["detectors"];
  EXPECT_TRUE(detectors["mine"].contains("failure"));
  EXPECT_FALSE(detectors["paper_directed"].contains("failure"));
  EXPECT_GT(detectors["paper_directed"]["observations"].get<int>(), 0);
}

INSTANTIATE_TEST_SUITE_P(
    ExternalCommand, ExternalOnARobot,
    testing::Values(RobotCase{"besideEnds", "paper_directed", "exit 3", "ended at [0-9.]+ s, with status 3"},
                    RobotCase{"besideHangs", "paper_directed", "exec sleep 600",
                              "gave no answer at [0-9.]+ s within 200 ms"},
                    RobotCase{"besideAnswersNonsense", "paper_directed",
                              "read question; echo hello; exec sleep 600", "answered `hello`"},
                    RobotCase{"drivingEnds", "mine", "kill -SEGV $$", "ended at [0-9.]+ s, by signal 11"},
                    RobotCase{"drivingHangs", "mine", "exec sleep 600",
                              "gave no answer at [0-9.]+ s within 200 ms"}),
    [](const auto& tried) { return tried.param.name; });

TEST_F(ExternalCommand, MistakesInTheFileAreReportedAsOthersAre) {
  Outcome run = saccade("run " + scenario + "--set detectors.mine.python=absent.py --out " + out("a"));
  EXPECT_EQ(run.status, 2);
  EXPECT_THAT(run.text, HasSubstr("FILE.py:CLASS"));
  run = saccade("run " + scenario + "--set detectors.mine.command=/absent --out " + out("b"));
  EXPECT_EQ(run.status, 2);
  EXPECT_THAT(run.text, HasSubstr("a file that exists"));
  run = saccade("run " + scenario + "--set detectors.mine='{command: /absent, radius_px: [4, 25]}' --out " +
                out("c"));
  EXPECT_EQ(run.status, 2);
  EXPECT_THAT(run.text, HasSubstr("detectors.mine.radius_px"));
}

TEST_F(ExternalCommand, AnErrorInAClassInPythonIsInTheMessageWithItsLine) {
  folder_.write(
      "mine.py",
      "class Raises:\n    threshold = 0.5\n    def __init__(self, size):\n        self.gain = 1 / 0\n"
      "class Ends:\n    threshold = 0.5\n    def __init__(self, size): pass\n"
      "    def process(self, events, motion): pass\n    def estimate(self):\n        return self.circle\n");
  folder_.write("torn.py", "class Torn(:\n");
  const auto run = [&](const std::string& detector) {
    return saccade("run " + scenario + "--set run.duration_s=0.05 --force --set detectors.mine.python='" +
                   out(detector) + "' --out " + out("run"));
  };
  Outcome outcome = run("mine.py:Raise");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.text,
              HasSubstr("detectors.mine: detector mine.py:Raise failed at its start: AttributeError: module "
                        "'own' has no attribute 'Raise'"));
  outcome = run("mine.py:Raises");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_THAT(outcome.text,
              HasSubstr("failed at its start: ZeroDivisionError: division by zero (mine.py, line 4)"));
  EXPECT_THAT(run("torn.py:Torn").text, HasSubstr("SyntaxError: invalid syntax (torn.py, line 1)"));
  outcome = run("mine.py:Ends");
  EXPECT_THAT(outcome.text,
              HasSubstr("AttributeError: 'Ends' object has no attribute 'circle' (mine.py, line 10)"));
}

TEST_F(ExternalCommand, AProgramThatCannotBeStartedIsNamedWithItsKey) {
  Outcome run = saccade("run " + scenario + "--set detectors.mine.command=/absent --out " + out("a"));
  EXPECT_EQ(run.status, 2);
  EXPECT_THAT(run.text, HasSubstr("detectors.mine.command: found /absent, expected a file that exists"));
  run = saccade("run " + scenario + "--set detectors.mine.command=/etc/passwd --out " + out("b"));
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.text, HasSubstr("detectors.mine: cannot start /etc/passwd"));
  const std::string controller = "--set gaze.controller=command --set gaze.command.command=";
  run = saccade("run " + scenario + controller + "/absent --out " + out("c"));
  EXPECT_EQ(run.status, 2);
  EXPECT_THAT(run.text, HasSubstr("gaze.command.command: found /absent, expected a file that exists"));
  run = saccade("run " + scenario + controller + "/etc/passwd --out " + out("d"));
  EXPECT_EQ(run.status, 1);
  EXPECT_THAT(run.text, HasSubstr("gaze.controller: cannot start /etc/passwd"));
}

}  // namespace
}  // namespace saccade
