#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "session/frame_camera.h"
#include "session/ground_truth.h"
#include "session/ground_truth_recorder.h"
#include "session/observations.h"
#include "session/run_pictures.h"
#include "session/run_scores.h"
#include "session/run_tables.h"
#include "session/scene_recorder.h"

namespace saccade {

/// Records a simulated run: frame camera, tables, scores and images, which are observers of their own. The only place
/// where the loop's ticks and the simulator's ground truth meet.
class RunRecorder final : public LoopObserver {
 public:
  /// All references outlive it. The folder exists; without one the run is scored and nothing is written.
  RunRecorder(std::optional<std::filesystem::path> folder, const Scenario& scenario, SimRobot& robot,
              const Loop& loop);

  void on_tick(const Tick& tick) override;
  /// Wall-clock time spent here on images and the frame camera, which is not the loop's, s.
  [[nodiscard]] double picture_wall_s() const;
  /// Closes every file and writes metrics.json. `wall_s`: of the loop alone; `settings`: Metrics::settings. A run that
  /// interrupted() ended before its duration is marked.
  Metrics finish(double wall_s, std::vector<std::pair<std::string, std::string>> settings);

 private:
  std::optional<std::filesystem::path> folder_;
  const Scenario& scenario_;
  SimRobot& robot_;
  GroundTruth truth_;
  std::optional<FrameCamera> frames_;
  Observations observations_;
  std::optional<RunTables> tables_;
  RunScores scores_;
  std::optional<RunPictures> pictures_;
  std::optional<SceneRecorder> scene_;
  std::optional<GroundTruthRecorder> ground_truth_;
  std::vector<FileDigest> files_;  // as they are at the start
};

/// Overrides (`--set`) that can change what is scored, by key; of several with one key the last. The duration belongs to
/// the run, the seed has a place of its own.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> settings_of(
    const std::vector<std::string>& assignments);

}  // namespace saccade
