#include "session/run_tables.h"

#include "control/head_kinematics.h"
#include "core/error.h"
#include "recording/run_file_names.h"
#include "session/frame_camera.h"

namespace saccade {

std::string event_file_name(const Scenario& scenario) { return "events." + scenario.output.events; }

RunTables::RunTables(const std::filesystem::path& folder, const Scenario& scenario, const GroundTruth& truth,
                     const Loop& loop, const Observations& observations, ImuPort* imu)
    : scenario_(scenario),
      head_(head_model(scenario.sim.world.head)),
      truth_source_(truth),
      loop_(loop),
      observations_(observations),
      events_(create_event_file(scenario.output.formats, folder / event_file_name(scenario),
                                scenario.sim.camera.size, scenario.sim.both_eyes() ? 2 : 1)),
      joints_(folder / run_file::joints, head_),
      truth_(folder / run_file::truth),
      detections_(folder / run_file::detections),
      streaming_(folder / run_file::streaming),
      gaze_(folder / run_file::gaze, head_),
      eye_(folder / run_file::eye),
      imu_source_(imu) {
  if (imu_source_ != nullptr) imu_.emplace(folder / run_file::imu);
  if (!truth.state.target_is_sphere) target_.emplace(folder / run_file::target);
  if (scenario.sim.labels) labels_.emplace(folder / run_file::labels);
  if (!scenario.sim.both_eyes()) return;
  truth_right_.emplace(folder / run_file::truth_right);
  if (loop.right_detector() != nullptr) detections_right_.emplace(folder / run_file::detections_right);
  if (scenario.sim.labels) labels_right_.emplace(folder / run_file::labels_right);
}

void RunTables::on_tick(const Tick& tick) {
  events_->write(tick.events);
  if (labels_) write_labels(tick.events);
  write_streaming(tick);

  const SimTruth& truth = truth_source_.state;
  const FixationPoint fixation = HeadKinematics(head_->chain, tick.head->position_rad).fixation();
  const Eigen::Vector3d none = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  joints_.write({tick.t_us, tick.head->position_rad});
  truth_.write(truth_row(truth, truth.left));
  if (target_) target_->write(target_row(truth, truth.left));
  if (truth_right_) truth_right_->write(truth_row(truth, *truth.right));
  gaze_.write({tick.t_us, fixation.valid ? fixation.point_m : none, tick.target_m.value_or(none),
               tick.head->position_rad});
  eye_.write(EyeRow::of(tick.t_us, truth.left.root_from_cam));
  if (imu_) {
    ImuRow row{tick.t_us, {}};
    if (imu_source_->read_imu(row.reading) == PortStatus::ok) imu_->write(row);
  }
  write_detections();
}

void RunTables::write_detections() {
  observations_.write_completed(detections_);
  if (!detections_right_) return;
  for (const ObservedInstant& instant : observations_.completed()) {
    if (const auto& right = instant.observations[observations_.right_eye()])
      detections_right_->write(detection_row(instant.t_us, scenario_.gaze.detector, *right));
  }
}

void RunTables::write_streaming(const Tick& tick) {
  const auto write = [&](const std::string& name, std::size_t detector) {
    if (const auto& ready = observations_.newest(detector))
      streaming_.write({detection_row(tick.t_us, name, ready->estimate), ready->ready_us});
  };
  for (std::size_t i = 0; i < tick.detectors.size(); ++i) write(loop_.detectors()[i].name, i);
  write(std::string(frame_detector_name), observations_.frame_camera());
}

void RunTables::write_labels(std::span<const Event> events) {
  const std::span<const EventLabel> labels = truth_source_.labels();
  SACCADE_CHECK(labels.size() == events.size());
  for (std::size_t i = 0; i < events.size(); ++i) {
    (events[i].camera == 1 ? *labels_right_ : *labels_).write(label_row(events[i], labels[i]));
  }
}

void RunTables::commit() {
  write_detections();
  events_->commit();
  joints_.commit();
  truth_.commit();
  if (target_) target_->commit();
  detections_.commit();
  streaming_.commit();
  gaze_.commit();
  eye_.commit();
  if (imu_) imu_->commit();
  if (labels_) labels_->commit();
  if (truth_right_) truth_right_->commit();
  if (labels_right_) labels_right_->commit();
  if (detections_right_) detections_right_->commit();
}

}  // namespace saccade
