// Objects, motions and rooms from files, through the command: what is wrong is one line, and nothing is written.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/integration/run_shell.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class OwnWorld : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_ / "files");
    for (const auto& file : fs::directory_iterator(std::string(SACCADE_SOURCE_DIR) + "/scenarios/assets"))
      fs::copy(file, folder_ / "files");
  }
  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  /// Runs a short scenario with these blocks from another working directory.
  [[nodiscard]] Outcome run(const std::string& blocks, const std::string& options = "") const {
    write("own.yaml", "name: own\nrun: {duration_s: 0.05}\n" + blocks +
                          "detectors: {best: {}}\ngaze: {detector: none}\n");
    return run_shell("cd / && '" SACCADE_BINARY "' run '" + (folder_ / "own.yaml").string() +
                     "' --set output.pictures=0 " + options + " --out '" + (folder_ / "run").string() + "'");
  }
  /// The message of a scenario that cannot run: one line.
  [[nodiscard]] std::string message(const std::string& blocks) const {
    const Outcome outcome = run(blocks);
    EXPECT_EQ(outcome.status, 2) << outcome.text;
    EXPECT_EQ(std::count(outcome.text.begin(), outcome.text.end(), '\n'), 1) << outcome.text;
    EXPECT_FALSE(fs::exists(folder_ / "run")) << "something was written";
    return outcome.text;
  }
  /// The same with a mesh, or an MJCF model, as object.
  [[nodiscard]] std::string object_message(const std::string& keys) const {
    return message("target: thing\nobjects:\n  thing: {" + keys +
                   ", trajectory: {kind: hold, points_m: [[-0.5, 0, 0.35]]}}\n");
  }
  [[nodiscard]] std::string table_message(const std::string& table) const {
    write("files/motion.csv", table);
    return message("ball: {trajectory: {kind: csv, file: files/motion.csv}}\n");
  }

  TempFolder folder_;
};

TEST_F(OwnWorld, TellsInOneLineWhatIsWrongWithAMesh) {
  EXPECT_THAT(object_message("mesh: files/gone.obj"),
              HasSubstr("files/gone.obj: expected a readable mesh file"));
  write("files/open.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n");
  EXPECT_THAT(object_message("mesh: files/open.obj"), HasSubstr("found 3 edges of one triangle"));
  write("files/fin.obj",
        "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nv 0 0 -0.1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\nf 1 2 "
        "5\nf 2 1 5\n");
  EXPECT_THAT(object_message("mesh: files/fin.obj"), HasSubstr("found 1 edges of three triangles or more"));
  EXPECT_THAT(object_message("mesh: files/football.obj, scale: 1000"), HasSubstr("found a mesh of 110 m"));
  EXPECT_THAT(object_message("mesh: files/mug.obj, texture: files/football.png"),
              HasSubstr("found no texture coordinates"));
  EXPECT_THAT(object_message("mesh: files/football.obj, texture: files/mug.obj"),
              HasSubstr("expected a PNG image"));
}

TEST_F(OwnWorld, TellsInOneLineWhatIsWrongWithAModel) {
  EXPECT_THAT(object_message("mjcf: files/gone.xml"),
              HasSubstr("files/gone.xml: expected a readable MJCF file"));
  write("files/lid.xml",
        "<mujoco><worldbody><body><joint name='lid'/><geom size='.1'/></body></worldbody></mujoco>");
  EXPECT_THAT(object_message("mjcf: files/lid.xml"),
              HasSubstr("files/lid.xml: found the hinge joint \"lid\""));
  write("files/broken.xml", "<mujoco><worldbody><geom size='x'/></worldbody></mujoco>");
  EXPECT_THAT(object_message("mjcf: files/broken.xml"), HasSubstr("expected a valid MJCF model"));
}

TEST_F(OwnWorld, TellsInOneLineWhatIsWrongWithARoom) {
  const std::string ball = "ball: {trajectory: {kind: hold}}\n";
  EXPECT_THAT(message(ball + "lab: {mjcf: files/gone.xml}\n"), HasSubstr("expected a readable MJCF file"));
  EXPECT_THAT(message(ball + "lab: {mjcf: files/mug.xml}\n"), HasSubstr("expected a lab without joints"));
  EXPECT_THAT(message(ball + "lab: {panorama: files/gone.png}\n"),
              HasSubstr("expected a readable PNG image"));
  write("files/text.png", "no image");
  EXPECT_THAT(message(ball + "lab: {panorama: files/text.png}\n"), HasSubstr("expected a PNG image"));
}

TEST_F(OwnWorld, TellsInOneLineWhatIsWrongWithATableOfAMotion) {
  const std::string start = "t_s,x_m,y_m,z_m\n0,-0.5,0,0.3\n";
  EXPECT_THAT(table_message(start + "2,-0.5,0,0.3\n"),
              HasSubstr("motion.csv:3: t_s: found 2 (line 2 is at 0)"));
  EXPECT_THAT(table_message(start + "-0.01,-0.5,0,0.3\n"), HasSubstr("expected a later time"));
  EXPECT_THAT(table_message(start + "0.01,nan,0,0.3\n"), HasSubstr("motion.csv:3: x_m: found \"nan\""));
  EXPECT_THAT(table_message("t_s,x_m,y_m,z_m,roll_deg,pitch_deg,yaw_deg\n"),
              HasSubstr("the column \"roll_deg\""));
}

TEST_F(OwnWorld, MeasuresTheVisibleExtentOfATargetThatIsNoSphere) {
  const Outcome outcome =
      run("target: mug\nobjects:\n  mug: {mjcf: files/mug.xml, trajectory: {kind: hold, points_m: [[-0.5, 0, "
          "0.35]]}}\n");
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  const auto metrics = nlohmann::json::parse(bytes_of(folder_ / "run/metrics.json"));
  EXPECT_TRUE(metrics["detectors"]["best"]["average_precision"].is_null());
  EXPECT_TRUE(metrics["detectors"]["best"]["precision"].is_null());
  EXPECT_TRUE(metrics["detectors"]["best"]["alarm_ratio"].is_null());
  std::ifstream table(folder_ / "run/target.csv");
  std::string line;
  std::getline(table, line);
  EXPECT_EQ(line, "t_us,x_px,y_px,left_px,top_px,width_px,height_px,visible");
  std::getline(table, line);
  double width_px = 0.0;
  double height_px = 0.0;
  double visible = 0.0;
  ASSERT_EQ(std::sscanf(line.c_str(), "%*d,%*f,%*f,%*f,%*f,%lf,%lf,%lf", &width_px, &height_px, &visible), 3)
      << line;
  // A mug of 95 mm at about 0.45 m; the camera has about 115 px per unit of tangent.
  EXPECT_GE(height_px, 20.0);
  EXPECT_LE(height_px, 30.0);
  EXPECT_GE(width_px, 16.0);
  EXPECT_EQ(visible, 1.0);
}

TEST_F(OwnWorld, KeepsTheCircleOfARoundMesh) {
  const Outcome outcome =
      run("target: football\nobjects:\n  football: {mesh: files/football.obj, trajectory: {kind: hold, "
          "points_m: [[-0.5, 0, 0.35]]}}\n");
  ASSERT_EQ(outcome.status, 0) << outcome.text;
  EXPECT_FALSE(fs::exists(folder_ / "run/target.csv"));
  const std::string truth = bytes_of(folder_ / "run/truth.csv");
  double r_px = 0.0;
  double visible = 0.0;
  ASSERT_EQ(std::sscanf(truth.c_str() + truth.find('\n'), "%*d,%*f,%*f,%lf,%lf", &r_px, &visible), 2);
  EXPECT_NEAR(r_px, 12.4, 1.0);
  EXPECT_GT(visible, 0.98) << "the mesh itself hides nothing of its sphere";
}

TEST_F(OwnWorld, IsRepeatedFromItsRunFolder) {
  ASSERT_EQ(run("lab: {mjcf: files/lab.xml}\nball: {hand: none, trajectory: {kind: ballistic}}\n").status, 0);
  const std::string again = "cd / && '" SACCADE_BINARY "' run '" + (folder_ / "run/scenario.yaml").string() +
                            "' --out '" + (folder_ / "again").string() + "'";
  ASSERT_EQ(run_shell(again).status, 0);
  for (const char* file : {"truth.csv", "events.aedat", "detections.csv"})
    EXPECT_EQ(bytes_of(folder_ / "run" / file), bytes_of(folder_ / "again" / file)) << file;
}

}  // namespace
}  // namespace saccade
