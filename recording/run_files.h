#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/camera.h"
#include "head/head_state.h"
#include "head/imu_reading.h"
#include "recording/output_file.h"

namespace saccade {

/// The tables of a run folder (docs/run_folder.md): one row struct, one writer and one reader each. Numbers
/// are written as the shortest decimal text that reads back as the same double, so the same run gives the
/// same bytes. A field that does not apply is empty in the file and NaN in the struct.

/// truth.csv: t_us,x_px,y_px,r_px,visible,x_m,y_m,z_m. The true circle (docs/scoring.md), the share of
/// the ball's disc that is inside the image and not hidden, and the ball's centre in the root frame.
struct TruthRow {
  std::int64_t t_us = 0;
  Circle circle;
  double visible = 0.0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
};

/// target.csv: t_us,x_px,y_px,left_px,top_px,width_px,height_px,visible. Where the target is no sphere: the mean of its pixels that are seen
/// in the left eye's newest image, the box around them, and the share of its pixels that nothing hides. Empty fields: nothing
/// is seen.
struct TargetRow {
  std::int64_t t_us = 0;
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d corner_px = Eigen::Vector2d::Zero();  ///< centre of the box's top left pixel
  Eigen::Vector2d size_px = Eigen::Vector2d::Zero();
  double visible = 0.0;
};

/// detections.csv: t_us,detector,x_px,y_px,r_px,score,held, then the covariance of x, y and r:
/// var_x_px2,var_y_px2,var_r_px2,cov_xy_px2,cov_xr_px2,cov_yr_px2, all empty where it is unknown.
struct DetectionRow {
  std::int64_t t_us = 0;
  std::string detector;
  Circle circle;
  double score = 0.0;
  bool held = false;
  Eigen::Matrix3d covariance_px2 = Eigen::Matrix3d::Zero();  ///< of (x, y, r), px^2; zero: unknown
};

/// streaming.csv: the columns of detections.csv, then ready_us. `t_us` is the instant that the estimate answers, `ready_us`
/// the time from which on it could be used, not after t_us.
struct StreamingRow : DetectionRow {
  std::int64_t ready_us = 0;
};

/// gaze.csv: t_us, fixation point and target (m, root frame; empty when there is none), joint angles (rad)
/// under the names of the head's joints with the suffix _rad.
/// Columns: t_us,fixation_x_m,fixation_y_m,fixation_z_m,target_x_m,target_y_m,target_z_m,torso_pitch_rad,...,
/// eyes_vergence_rad for an iCub. One row per tick.
struct GazeRow {
  std::int64_t t_us = 0;
  Eigen::Vector3d fixation_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d target_m = Eigen::Vector3d::Zero();
  JointVector position_rad = JointVector::Zero();
};

/// eye.csv: t_us,x_m,y_m,z_m,qw,qx,qy,qz. Where the left camera truly is and looks (root_from_left_cam: its centre, and
/// its turn as a unit quaternion). Truth; one row per tick.
struct EyeRow {
  std::int64_t t_us = 0;
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();
  Eigen::Vector4d turn_wxyz = {1.0, 0.0, 0.0, 0.0};

  [[nodiscard]] static EyeRow of(std::int64_t t_us, const Eigen::Isometry3d& root_from_left_cam);
  [[nodiscard]] Eigen::Isometry3d root_from_left_cam() const;
};

/// joints.csv: t_us and the measured joint positions (rad), under the names of the head's joints with _rad.
struct JointsRow {
  std::int64_t t_us = 0;
  JointVector position_rad = JointVector::Zero();
};

/// imu.csv: t_us,measured_us,wx_rad_s,wy_rad_s,wz_rad_s,ax_m_s2,ay_m_s2,az_m_s2. The newest reading of the inertial measurement
/// unit at t_us, as ImuReading has it; measured_us is the reading's own time. One row per tick.
struct ImuRow {
  std::int64_t t_us = 0;
  ImuReading reading;
};

/// timing.csv: what a stretch of a deployed run's ticks took and left out; columns named as the members. `state` as
/// DeployState has it at the end; largest lateness of a tick; time in it and from the newest event to the command, mean
/// and largest, empty where there was none; events that came and of them left out, evaluations of detectors left out,
/// events that waited at the end, and those that the camera's connection dropped.
struct TimingRow {
  std::int64_t t_us = 0;
  std::string state;
  std::int64_t ticks = 0;
  std::int64_t missed = 0;
  std::int64_t late_max_us = 0;
  double tick_mean_us = 0.0;
  std::int64_t tick_max_us = 0;
  double latency_mean_us = 0.0;
  double latency_max_us = 0.0;
  std::int64_t events = 0;
  std::int64_t events_left_out = 0;
  std::int64_t skipped = 0;
  std::int64_t queued = 0;
  std::int64_t dropped = 0;
};

/// labels.csv: t_us,x,y,p,cause,object. One row per event of the events' file, in its order. `p` is 1 for brighter;
/// `cause` is signal, leak, shot or hot; `object` is ball, hand, arm, distractor or background. Truth.
struct LabelRow {
  std::int64_t t_us = 0;
  std::int64_t x = 0;
  std::int64_t y = 0;
  bool on = false;
  std::string cause;
  std::string object;
};

/// Writes rows one by one (streaming: memory does not grow with the run); the file appears on commit().
template <class Row>
class TableWriter {
 public:
  /// `head`: whose joints a table of joints has.
  explicit TableWriter(std::filesystem::path path, std::shared_ptr<const HeadModel> head = default_head());
  void write(const Row& row);
  /// Puts the rows so far on the disk: OutputFile::sync().
  void sync();
  void commit();

 private:
  std::shared_ptr<const HeadModel> head_;
  OutputFile file_;
  std::string line_;
};

/// Reads a table row by row, in fixed memory. Throws InputError with file, line and column for a missing
/// file, a wrong header, a row of the wrong length, a value that is not a number, or time that goes back.
/// Columns at the right end of some tables may be absent: of truth `visible,x_m,y_m,z_m` (annotated recordings: visible =
/// 1, position NaN), of detections the covariance, or `held` and the covariance. Tables of detections may have further
/// columns on the right, which are skipped. Joints go into the slots that head_of_names() gives their names.
template <class Row>
class TableReader {
 public:
  explicit TableReader(const std::filesystem::path& path);
  [[nodiscard]] std::optional<Row> next();  ///< none at the end

 private:
  bool next_line();
  [[nodiscard]] std::string place() const;

  std::string name_;
  std::ifstream in_;
  std::string line_;
  std::size_t line_number_ = 0;
  std::shared_ptr<const HeadModel> head_ = default_head();  ///< of the columns
  std::size_t columns_ = 0;                                 ///< fields of a row
  std::size_t known_ = 0;  ///< of them those that go into a Row; the others are to their right
  std::int64_t last_t_us_ = std::numeric_limits<std::int64_t>::min();
};

/// A whole table at once; throws as TableReader does.
template <class Row>
[[nodiscard]] std::vector<Row> read_table(const std::filesystem::path& path);

extern template class TableWriter<TruthRow>;
extern template class TableWriter<TargetRow>;
extern template class TableWriter<DetectionRow>;
extern template class TableWriter<StreamingRow>;
extern template class TableWriter<GazeRow>;
extern template class TableWriter<JointsRow>;
extern template class TableWriter<EyeRow>;
extern template class TableWriter<ImuRow>;
extern template class TableWriter<LabelRow>;
extern template class TableWriter<TimingRow>;
extern template class TableReader<TruthRow>;
extern template class TableReader<DetectionRow>;
extern template class TableReader<StreamingRow>;
extern template class TableReader<GazeRow>;
extern template class TableReader<JointsRow>;
extern template class TableReader<EyeRow>;
extern template class TableReader<ImuRow>;
extern template class TableReader<LabelRow>;
extern template class TableReader<TimingRow>;

}  // namespace saccade
