#include "apps/session/run_tables.h"

#include "apps/session/frame_camera.h"
#include "control/head_kinematics.h"
#include "core/error.h"

namespace saccade {

std::string event_file_name(const Scenario& scenario) { return "events." + scenario.output.events; }

RunTables::RunTables(const std::filesystem::path& folder, const Scenario& scenario, const GroundTruth& truth,
                     const Loop& loop, const FrameCamera* frames)
    : scenario_(scenario),
      truth_source_(truth),
      loop_(loop),
      frames_(frames),
      events_(create_event_file(folder / event_file_name(scenario), scenario.sim.camera.size,
                                scenario.sim.both_eyes() ? 2 : 1)),
      joints_(folder / "joints.csv"),
      truth_(folder / "truth.csv"),
      detections_(folder / "detections.csv"),
      gaze_(folder / "gaze.csv"),
      eye_(folder / "eye.csv") {
  if (scenario.sim.labels) labels_.emplace(folder / "labels.csv");
  if (!scenario.sim.both_eyes()) return;
  truth_right_.emplace(folder / "truth_right.csv");
  if (loop.right_detector() != nullptr) detections_right_.emplace(folder / "detections_right.csv");
  if (scenario.sim.labels) labels_right_.emplace(folder / "labels_right.csv");
}

void RunTables::on_tick(const Tick& tick) {
  events_->write(tick.events);
  if (labels_) write_labels(tick.events);
  for (std::size_t i = 0; i < tick.detectors.size(); ++i) {
    const DetectorTick& result = tick.detectors[i];
    if (!result.observed) continue;
    detections_.write({tick.t_us, loop_.detectors()[i].name, result.estimate.circle, result.estimate.score,
                       result.estimate.held});
  }
  if (frames_ != nullptr && frames_->detection()) {
    const Estimate& ball = *frames_->detection();
    detections_.write({tick.t_us, std::string(frame_detector_name), ball.circle, ball.score, false});
  }
  if (truth_right_) write_right_eye(tick);

  const SimTruth& truth = truth_source_.state;
  const FixationPoint fixation = HeadKinematics(tick.head->position_rad).fixation();
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  joints_.write({tick.t_us, tick.head->position_rad});
  truth_.write(truth_row(truth, truth.left));
  gaze_.write({tick.t_us, fixation.valid ? fixation.point_m : none, tick.target_m.value_or(none),
               tick.head->position_rad});
  eye_.write(EyeRow::of(tick.t_us, truth.left.root_from_cam));
}

void RunTables::write_right_eye(const Tick& tick) {
  const SimTruth& truth = truth_source_.state;
  truth_right_->write(truth_row(truth, *truth.right));
  if (!detections_right_ || !tick.right || !tick.right->observed) return;
  const Estimate& estimate = tick.right->estimate;
  detections_right_->write(
      {tick.t_us, scenario_.gaze.detector, estimate.circle, estimate.score, estimate.held});
}

void RunTables::write_labels(std::span<const Event> events) {
  const std::span<const EventLabel> labels = truth_source_.labels();
  SACCADE_CHECK(labels.size() == events.size());
  for (std::size_t i = 0; i < events.size(); ++i) {
    (events[i].camera == 1 ? *labels_right_ : *labels_).write(label_row(events[i], labels[i]));
  }
}

void RunTables::commit() {
  events_->commit();
  joints_.commit();
  truth_.commit();
  detections_.commit();
  gaze_.commit();
  eye_.commit();
  if (labels_) labels_->commit();
  if (truth_right_) truth_right_->commit();
  if (labels_right_) labels_right_->commit();
  if (detections_right_) detections_right_->commit();
}

}  // namespace saccade
