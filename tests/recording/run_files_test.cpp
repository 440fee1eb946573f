#include "recording/run_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <string>

#include "core/error.h"
#include "core/random.h"
#include "head/head_model.h"
#include "recording/table_reference.h"
#include "tests/recording/temp_folder.h"

namespace saccade {
namespace {

using testing::HasSubstr;

/// Numbers of all sizes, some with no short decimal text.
class Numbers {
 public:
  double next() {
    const double mantissa = random_.uniform(-1.0, 1.0, 0, counter_);
    return std::ldexp(mantissa, static_cast<int>(random_.bits(1, counter_++) % 60) - 30);
  }
  template <class Vector>
  Vector vector() {
    return Vector::NullaryExpr([&] { return next(); });
  }
  Circle circle() { return {next(), next(), next()}; }

 private:
  RandomStream random_{7, "run_files_test"};
  std::uint64_t counter_ = 0;
};

template <class Row>
std::filesystem::path write_table(const std::filesystem::path& path, const std::vector<Row>& rows) {
  TableWriter<Row> writer(path);
  for (const Row& row : rows) writer.write(row);
  writer.commit();
  return path;
}

TEST(RunFiles, EveryTruthNumberReadsBackAsTheSameDouble) {
  TempFolder folder;
  Numbers numbers;
  std::vector<TruthRow> rows;
  for (int i = 0; i < 500; ++i) {
    rows.push_back({1000 * i, numbers.circle(), numbers.next(), numbers.vector<Eigen::Vector3d>()});
  }
  const auto read = read_table<TruthRow>(write_table(folder / "truth.csv", rows));
  ASSERT_EQ(read.size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ(read[i].t_us, rows[i].t_us);
    EXPECT_EQ(read[i].circle.x_px, rows[i].circle.x_px);
    EXPECT_EQ(read[i].circle.y_px, rows[i].circle.y_px);
    EXPECT_EQ(read[i].circle.r_px, rows[i].circle.r_px);
    EXPECT_EQ(read[i].visible, rows[i].visible);
    EXPECT_EQ(read[i].position_m, rows[i].position_m);
  }
}

constexpr const char* detections_header =
    "t_us,detector,x_px,y_px,r_px,score,held,var_x_px2,var_y_px2,var_r_px2,cov_xy_px2,cov_xr_px2,cov_yr_px2";

/// The first line of an empty table.
template <class Row>
std::string header_of(const TempFolder& folder) {
  const std::string text = bytes_of(write_table(folder / "table.csv", std::vector<Row>{}));
  return text.substr(0, text.find('\n'));
}

TEST(RunFiles, TheReferenceHasTheColumnsOfEachHeaderEachWithItsMeaning) {
  const TempFolder folder;
  std::string joints;
  for (const HeadJoint& joint : default_head()->joints) joints += "," + joint.name + "_rad";
  std::map<std::string, std::string> headers;
  for (const TableReference& table : run_tables()) {
    std::string header;
    for (const ColumnReference& column : table.columns) {
      EXPECT_FALSE(column.type.empty() || column.doc.empty()) << table.file << " " << column.name;
      header += column.name == "JOINT_rad" ? joints : (header.empty() ? "" : ",") + column.name;
    }
    EXPECT_TRUE(headers.emplace(table.file, header).second) << table.file;
  }
  const std::map<std::string, std::string> written = {{"truth.csv", header_of<TruthRow>(folder)},
                                                      {"target.csv", header_of<TargetRow>(folder)},
                                                      {"detections.csv", header_of<DetectionRow>(folder)},
                                                      {"streaming.csv", header_of<StreamingRow>(folder)},
                                                      {"gaze.csv", header_of<GazeRow>(folder)},
                                                      {"eye.csv", header_of<EyeRow>(folder)},
                                                      {"joints.csv", header_of<JointsRow>(folder)},
                                                      {"imu.csv", header_of<ImuRow>(folder)},
                                                      {"labels.csv", header_of<LabelRow>(folder)},
                                                      {"timing.csv", header_of<TimingRow>(folder)}};
  EXPECT_EQ(headers, written);
}

TEST(RunFiles, DetectionsReadBack) {
  TempFolder folder;
  DetectionRow known{1000, "best", {-1, 0.3, 12}, 1e-9, true};
  known.covariance_px2 << 1, 0.25, -0.5, 0.25, 2, 0.125, -0.5, 0.125, 3;
  const auto path = write_table<DetectionRow>(folder / "detections.csv",
                                              {{1000, "paper_full", {1.5, 2.25, 10}, 0.1, false}, known});
  EXPECT_EQ(bytes_of(path), std::string(detections_header) +
                                "\n1000,paper_full,1.5,2.25,10,0.1,0,,,,,,\n"
                                "1000,best,-1,0.3,12,1e-09,1,1,2,3,0.25,-0.5,0.125\n");
  const auto rows = read_table<DetectionRow>(path);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[1].detector, "best");
  EXPECT_EQ(rows[1].score, 1e-9);
  EXPECT_TRUE(rows[1].held);
  EXPECT_FALSE(rows[0].held);
  EXPECT_EQ(rows[0].covariance_px2, Eigen::Matrix3d::Zero());
  EXPECT_EQ(rows[1].covariance_px2, known.covariance_px2);
}

TEST(RunFiles, DetectionsMayLackHeldAndCovarianceAndHaveFurtherColumns) {
  TempFolder folder;
  folder.write("six.csv", "t_us,detector,x_px,y_px,r_px,score\n1000,mine,1,2,3,0.5\n");
  EXPECT_EQ(read_table<DetectionRow>(folder / "six.csv").at(0).score, 0.5);
  folder.write("seven.csv", "t_us,detector,x_px,y_px,r_px,score,held\n1000,mine,1,2,3,0.5,1\n");
  EXPECT_TRUE(read_table<DetectionRow>(folder / "seven.csv").at(0).held);
  folder.write("more.csv", "t_us,detector,x_px,y_px,r_px,score,held,speed\n1000,mine,1,2,3,0.5,1,fast\n");
  EXPECT_TRUE(read_table<DetectionRow>(folder / "more.csv").at(0).held);
  folder.write("part.csv", std::string(detections_header) + "\n1000,mine,1,2,3,0.5,1,1,1,1,0,0,\n");
  EXPECT_THROW((void)read_table<DetectionRow>(folder / "part.csv"), InputError);
  folder.write("five.csv", "t_us,detector,x_px,y_px,r_px\n1000,mine,1,2,3\n");
  EXPECT_THROW((void)read_table<DetectionRow>(folder / "five.csv"), InputError);
}

TEST(RunFiles, StreamingEstimatesReadBackAlsoAsDetections) {
  TempFolder folder;
  const auto path =
      write_table<StreamingRow>(folder / "streaming.csv", {{{2000, "best", {1, 2, 3}, 0.5, false}, 1000}});
  EXPECT_EQ(bytes_of(path), std::string(detections_header) + ",ready_us\n2000,best,1,2,3,0.5,0,,,,,,,1000\n");
  EXPECT_EQ(read_table<StreamingRow>(path).at(0).ready_us, 1000);
  EXPECT_EQ(read_table<DetectionRow>(path).at(0).t_us, 2000);
}

TEST(RunFiles, LabelsReadBack) {
  TempFolder folder;
  const auto path = write_table<LabelRow>(
      folder / "labels.csv",
      {{1000, 127, 0, true, "signal", "ball"}, {1000, 3, 99, false, "shot", "background"}});
  EXPECT_EQ(bytes_of(path),
            "t_us,x,y,p,cause,object\n"
            "1000,127,0,1,signal,ball\n"
            "1000,3,99,0,shot,background\n");
  const auto rows = read_table<LabelRow>(path);
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[1].x, 3);
  EXPECT_EQ(rows[1].y, 99);
  EXPECT_FALSE(rows[1].on);
  EXPECT_EQ(rows[1].cause, "shot");
  EXPECT_EQ(rows[0].object, "ball");
}

TEST(RunFiles, EyesReadBackAsTheSamePose) {
  TempFolder folder;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = Eigen::AngleAxisd(2.5, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
  pose.translation() = Eigen::Vector3d(-0.06, 0.03, 0.35);
  const auto path = write_table<EyeRow>(folder / "eye.csv", {EyeRow::of(1000, pose)});
  EXPECT_TRUE(bytes_of(path).starts_with("t_us,x_m,y_m,z_m,qw,qx,qy,qz\n1000,-0.06,0.03,0.35,"));
  EXPECT_TRUE(read_table<EyeRow>(path).at(0).root_from_left_cam().isApprox(pose, 1e-12));
}

TEST(RunFiles, GazeAndJointsReadBack) {
  TempFolder folder;
  Numbers numbers;
  const auto position_rad = [&] {  // of the joints that the head has
    const auto joints = static_cast<Eigen::Index>(default_head()->joints.size());
    JointVector position = JointVector::Zero();
    position.head(joints) = numbers.vector<JointVector>().head(joints);
    return position;
  };
  const GazeRow gaze{5, numbers.vector<Eigen::Vector3d>(), numbers.vector<Eigen::Vector3d>(), position_rad()};
  const auto gazes = read_table<GazeRow>(write_table<GazeRow>(folder / "gaze.csv", {gaze}));
  ASSERT_EQ(gazes.size(), 1u);
  EXPECT_EQ(gazes[0].fixation_m, gaze.fixation_m);
  EXPECT_EQ(gazes[0].target_m, gaze.target_m);
  EXPECT_EQ(gazes[0].position_rad, gaze.position_rad);

  const JointsRow joints{5, position_rad()};
  const auto path = write_table<JointsRow>(folder / "joints.csv", {joints});
  EXPECT_EQ(read_table<JointsRow>(path).at(0).position_rad, joints.position_rad);
  EXPECT_THAT(bytes_of(path), testing::StartsWith("t_us,torso_pitch_rad,torso_roll_rad,torso_yaw_rad,"
                                                  "neck_pitch_rad,neck_roll_rad,neck_yaw_rad,"
                                                  "eyes_tilt_rad,eyes_version_rad,eyes_vergence_rad\n"));
}

TEST(RunFiles, AValueThatDoesNotApplyIsEmptyInTheFileAndNanInTheRow) {
  TempFolder folder;
  const double nan = std::nan("");
  GazeRow row;
  row.target_m.setConstant(nan);
  const auto path = write_table<GazeRow>(folder / "gaze.csv", {row});
  EXPECT_THAT(bytes_of(path), HasSubstr("\n0,0,0,0,,,,0,"));
  EXPECT_TRUE(read_table<GazeRow>(path).at(0).target_m.array().isNaN().all());
}

TEST(RunFiles, AnnotatedTruthWithoutVisibilityAndPositionIsWhollyVisibleSomewhere) {
  TempFolder folder;
  const auto path = folder.write("t.csv", "t_us,x_px,y_px,r_px\r\n916454806,67.09,62.51,42.96\r\n");
  const TruthRow row = read_table<TruthRow>(path).at(0);
  EXPECT_EQ(row.t_us, 916454806);
  EXPECT_EQ(row.circle.r_px, 42.96);
  EXPECT_EQ(row.visible, 1.0);
  EXPECT_TRUE(row.position_m.array().isNaN().all());
}

TEST(RunFiles, AByteOrderMarkBeforeTheNamesIsSkippedInEveryTable) {
  TempFolder folder;
  const std::string mark = "\xEF\xBB\xBF";
  const auto truth = folder.write("t.csv", mark + "t_us,x_px,y_px,r_px\n5,1,2,3\n");
  EXPECT_EQ(read_table<TruthRow>(truth).at(0).t_us, 5);
  const auto detections =
      folder.write("d.csv", mark + "t_us,detector,x_px,y_px,r_px,score\n6,mine,1,2,3,0.5\n");
  EXPECT_EQ(read_table<DetectionRow>(detections).at(0).t_us, 6);
}

struct Mistake {
  std::string name;
  std::string content;
  std::string place;
  std::string value;
};

class BrokenTruth : public testing::TestWithParam<Mistake> {};

TEST_P(BrokenTruth, IsAnErrorWithItsLineAndColumn) {
  TempFolder folder;
  const auto path = folder.write("t.csv", GetParam().content);
  try {
    (void)read_table<TruthRow>(path);
    FAIL() << "read without complaint";
  } catch (const InputError& error) {
    ASSERT_EQ(error.problems().size(), 1u);
    EXPECT_EQ(error.problems()[0].place, path.string() + GetParam().place);
    EXPECT_EQ(error.problems()[0].value, GetParam().value);
  }
}

const std::string header = "t_us,x_px,y_px,r_px\n";
INSTANTIATE_TEST_SUITE_P(
    RunFiles, BrokenTruth,
    testing::Values(Mistake{"Empty", "", ":1", "nothing"},
                    Mistake{"OtherHeader", "t,x,y,r\n1,2,3,4\n", ":1", "t,x,y,r"},
                    Mistake{"NoHeader", "1,2,3,4\n", ":1", "1,2,3,4"},
                    Mistake{"ShortRow", header + "1,2,3,4\n2,2,3\n", ":3", "3 fields"},
                    Mistake{"LongRow", header + "1,2,3,4,5\n", ":2", "5 fields"},
                    Mistake{"EmptyLine", header + "\n1,2,3,4\n", ":2", "0 fields"},
                    Mistake{"Word", header + "1,2,three,4\n", ":2, column y_px", "three"},
                    Mistake{"Trailing", header + "1,2,3,4x\n", ":2, column r_px", "4x"},
                    Mistake{"Blank", header + "1, 2,3,4\n", ":2, column x_px", " 2"},
                    Mistake{"NotFinite", header + "1,nan,3,4\n", ":2, column x_px", "nan"},
                    Mistake{"NoTime", header + ",2,3,4\n", ":2, column t_us", "nothing"},
                    Mistake{"BrokenTime", header + "1.5,2,3,4\n", ":2, column t_us", "1.5"},
                    Mistake{"BackInTime", header + "5,2,3,4\n5,2,3,4\n4,2,3,4\n", ":4, column t_us", "4"}),
    [](const auto& mistake) { return mistake.param.name; });

TEST(RunFiles, AMissingTableAndAFolderAreNamedInTheError) {
  TempFolder folder;
  EXPECT_THAT([&] { (void)read_table<TruthRow>(folder / "none.csv"); },
              testing::ThrowsMessage<InputError>(HasSubstr("none.csv: found No such file")));
  EXPECT_THAT([&] { (void)read_table<TruthRow>(folder / ""); },
              testing::ThrowsMessage<InputError>(HasSubstr("a directory")));
}

TEST(RunFiles, RealAnnotationsAreRead) {
  const std::filesystem::path path =
      std::filesystem::path(SACCADE_SHARED_DATA) / "ball_looming_dvs128_aedat2.truth.csv";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "SKIPPED: real recordings are absent: " << path;
  const auto rows = read_table<TruthRow>(path);
  ASSERT_EQ(rows.size(), 176u);
  EXPECT_EQ(rows[0].t_us, 916454806);
  for (const TruthRow& row : rows) {
    EXPECT_GE(row.circle.r_px, 17.5);
    EXPECT_LE(row.circle.r_px, 43.1);
  }
}

}  // namespace
}  // namespace saccade
