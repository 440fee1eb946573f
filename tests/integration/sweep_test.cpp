// saccade sweep: both engines, kills, failures, a full disk.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>

#include "tests/integration/run_shell.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::string source = SACCADE_SOURCE_DIR;
const std::string binary = "'" SACCADE_BINARY "' ";

class SweepCommand : public testing::Test {
 protected:
  [[nodiscard]] std::string out(const std::string& name) const { return (folder_ / name).string(); }
  /// The shortest runs that there are; `axes` indented by two.
  [[nodiscard]] std::string sweep_file(const std::string& axes, int worst = 0) const {
    return folder_
        .write("sweep.yaml",
               "name: tiny\nscenario: " + source +
                   "/scenarios/look_at_ball.yaml\n"
                   "set: {run.duration_s: 0.03, render.max_interval_ms: 5, lab.density: 0}\naxes:\n" +
                   axes + "report: {worst: " + std::to_string(worst) + "}\n")
        .string();
  }
  [[nodiscard]] Outcome sweep(const std::string& file, const std::string& name,
                              const std::string& options = "", const std::string& before = "") const {
    return run_shell(before + binary + "sweep '" + file + "' --out " + out(name) + " --csv " +
                     out(name + ".csv") + " " + options);
  }
  [[nodiscard]] std::string table(const std::string& name) const {
    return bytes_of(folder_ / (name + ".csv"));
  }

  TempFolder folder_;
};

TEST_F(SweepCommand, ASweepThatIsKilledTwiceAndContinuedHasTheTableOfAnUndisturbedOne) {
  const std::string file = sweep_file("  lab.clutter: [textured, rectilinear]\n  seed: {seeds: 3}\n", 1);
  const Outcome whole = sweep(file, "whole");
  ASSERT_EQ(whole.status, 0) << whole.text;
  EXPECT_EQ(std::ranges::count(table("whole"), '\n'), 7);
  const std::string page = bytes_of(folder_ / "whole/report.html");
  EXPECT_THAT(page, HasSubstr("6 runs of look_at_ball.yaml: 6 done"));

  const auto kill_after = [&](int results) {
    const std::string condition =
        "[ $(ls " + out("killed") + "/runs/*/metrics.json | wc -l) -ge " + std::to_string(results) + " ]";
    const std::string command = binary + "sweep '" + file + "' --jobs 1 --out " + out("killed");
    return signal_when(condition, "KILL", command, out("console.txt")).status;
  };
  EXPECT_NE(kill_after(1), 0);
  const Outcome status = run_shell(binary + "sweep --status " + out("killed"));
  EXPECT_EQ(status.status, 0) << status.text;
  EXPECT_THAT(status.text, HasSubstr("of 6 done"));
  EXPECT_THAT(status.text, HasSubstr("start it to continue"));
  EXPECT_NE(kill_after(3), 0);
  EXPECT_EQ(sweep(file, "killed").status, 0);
  EXPECT_EQ(table("killed"), table("whole"));

  const Outcome again = sweep(file, "whole");
  EXPECT_EQ(again.status, 0);
  EXPECT_THAT(again.text, HasSubstr("6 of them different; 6 have a result")) << "nothing is run twice";
}

TEST_F(SweepCommand, AFailingRunIsKeptWithItsLogAndDoesNotStopTheOthers) {
  const std::string file = sweep_file("  render.backend: [egl, osmesa]\n");
  const std::string no_egl = "__EGL_VENDOR_LIBRARY_DIRS=/nonexistent ";
  const Outcome outcome = sweep(file, "run", "", no_egl);
  EXPECT_EQ(outcome.status, 1) << outcome.text;
  EXPECT_THAT(outcome.text, HasSubstr("1 runs done, 1 failed"));
  EXPECT_THAT(table("run"), HasSubstr("failed,no OpenGL: "));
  const Outcome log = run_shell("cat " + out("run") + "/runs/*/log.txt");
  EXPECT_THAT(log.text, HasSubstr("EGL"));
  EXPECT_THAT(bytes_of(folder_ / "run/report.html"), HasSubstr("Failed runs"));
  EXPECT_EQ(sweep(file, "run", "--retry").status, 0) << "with EGL there, it is made again";
}

TEST_F(SweepCommand, AFullDiskStopsTheSweepAndItContinuesWhenThereIsRoom) {
#ifdef __SANITIZE_THREAD__
  GTEST_SKIP() << "the limit of a file's size ends programs with the thread sanitizer";
#endif
  const std::string file = sweep_file("  seed: {seeds: 3}\n");
  ASSERT_EQ(sweep(file, "whole").status, 0);
  // Files of at most 12 kB (24 blocks): the scenarios fit, the table does not.
  const Outcome full = sweep(file, "run", "", "trap '' XFSZ; ulimit -f 24; ");
  EXPECT_EQ(full.status, 1) << full.text;
  EXPECT_THAT(full.text, HasSubstr("goes on when there is room"));
  // And of 2 kB: neither does the result of a run, which says so to the engine and is no failure of the run.
  const std::string run = fs::directory_iterator(folder_ / "run/runs")->path().filename().string();
  const Outcome task =
      run_shell("trap '' XFSZ; ulimit -f 4; " + binary + "sweep-task " + out("run") + " " + run);
  EXPECT_EQ(task.status, 255) << task.text;
  EXPECT_FALSE(fs::exists(folder_ / "run/runs" / run / "failure.txt"));
  EXPECT_FALSE(fs::exists(folder_ / "run/runs" / run / "metrics.json"));
  EXPECT_EQ(sweep(file, "run").status, 0);
  EXPECT_EQ(table("run"), table("whole"));
}

TEST_F(SweepCommand, AnInvalidSweepLeavesNoFiles) {
  const std::string file = sweep_file("  lab.cluter: [textured]\n  lab.contrast: [1, 9]\n");
  const Outcome outcome = sweep(file, "run", "--engine cloud");
  EXPECT_EQ(outcome.status, 2);
  EXPECT_THAT(outcome.text, HasSubstr("lab.cluter"));
  EXPECT_THAT(outcome.text, HasSubstr("axes.lab.contrast: found 9"));
  EXPECT_THAT(outcome.text, HasSubstr("found cloud, expected one of local, slurm"));
  EXPECT_FALSE(fs::exists(folder_ / "run"));
  EXPECT_EQ(sweep(sweep_file("  seed: [1]\n"), "run", "--engine slurm", "PATH=/nonexistent ").status, 2);
}

TEST_F(SweepCommand, SlurmMakesTheSameTableAsThisMachineAlone) {
  const std::string file = sweep_file("  seed: {seeds: 6}\n");
  ASSERT_EQ(sweep(file, "local").status, 0);
  const Outcome outcome = sweep(file, "slurm", "--engine slurm --jobs 2 --batch 2",
                                "'" + source + "/tests/integration/with_slurm' " + out("daemons") + " ");
  constexpr int no_slurm = 77;
  if (outcome.status == no_slurm) {
    std::cerr << outcome.text;
    GTEST_SKIP() << "NOT TESTED: the engine slurm. " << outcome.text;
  }
  EXPECT_EQ(outcome.status, 0) << outcome.text << bytes_of(folder_ / "slurm/slurm.log");
  EXPECT_EQ(table("slurm"), table("local"));
  EXPECT_TRUE(fs::exists(folder_ / "slurm/slurm.sh")) << "the runs were made by Slurm";
}

}  // namespace
}  // namespace saccade
