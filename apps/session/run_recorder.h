#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "apps/config/scenario.h"
#include "evaluation/frame_camera/frame_detector.h"
#include "evaluation/report/overlay.h"
#include "evaluation/scoring/clutter.h"
#include "evaluation/scoring/gaze_scorer.h"
#include "evaluation/scoring/metrics.h"
#include "loop/loop.h"
#include "recording/event_file.h"
#include "recording/run_files.h"
#include "sim/sim_robot.h"

namespace saccade {

/// Writes the run folder of a simulated run while it goes on, and scores it at its end. The only place where
/// the loop's ticks and the simulator's truth meet.
class RunRecorder final : public LoopObserver {
 public:
  /// `robot` and `loop` outlive it. The folder exists; without one the run is scored and nothing is written.
  RunRecorder(std::optional<std::filesystem::path> folder, const Scenario& scenario, SimRobot& robot,
              const Loop& loop);

  void on_tick(const Tick& tick) override;
  /// Time spent here on pictures, video and the frame camera, which is not the loop's.
  [[nodiscard]] double picture_wall_s() const { return picture_wall_s_; }
  /// Closes every file and scores. `wall_s` is the loop's time, `settings` what the run was told otherwise than
  /// its scenario has it (Metrics::settings).
  Metrics finish(double wall_s, std::vector<std::pair<std::string, std::string>> settings);

 private:
  void record_tables(const Tick& tick);
  void record_right_eye(const Tick& tick);
  void record_labels(std::span<const Event> events);
  void take_pictures(const Tick& tick);
  void watch_frames(std::int64_t t_us);
  [[nodiscard]] GazeMetrics gaze_metrics(const Metrics& metrics) const;
  [[nodiscard]] RightEyeMetrics right_eye_metrics() const;
  void save_hough_spaces(std::int64_t t_us) const;
  [[nodiscard]] EyePicture eye_picture(const Tick& tick, const cv::Mat& grey) const;

  /// The files that grow with the run.
  struct Tables {
    Tables(const std::filesystem::path& folder, const Scenario& scenario, bool stereo);
    void commit();

    std::unique_ptr<EventWriter> events;
    TableWriter<JointsRow> joints;
    TableWriter<TruthRow> truth;
    TableWriter<DetectionRow> detections;
    TableWriter<GazeRow> gaze;
    TableWriter<EyeRow> eye;
    std::optional<TableWriter<LabelRow>> labels;
    std::optional<TableWriter<TruthRow>> truth_right;  // where the right eye sees, like those below
    std::optional<TableWriter<LabelRow>> labels_right;
    std::optional<TableWriter<DetectionRow>> detections_right;  // with a detector that looks through it
  };

  std::optional<std::filesystem::path> folder_;
  const Scenario& scenario_;
  SimRobot& robot_;
  const Loop& loop_;
  std::optional<Tables> tables_;  // with a folder
  struct RightEye {
    explicit RightEye(const GazeScoringConfig& scoring) : gaze_scorer(scoring) {}

    GazeScorer gaze_scorer;
    std::vector<TruthRow> truth;
    std::vector<DetectionRow> detections;
    std::int64_t detector_ns = 0;
    std::int64_t event_count = 0;
  };
  std::optional<RightEye> right_eye_;  // where it sees
  GazeScorer gaze_scorer_;
  ClutterCounter clutter_;
  std::vector<double> clutter_in_window_;  // per row of truth_; only with labels
  std::vector<TruthRow> truth_;
  std::vector<DetectionRow> detections_;
  std::vector<std::int64_t> detector_ns_;
  std::int64_t event_count_ = 0;  // of both eyes
  std::int64_t now_us_ = 0;
  std::vector<Event> recent_events_;  // of the last few ms, for pictures
  std::vector<std::int64_t> picture_times_us_;
  std::optional<VideoComposer> video_;
  std::optional<FrameDetector> frame_detector_;
  std::optional<Shutter> shutter_;
  double picture_wall_s_ = 0.0;
};

/// What was set that can change what is scored, by key; of several for one key the last. The duration belongs
/// to the run, the seed has a place of its own.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> settings_of(
    const std::vector<std::string>& assignments);

}  // namespace saccade
