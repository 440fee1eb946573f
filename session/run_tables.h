#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "config/scenario.h"
#include "loop/loop.h"
#include "recording/event_file.h"
#include "recording/run_files.h"
#include "session/ground_truth.h"
#include "session/instant_queue.h"
#include "session/newest_estimate.h"

namespace saccade {

class FrameCamera;

/// The name of a scenario's event file, "events.aedat4".
[[nodiscard]] std::string event_file_name(const Scenario& scenario);

/// Writes the event file and the tables of a simulated run, tick by tick, in fixed memory.
class RunTables final : public LoopObserver {
 public:
  /// The folder exists. All others outlive it; `frames` is called before it and may be null. `imu`: of the robot, or null.
  RunTables(const std::filesystem::path& folder, const Scenario& scenario, const GroundTruth& truth,
            const Loop& loop, const FrameCamera* frames, ImuPort* imu = nullptr);

  void on_tick(const Tick& tick) override;
  /// Writes the instants that still wait for late events and closes every file under its final name.
  void commit();

 private:
  using Instants = InstantQueue<std::optional<Estimate>>;  // with what the frame camera found

  void write_detections(const Instants::Instant& instant);
  void write_streaming(const Tick& tick);
  void write_labels(std::span<const Event> events);

  const Scenario& scenario_;
  std::shared_ptr<const HeadModel> head_;
  const GroundTruth& truth_source_;
  const Loop& loop_;
  const FrameCamera* frames_;
  std::unique_ptr<EventWriter> events_;
  TableWriter<JointsRow> joints_;
  TableWriter<TruthRow> truth_;
  std::optional<TableWriter<TargetRow>> target_;  ///< of a target that is no sphere
  Instants instants_;
  std::vector<NewestEstimate> newest_;  // of the loop's detectors, then of the frame camera
  TableWriter<DetectionRow> detections_;
  TableWriter<StreamingRow> streaming_;
  TableWriter<GazeRow> gaze_;
  TableWriter<EyeRow> eye_;
  ImuPort* imu_source_;
  std::optional<TableWriter<ImuRow>> imu_;
  std::optional<TableWriter<LabelRow>> labels_;
  std::optional<TableWriter<TruthRow>> truth_right_;  // these three with events of both eyes
  std::optional<TableWriter<LabelRow>> labels_right_;
  std::optional<TableWriter<DetectionRow>> detections_right_;  // only with a detector on the right eye
};

}  // namespace saccade
