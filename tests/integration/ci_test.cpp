// saccade test and saccade compare, and the workflow files that call them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <pugixml.hpp>
#include <string>

#include "config/yaml_tree.h"
#include "tests/integration/run_shell.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;

const std::string source = SACCADE_SOURCE_DIR;
const std::string binary = "'" SACCADE_BINARY "' ";
class TestCommand : public testing::Test {
 protected:
  [[nodiscard]] std::string out(const std::string& name) const { return (folder_ / name).string(); }
  /// A scenario of 0.03 s with these expectations.
  [[nodiscard]] std::string scenario(const std::string& name, const std::string& expect) const {
    return folder_
        .write(name + ".yaml",
               "name: " + name +
                   "\nrun: {duration_s: 0.03}\nlab: {density: 0}\nrender: {max_interval_ms: 5}\n"
                   "ball: {trajectory: {kind: waypoints, points_m: [[-0.5, -0.1, 0.3], [-0.5, 0.1, 0.3]], "
                   "speed_m_s: 0.1}}\n"
                   "detectors: {paper_full: {}}\ngaze: {detector: none}\noutput: {pictures: 0}\nexpect: " +
                   expect + "\n")
        .string();
  }
  [[nodiscard]] Outcome test(const std::string& arguments, const std::string& before = "") const {
    return run_shell(before + binary + "test " + arguments);
  }

  TempFolder folder_;
};

TEST_F(TestCommand, EveryExpectationIsATestCaseAndTheWorstResultIsTheExitStatus) {
  const std::string met = scenario("met", "{duration_s: [0.02, 0.04], gaze.moves: {at_most: 0}}");
  const std::string nothing = scenario("nothing", "{}");
  const std::string unmet = scenario("unmet", "{duration_s: {above: 0.03}, events.count: {at_least: 0}}");
  // gaze: none has no figures; the check of the scenario finds that before anything runs.
  const Outcome bad = test(met + " " + unmet + " --out " + out("bad"));
  EXPECT_EQ(bad.status, 2) << bad.text;
  EXPECT_THAT(bad.text, HasSubstr("gaze.moves: found no such figure"));
  EXPECT_FALSE(fs::exists(folder_ / "bad"));

  const std::string good = scenario("met", "{duration_s: [0.02, 0.04], events.count: {at_least: 0}}");
  const Outcome fine = test(good + " " + nothing + " --jobs 2 --out " + out("fine"));
  EXPECT_EQ(fine.status, 0) << fine.text;
  EXPECT_THAT(fine.text, HasSubstr("2 scenarios, 2 expectations: 2 met, 0 not met; 0 runs failed"));
  EXPECT_TRUE(fs::exists(folder_ / "fine/met/report.html") &&
              fs::exists(folder_ / "fine/nothing/metrics.json"));

  const Outcome outcome = test(good + " " + nothing + " " + unmet + " --jobs 2 --out " + out("all") +
                               " --junit " + out("junit.xml"));
  EXPECT_EQ(outcome.status, 3) << outcome.text;
  EXPECT_THAT(outcome.text, testing::ContainsRegex("unmet +duration_s +0.03 +above 0.03 +NOT MET"));
  pugi::xml_document junit;
  ASSERT_TRUE(junit.load_file(out("junit.xml").c_str()));
  const pugi::xml_node all = junit.child("testsuites");
  EXPECT_EQ(all.attribute("tests").as_int(), 5);
  EXPECT_EQ(all.attribute("failures").as_int(), 1);
  EXPECT_EQ(all.attribute("errors").as_int(), 0);
  const pugi::xml_node suite = all.find_child_by_attribute("testsuite", "name", "unmet");
  const pugi::xml_node failed = suite.find_child_by_attribute("testcase", "name", "duration_s");
  EXPECT_STREQ(failed.child("failure").attribute("message").value(),
               "duration_s is 0.03, expected above 0.03");
  EXPECT_FALSE(suite.find_child_by_attribute("testcase", "name", "events.count").first_child());
  EXPECT_TRUE(all.find_child_by_attribute("testsuite", "name", "nothing")
                  .find_child_by_attribute("testcase", "name", "runs to its end"));

  EXPECT_GT(suite.attribute("time").as_double(), 0.0);
  double time_s = 0.0;
  for (const pugi::xml_node& testcase : suite.children("testcase")) {
    EXPECT_GT(testcase.attribute("time").as_double(), 0.0);
    time_s += testcase.attribute("time").as_double();
  }
  EXPECT_NEAR(time_s, suite.attribute("time").as_double(), 0.002);
}

TEST_F(TestCommand, ReplacesWhatItMadeAndNothingElse) {
  const std::string file = scenario("mine", "{}");
  const std::string arguments = file + " --out " + out("all");
  ASSERT_EQ(test(arguments).status, 0);
  const Outcome again = test(arguments + " --set ball.diameter_m=0.08");
  EXPECT_EQ(again.status, 0) << again.text;
  EXPECT_THAT(bytes_of(folder_ / "all/mine/scenario.yaml"), HasSubstr("diameter_m: 0.08"));
  // A failure before the run leaves the folder of the run before.
  EXPECT_EQ(test(arguments + " --set render.backend=egl", "__EGL_VENDOR_LIBRARY_DIRS=/nonexistent ").status,
            1);
  EXPECT_EQ(test(arguments).status, 0);
  ASSERT_EQ(run_shell(binary + "run " + file + " --force --set ball.diameter_m=0.07 --out " + out("all/mine"))
                .status,
            0);
  const Outcome refused = test(arguments);
  EXPECT_EQ(refused.status, 2) << "another run is not replaced without --force";
  EXPECT_THAT(refused.text, HasSubstr("all/mine: found a folder that is not empty"));
  EXPECT_THAT(bytes_of(folder_ / "all/mine/scenario.yaml"), HasSubstr("diameter_m: 0.07"));
  EXPECT_EQ(test(arguments + " --force").status, 0);
}

TEST_F(TestCommand, RejectsAJunitFileThatCannotBeWrittenBeforeAnythingRuns) {
  const std::string file = scenario("mine", "{}");
  for (const std::string& junit : {out("nowhere/junit.xml"), out(".")}) {
    const Outcome outcome = test(file + " --out " + out("all") + " --junit " + junit);
    EXPECT_EQ(outcome.status, 2) << outcome.text;
    EXPECT_THAT(outcome.text, HasSubstr("--junit: found "));
    EXPECT_FALSE(fs::exists(folder_ / "all/mine"));
  }
  EXPECT_EQ(test(file + " --out " + out("all") + " --junit " + out("all/junit.xml")).status, 0);
}

TEST_F(TestCommand, StatesWhyARunFailed) {
  const std::string file = scenario("ended", "{duration_s: {above: 0}}");
  const std::string program =
      folder_.write("program", "#!/bin/sh\nread a; read b; echo ready 0.5; exit 3\n").string();
  fs::permissions(program, fs::perms::owner_all);
  const Outcome outcome = test(file + " --out " + out("all") + " --junit " + out("junit.xml") +
                               " --set detectors.mine.command=" + program);
  EXPECT_EQ(outcome.status, 1) << outcome.text;
  EXPECT_THAT(outcome.text,
              testing::ContainsRegex("RUN FAILED: detector mine: program ended at .* with status 3"));
  pugi::xml_document junit;
  ASSERT_TRUE(junit.load_file(out("junit.xml").c_str()));
  const pugi::xml_node testcase = junit.child("testsuites").child("testsuite").child("testcase");
  EXPECT_THAT(testcase.child("error").attribute("message").value(),
              HasSubstr("detector mine: program ended"));
  EXPECT_GT(testcase.attribute("time").as_double(), 0.0);
}

TEST_F(TestCommand, WritesTheTableAndTheJunitFileAfterAnInterrupt) {
  const std::string good = scenario("good", "{duration_s: {above: 0}}");
  const std::string endless = scenario("endless", "{duration_s: {above: 0}}");
  run_shell("sed -i 's/duration_s: 0.03/duration_s: 3600/' " + endless);
  const std::string command = "'" SACCADE_BINARY "' test " + good + " " + endless + " --jobs 2 --out " +
                              out("all") + " --junit " + out("junit.xml");
  const Outcome outcome =
      signal_when("grep -q 'good: 1 of 1 met' " + out("console"), "INT", command, out("console"));
  EXPECT_EQ(outcome.status, 1) << outcome.text;
  EXPECT_THAT(outcome.text, testing::ContainsRegex("endless .*RUN FAILED: interrupted"));
  EXPECT_THAT(outcome.text, HasSubstr("1 met, 1 not met; 1 run failed"));
  pugi::xml_document junit;
  ASSERT_TRUE(junit.load_file(out("junit.xml").c_str())) << outcome.text;
  EXPECT_EQ(junit.child("testsuites").attribute("tests").as_int(), 2);
  EXPECT_EQ(junit.child("testsuites").attribute("errors").as_int(), 1);
}

TEST_F(TestCommand, AFailedRunIsAnErrorOfEachOfItsTestCasesAndTheOthersRun) {
  const std::string good = scenario("good", "{duration_s: {above: 0}}");
  const std::string bad = scenario("bad", "{duration_s: {above: 0}, events.count: {at_least: 0}}");
  run_shell("sed -i 's/render: {/render: {backend: egl, /' " + bad);
  const Outcome outcome = test(good + " " + bad + " --out " + out("all") + " --junit " + out("junit.xml"),
                               "__EGL_VENDOR_LIBRARY_DIRS=/nonexistent ");
  EXPECT_EQ(outcome.status, 1) << outcome.text;
  EXPECT_THAT(outcome.text, HasSubstr("RUN FAILED"));
  EXPECT_THAT(outcome.text, HasSubstr("good: 1 of 1 met"));
  pugi::xml_document junit;
  ASSERT_TRUE(junit.load_file(out("junit.xml").c_str()));
  EXPECT_EQ(junit.child("testsuites").attribute("errors").as_int(), 2);
  EXPECT_EQ(junit.child("testsuites").attribute("failures").as_int(), 0);
}

TEST_F(TestCommand, TwoScenariosOfOneNameHaveFoldersOfTheirOwn) {
  const std::string file = scenario("twin", "{}");
  EXPECT_EQ(test(file + " " + file + " --seed 4 --out " + out("twins")).status, 0);
  EXPECT_TRUE(fs::exists(folder_ / "twins/twin/metrics.json") &&
              fs::exists(folder_ / "twins/twin-2/metrics.json"));
  EXPECT_THAT(bytes_of(folder_ / "twins/twin-2/scenario.yaml"), HasSubstr("seed: 4"));
}

TEST_F(TestCommand, TheScriptOfTheWorkflowFilesFindsAChangeAgainstTheBaseline) {
  const std::string script = "SACCADE='" SACCADE_BINARY "' " + source + "/examples/ci/check ";
  const std::string file = scenario("brief", "{duration_s: {above: 0}}");
  const Outcome first = run_shell(script + out("one") + " " + out("none") + " " + file);
  EXPECT_EQ(first.status, 0) << first.text;
  EXPECT_TRUE(fs::exists(folder_ / "one/junit.xml"));
  const Outcome same = run_shell(script + out("two") + " " + out("one") + " " + file);
  EXPECT_EQ(same.status, 0) << same.text;
  EXPECT_THAT(same.text, HasSubstr("equal within tolerance"));
  run_shell("sed -i 's/speed_m_s: 0.1/speed_m_s: 2/' " + file);
  const Outcome changed = run_shell(script + out("three") + " " + out("one") + " " + file);
  EXPECT_EQ(changed.status, 3) << changed.text;
  EXPECT_THAT(changed.text, HasSubstr("configuration of B: ball.trajectory.speed_m_s=2"));
}

TEST(WorkflowFiles, AreYamlAndCallTheScript) {
  for (const char* name : {"github.yml", "gitlab.yml"}) {
    const fs::path path = fs::path(source) / "examples/ci" / name;
    EXPECT_TRUE(read_yaml_file(path).problems.empty()) << name;
    EXPECT_THAT(bytes_of(path), HasSubstr("examples/ci/check results baseline scenarios/look_at_ball.yaml"))
        << name;
  }
}

}  // namespace
}  // namespace saccade
