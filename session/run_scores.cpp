#include "session/run_scores.h"

#include <algorithm>

#include "control/head_kinematics.h"
#include "core/error.h"
#include "core/units.h"
#include "session/frame_camera.h"

namespace saccade {
namespace {

GazeScoringConfig gaze_scoring(const Scenario& scenario, const Camera& camera, const JointLimits& limits) {
  GazeScoringConfig config;
  config.camera = camera;
  config.limits = limits;
  config.acquire_within_rad = scenario.gaze.acquire_within_deg * rad_per_deg;
  return config;
}

/// The frequency of the largest oscillation of torso or base.
std::optional<double> sway_hz(const WorldConfig& world) {
  const SwayConfig* largest = nullptr;
  for (const std::optional<BodyMotionConfig>* motion : {&world.torso, &world.base}) {
    if (!*motion) continue;
    for (const SwayConfig* sway : {&(*motion)->pitch, &(*motion)->roll, &(*motion)->yaw}) {
      if (sway->amplitude_deg > 0.0 && (largest == nullptr || sway->amplitude_deg > largest->amplitude_deg))
        largest = sway;
    }
  }
  return largest != nullptr ? std::optional(largest->frequency_hz) : std::nullopt;
}

EyeMovementProtocol protocol_of(const Scenario& scenario) {
  EyeMovementProtocol protocol;
  const TrajectoryConfig& ball = scenario.sim.world.ball.trajectory;
  if (ball.kind == TrajectoryKind::circle) protocol.pursuit_hz = ball.frequency_hz;
  protocol.sway_hz = sway_hz(scenario.sim.world);
  return protocol;
}

}  // namespace

RunScores::RunScores(const Scenario& scenario, const GroundTruth& truth, const JointLimits& limits,
                     const Loop& loop, const Observations& observations, const FrameCamera* frames)
    : scenario_(scenario),
      truth_(truth),
      limits_(limits),
      loop_(loop),
      observations_(observations),
      gaze_(gaze_scoring(scenario, scenario.sim.camera, limits)) {
  for (const LoopDetector& detector : loop.detectors()) {
    if (detector.name == scenario.gaze.detector) driver_ = detectors_.size();
    detectors_.emplace_back(detector.name, detector.detector->threshold(), detectors_.size());
  }
  if (frames != nullptr)
    frame_detector_.emplace(std::string(frame_detector_name), frames->threshold(),
                            observations.frame_camera());
  if (scenario.output.eye_movements) eye_movements_.emplace(protocol_of(scenario));
  if (!scenario.sim.both_eyes()) return;
  right_eye_.emplace(gaze_scoring(scenario, scenario.sim.right.camera, limits));
  if (const saccade::Detector* right = loop.right_detector())
    right_eye_->detector.emplace(scenario.gaze.detector, right->threshold(), observations.right_eye());
}

void RunScores::on_tick(const Tick& tick) {
  now_us_ = tick.t_us;
  event_count_ += static_cast<std::int64_t>(tick.events.size());
  if (scenario_.sim.labels) count_labels(tick.events);
  const SimTruth& truth = truth_.state;
  gaze_.add({tick.t_us, truth.left.root_from_cam, truth.ball_m, tick.target_m, truth.plant_position_rad});
  if (eye_movements_) add_eye_movement(tick.t_us);
  const TruthRow row = truth_row(truth, truth.left);
  const double clutter_share = scenario_.sim.labels ? clutter_.share_in_window() : 0.0;
  contexts_.push_back(
      {row, right_eye_ ? truth_row(truth, *truth.right) : TruthRow{}, gaze_.held_since_us(), clutter_share});
  for (std::size_t i = 0; i < detectors_.size(); ++i) {
    count_work(detectors_[i], tick.t_us, tick.detectors[i]);
    score_newest(detectors_[i], row);
  }
  if (frame_detector_) score_newest(*frame_detector_, row);
  if (right_eye_) look_at_right_eye(tick);
  score_completed();
}

std::optional<bool> RunScores::score(Detector& detector, const TruthRow& truth,
                                     const std::optional<Estimate>& seen, double clutter_share) {
  std::optional<Observation> observation;
  if (seen) observation = observation_of(*seen);
  if (scenario_.sim.labels)
    detector.clutter.add(truth.visible, clutter_share, detector.scorer.accepts(observation));
  return detector.scorer.add(truth, observation);
}

void RunScores::score_completed() {
  for (const ObservedInstant& instant : observations_.completed()) {
    const Context context = contexts_.front();
    contexts_.pop_front();
    const auto score_of = [&](Detector& detector) {
      return score(detector, context.truth, instant.observations[detector.number], context.clutter_share);
    };
    for (std::size_t i = 0; i < detectors_.size(); ++i) {
      const auto found = score_of(detectors_[i]);
      if (driver_ == i) following_.add(found, context.held_since_us);
    }
    if (frame_detector_) score_of(*frame_detector_);
    if (!right_eye_ || !right_eye_->detector) continue;
    std::optional<Observation> observation;
    if (const auto& seen = instant.observations[observations_.right_eye()])
      observation = observation_of(*seen);
    right_eye_->detector->scorer.add(context.right_truth, observation);
  }
}

void RunScores::count_work(Detector& detector, std::int64_t t_us, const DetectorTick& result) {
  detector.elapsed_ns += result.elapsed_ns;
  detector.events_left_out += result.events_left_out;
  if (!result.busy) detector.work_us += std::max<std::int64_t>(result.ready_us - t_us, 0);
}

void RunScores::score_newest(Detector& detector, const TruthRow& truth) const {
  const auto& ready = observations_.newest(detector.number);
  if (ready) {
    detector.streaming.add(truth, observation_of(ready->estimate), ready->ready_us - ready->about_us);
  } else {
    detector.streaming.add(truth, std::nullopt, 0);
  }
}

void RunScores::count_labels(std::span<const Event> events) {
  const std::span<const EventLabel> labels = truth_.labels();
  SACCADE_CHECK(labels.size() == events.size());
  for (std::size_t i = 0; i < events.size(); ++i) {
    if (events[i].camera == 0) clutter_.add(label_row(events[i], labels[i]));
  }
}

void RunScores::look_at_right_eye(const Tick& tick) {
  RightEye& eye = *right_eye_;
  const SimTruth& truth = truth_.state;
  eye.event_count += std::ranges::count_if(tick.events, [](const Event& e) { return e.camera == 1; });
  eye.gaze.add(
      {tick.t_us, truth.right->root_from_cam, truth.ball_m, tick.target_m, truth.plant_position_rad});
  if (!eye.detector || !tick.right) return;
  count_work(*eye.detector, tick.t_us, *tick.right);
  score_newest(*eye.detector, truth_row(truth, *truth.right));
}

void RunScores::add_eye_movement(std::int64_t t_us) {
  const SimTruth& truth = truth_.state;
  if (!first_rad_) first_rad_ = truth.plant_position_rad;
  JointVector still_rad = *first_rad_;
  still_rad.head<torso_slots>() = truth.plant_position_rad.head<torso_slots>();
  const Eigen::Isometry3d root_from_still =
      HeadKinematics(limits_.head->chain, still_rad).root_from_eye(Eye::left) *
      scenario_.sim.mount.eye_from_camera();
  const Eigen::Isometry3d& root_from_cam = truth.left.root_from_cam;
  const Eigen::Vector3d axis = root_from_cam.linear().col(2);
  const TruthRow row = truth_row(truth, truth.left);
  eye_movements_->add({t_us,
                       direction_deg(axis),
                       direction_deg(truth.ball_m - root_from_cam.translation()),
                       direction_in_camera_deg(root_from_cam.inverse() * truth.ball_m),
                       direction_in_camera_deg(root_from_still.inverse() * truth.ball_m),
                       {row.circle.x_px, row.circle.y_px}},
                      axis);
}

DetectorScore RunScores::finished(const Detector& detector, std::int64_t events,
                                  const saccade::Detector* in_loop) const {
  DetectorScore score = detector.scorer.score();
  score.streaming = detector.streaming.score();
  if (in_loop == nullptr) return score;
  if (events > 0)
    score.us_per_event = static_cast<double>(detector.elapsed_ns) * 1e-3 / static_cast<double>(events);
  score.rejected_events = in_loop->rejected();
  score.failure = in_loop->failure();
  return score;
}

GazeMetrics RunScores::gaze_metrics() const {
  GazeMetrics gaze;
  gaze.detector = scenario_.gaze.detector;
  gaze.controller = scenario_.gaze.controller.controller;
  gaze.gate = scenario_.gaze.gate.gate;
  if (loop_.controller() != nullptr) gaze.failure = loop_.controller()->failure();
  for (const auto& [name, detector] : scenario_.detectors) {
    if (name == gaze.detector) gaze.window = detector.window();
  }
  gaze.score = gaze_.score();
  gaze.limits = limits_;
  if (eye_movements_) gaze.eye_movements = eye_movements_->score();
  if (gaze.score.acquired_at_us && driver_) gaze.following_rate_hz = following_.rate_hz();
  return gaze;
}

LatencyMetrics RunScores::latency_metrics() const {
  LatencyMetrics latency;
  latency.kind = word_of(scenario_.latency.kind);
  for (const Detector& detector : detectors_) {
    latency.detectors.push_back(
        {detector.name,
         now_us_ > 0 ? std::optional(static_cast<double>(detector.work_us) / static_cast<double>(now_us_))
                     : std::nullopt,
         detector.events_left_out});
  }
  return latency;
}

RightEyeMetrics RunScores::right_eye_metrics() const {
  RightEyeMetrics eye;
  eye.event_count = right_eye_->event_count;
  eye.camera = scenario_.sim.right.camera;
  eye.calibration = scenario_.right_calibration;
  if (scenario_.gaze.detector != "none") {
    const GazeScore score = right_eye_->gaze.score();
    eye.fixation_error_deg = score.fixation_error_deg;
    eye.on_target_ratio = score.on_target_ratio;
    eye.in_view_ratio = score.in_view_ratio;
  }
  if (right_eye_->detector)
    eye.detectors.emplace_back(scenario_.gaze.detector,
                               finished(*right_eye_->detector, eye.event_count, loop_.right_detector()));
  return eye;
}

Metrics RunScores::metrics() {
  score_completed();
  Metrics metrics;
  metrics.scenario = scenario_.name;
  metrics.seed = scenario_.seed;
  metrics.duration_s = static_cast<double>(now_us_) * 1e-6;
  metrics.event_count = event_count_;
  metrics.image = scenario_.sim.camera.size;
  metrics.camera = scenario_.sim.camera;
  metrics.calibration = scenario_.calibration;
  const std::int64_t left_events = event_count_ - (right_eye_ ? right_eye_->event_count : 0);
  const auto add = [&](const Detector& detector, const saccade::Detector* in_loop) {
    DetectorScore score = finished(detector, left_events, in_loop);
    if (scenario_.sim.labels)
      score.clutter = detector.clutter.result(clutter_.clutter_events(), score.inliers);
    metrics.detectors.emplace_back(detector.name, std::move(score));
  };
  for (std::size_t i = 0; i < detectors_.size(); ++i) add(detectors_[i], loop_.detectors()[i].detector.get());
  if (frame_detector_) add(*frame_detector_, nullptr);
  if (scenario_.sim.labels) metrics.clutter = clutter_.share();
  if (scenario_.gaze.detector != "none") metrics.gaze = gaze_metrics();
  if (right_eye_) metrics.right_eye = right_eye_metrics();
  if (scenario_.latency.kind != LatencyKind::none) metrics.latency = latency_metrics();
  return metrics;
}

}  // namespace saccade
