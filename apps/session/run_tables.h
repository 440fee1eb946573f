#pragma once

#include <filesystem>
#include <memory>
#include <optional>

#include "apps/config/scenario.h"
#include "apps/session/ground_truth.h"
#include "loop/loop.h"
#include "recording/event_file.h"
#include "recording/run_files.h"

namespace saccade {

class FrameCamera;

/// The name of a scenario's event file, "events.aedat4".
[[nodiscard]] std::string event_file_name(const Scenario& scenario);

/// Writes the event file and the tables of a simulated run, tick by tick, in fixed memory.
class RunTables final : public LoopObserver {
 public:
  /// The folder exists. All others outlive it; `frames` is called before it and may be null.
  RunTables(const std::filesystem::path& folder, const Scenario& scenario, const GroundTruth& truth,
            const Loop& loop, const FrameCamera* frames);

  void on_tick(const Tick& tick) override;
  /// Closes every file under its final name.
  void commit();

 private:
  void write_right_eye(const Tick& tick);
  void write_labels(std::span<const Event> events);

  const Scenario& scenario_;
  const GroundTruth& truth_source_;
  const Loop& loop_;
  const FrameCamera* frames_;
  std::unique_ptr<EventWriter> events_;
  TableWriter<JointsRow> joints_;
  TableWriter<TruthRow> truth_;
  TableWriter<DetectionRow> detections_;
  TableWriter<GazeRow> gaze_;
  TableWriter<EyeRow> eye_;
  std::optional<TableWriter<LabelRow>> labels_;
  std::optional<TableWriter<TruthRow>> truth_right_;  // these three with events of both eyes
  std::optional<TableWriter<LabelRow>> labels_right_;
  std::optional<TableWriter<DetectionRow>> detections_right_;  // only with a detector on the right eye
};

}  // namespace saccade
