#include "loop/loop.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "control/head_kinematics.h"
#include "control/search_scan.h"
#include "core/time_stamp.h"

namespace saccade {
namespace {

constexpr std::int64_t slice_us = DetectorRunner::slice_us;
constexpr std::size_t event_capacity = 1 << 16;     // a tick with more of them allocates
constexpr std::size_t waiting_capacity = 256;       // estimates that are not ready; likewise
constexpr std::int64_t oldest_events_us = 400'000;  // whose age is compensated
constexpr double slowdown_per_find = 1.5;
constexpr double most_slowdown = 4.0;

}  // namespace

Loop::Loop(Robot& robot, const MountedCamera& camera, std::vector<LoopDetector> detectors,
           std::optional<LoopGaze> gaze, Eye eye, std::optional<LoopBudget> budget,
           const LatencyConfig& latency, std::shared_ptr<WorkerThreads> threads)
    : clock_(robot.clock()),
      source_(robot.events()),
      head_(robot.head()),
      model_(head_ != nullptr ? head_->limits().head : default_head()),
      imu_(robot.imu()),
      eye_(eye),
      camera_(camera.camera),
      eye_from_camera_(camera.mount.eye_from_camera()),
      detectors_(std::move(detectors)),
      gaze_(std::move(gaze)),
      budget_(budget),
      results_(detectors_.size()),
      last_t_us_(clock_.now_us()),
      motion_us_(last_t_us_) {
  SACCADE_CHECK(!gaze_ || (eye_ == Eye::left && (gaze_->driver || !gaze_->stereo)));
  SACCADE_CHECK(!gaze_ || (head_ != nullptr && (!gaze_->driver || *gaze_->driver < detectors_.size())));
  if (gaze_) check_config("gaze", gaze_->follow);
  if (gaze_) start_us_ = last_t_us_ + std::llround(gaze_->follow.start_s * 1e6);
  if (gaze_ && gaze_->driver) phase_ = GazePhase::searching;
  if (gaze_ && gaze_->follow.delay.sight != SightDelay::none) {
    seen_heads_.emplace();
    detector_lag_us_ = std::llround(gaze_->follow.delay.detector_ms * 1e3);
  }
  if (gaze_ && gaze_->follow.delay.motion == MotionDelay::estimated) motion_delay_.emplace();
  if (gaze_ && gaze_->follow.stabilisation.any())
    stabiliser_.emplace(gaze_->follow.stabilisation, model_, eye_from_camera_);
  if (gaze_ && gaze_->follow.stabilisation.image) image_rotation_.emplace(camera_);
  if (gaze_ && gaze_->driver && gaze_->follow.fixational.amplitude_deg > 0.0)
    fixational_.emplace(gaze_->follow.fixational);
  for (std::vector<Event>* const buffer : {&events_, &eye_events_, &other_events_})
    buffer->reserve(event_capacity);
  if (latency.kind != LatencyKind::none) {
    SACCADE_CHECK(!budget_ && robot.gaze() == nullptr);
    const std::size_t in_transit = event_capacity + static_cast<std::size_t>(latency.transport_us());
    latency_.emplace(Latency{latency, TransportDelay(latency.transport_us(), in_transit), {}, {}, {}, {}});
  }
  SACCADE_CHECK(!threads || !budget_);
  if (threads && threads->threads() > 1) threads_ = std::move(threads);
  make_runners();
}

void Loop::make_runners() {
  shadows_.clear();
  for (std::size_t i = 0; i < detectors_.size(); ++i) {
    if (!gaze_ || gaze_->driver != i) shadows_.push_back(i);
  }
  runners_.clear();
  for (const LoopDetector& detector : detectors_)
    runners_.push_back(latency_ ? DetectorRunner(latency_->config, detector.name) : DetectorRunner());
  const bool drives = gaze_ && gaze_->driver;
  runners_.push_back(
      latency_ ? DetectorRunner(latency_->config, drives ? detectors_[*gaze_->driver].name : std::string())
               : DetectorRunner());
  for (DetectorRunner& runner : runners_) {
    if (budget_) runner.limit_work(budget_->work_us);
  }
  if (!latency_) return;
  for (std::vector<WaitingEstimate>* const waiting : {&latency_->driver, &latency_->right}) {
    waiting->clear();
    waiting->reserve(waiting_capacity);
  }
  latency_->newest_right = {};
}

void Loop::set_motion(LoopMotion motion) {
  SACCADE_CHECK(gaze_ && (motion.controller != nullptr) == motion.limiter.has_value() &&
                (motion.controller == nullptr) == (motion.port != nullptr));
  gaze_->motion = std::move(motion);
  motion_us_ = last_t_us_;
}

void Loop::clear_motion() {
  if (gaze_) gaze_->motion.reset();
  if (latency_) latency_->commands.clear();
}

PortStatus Loop::note_lost(PortStatus status, std::string_view port) {
  if (status == PortStatus::lost) lost_ = port;
  return status;
}

void Loop::set_detectors(std::vector<LoopDetector> detectors, std::optional<std::size_t> driver) {
  SACCADE_CHECK(!driver || *driver < detectors.size());
  SACCADE_CHECK(!gaze_ || gaze_->driver.has_value() == driver.has_value());
  detectors_ = std::move(detectors);
  results_.assign(detectors_.size(), {});
  if (gaze_) gaze_->driver = driver;
  make_runners();
}

void Loop::set_gate(std::unique_ptr<GazeGate> gate) {
  SACCADE_CHECK(gaze_ && gate);
  gaze_->gate = std::move(gate);
}

void Loop::set_controller(std::unique_ptr<GazeController> controller) {
  SACCADE_CHECK(gaze_ && gaze_->motion && gaze_->motion->controller && controller);
  gaze_->motion->controller = std::move(controller);
  gaze_->motion->controller->set_slowdown(slowdown_);
  resend_target_ = phase_ == GazePhase::following || phase_ == GazePhase::holding;
}

PortStatus Loop::tick(std::int64_t t_us, LoopObserver& observer) {
  const PortStatus time = note_lost(wait_until(t_us), "clock");
  if (time != PortStatus::ok) return time;
  events_.clear();
  const PortStatus status = note_lost(source_.read_until(t_us, events_), "event camera");
  if (status == PortStatus::lost) return status;

  Tick tick;
  tick.t_us = t_us;
  tick.events = events_;
  tick.detectors = results_;
  select_events(tick);
  std::optional<CameraMotion> known_motion;
  if (head_ != nullptr) {
    const PortStatus read = note_lost(head_->read(tick.head.emplace()), "head");
    if (read == PortStatus::lost) return read;
    if (is_finite(*tick.head)) {
      if (seen_heads_) seen_heads_->push(*tick.head, t_us);
      known_motion = camera_motion(model_->chain, seen_head(tick), eye_, eye_from_camera_);
    }
  }
  const CameraMotion* motion = known_motion ? &*known_motion : nullptr;
  const bool detects = head_ == nullptr || motion != nullptr;
  std::ranges::fill(results_, DetectorTick{});
  const auto shadow = [&](std::size_t i) { run_shadow(shadows_[i], t_us, motion); };
  std::optional<WorkerThreads::Started> beside;
  if (detects && threads_) beside.emplace(*threads_, shadows_.size(), shadow);
  if (detects) {
    run_driver(t_us, motion, tick);
    if (gaze_ && gaze_->stereo) run_stereo(t_us, motion, tick);
  }
  PortStatus moved = PortStatus::ok;
  if (gaze_) moved = move_head(static_cast<double>(t_us - last_t_us_) * 1e-6, tick);
  tick.acted_us = clock_.now_us();
  if (beside) beside->finish();
  if (moved == PortStatus::lost) return moved;
  if (detects && !beside) run_shadows(t_us, motion);
  last_t_us_ = t_us;
  observer.on_tick(tick);
  if (!threads_) {
    for (std::size_t i = 0; i < runners_.size(); ++i) work_ahead(i);
  }
  return status;
}

PortStatus Loop::wait_until(std::int64_t t_us) {
  if (!threads_) return clock_.wait_until(t_us);
  const auto ahead = [&](std::size_t i) { work_ahead(i); };
  WorkerThreads::Started beside(*threads_, runners_.size(), ahead);
  const PortStatus status = clock_.wait_until(t_us);
  beside.finish();
  return status;
}

/// Of one of runners_.
void Loop::work_ahead(std::size_t runner) {
  if (runner < detectors_.size()) {
    runners_[runner].work_ahead(*detectors_[runner].detector);
  } else if (gaze_ && gaze_->stereo) {
    runners_[runner].work_ahead(*gaze_->stereo->detector);
  }
}

/// Splits the newest events of the tick by eye.
void Loop::select_events(Tick& tick) {
  if (budget_ && events_.size() > budget_->max_events)
    tick.events_left_out = events_.size() - budget_->max_events;
  eye_events_.clear();
  other_events_.clear();
  std::span<const Event> arrived = tick.events.subspan(tick.events_left_out);
  if (latency_) arrived = latency_->transport.pass(arrived, tick.t_us);
  for (const Event& event : arrived) {
    (event.camera == static_cast<std::uint8_t>(eye_) ? eye_events_ : other_events_).push_back(event);
  }
  if (gaze_) update_sight_age(tick.t_us);
}

void Loop::update_sight_age(std::int64_t t_us) {
  const DelayConfig& delay = gaze_->follow.delay;
  if (delay.sight == SightDelay::known) sight_age_us_ = std::llround(delay.sight_ms * 1e3);
  if (delay.sight == SightDelay::measured && !eye_events_.empty())
    sight_age_us_ =
        std::clamp(saturated_difference(t_us, eye_events_.back().t_us), std::int64_t{0}, oldest_events_us);
  if (seen_heads_) {
    for (DetectorRunner& runner : runners_) runner.set_age(sight_age_us_);
  }
}

/// The state of the head at which the events of the tick were made.
const HeadState& Loop::seen_head(const Tick& tick) const {
  return seen_heads_ && sight_age_us_ > 0 ? seen_heads_->at(tick.t_us - sight_age_us_) : *tick.head;
}

/// The pose of the camera at the instant that the driving detector's circle is about.
Eigen::Isometry3d Loop::seen_pose(std::int64_t t_us, const CameraMotion& motion) const {
  if (detector_lag_us_ == 0) return motion.root_from_camera;
  const HeadState& seen = seen_heads_->at(t_us - sight_age_us_ - detector_lag_us_);
  return camera_motion(model_->chain, seen, eye_, eye_from_camera_).root_from_camera;
}

void Loop::compensate_delays(Tick& tick) {
  const DelayConfig& delay = gaze_->follow.delay;
  if (seen_heads_ && tick.new_target_m)
    tick.delays.sight_s = static_cast<double>(tick.t_us - target_seen_us_) * 1e-6;
  if (delay.motion == MotionDelay::known) {
    tick.delays.neck_s = delay.neck_ms * 1e-3;
    tick.delays.eyes_s = delay.eyes_ms * 1e-3;
  } else if (motion_delay_) {
    tick.delays.neck_s = motion_delay_->neck_s();
    tick.delays.eyes_s = motion_delay_->eyes_s();
  }
  gaze_->motion->controller->set_delays(tick.delays);
}

PortStatus Loop::stabilise(const Tick& tick, double dt_s) {
  if (!stabiliser_ || !is_finite(*tick.head)) return PortStatus::ok;
  if (imu_ != nullptr) {
    const PortStatus status = note_lost(imu_->read_imu(imu_reading_), "inertial sensor");
    if (status == PortStatus::lost) return status;
  }
  std::optional<Eigen::Vector3d> seen_rad_s;
  if (image_rotation_) {
    image_rotation_->process(eye_events_);
    seen_rad_s = image_rotation_->advance_to(tick.t_us);
  }
  gaze_->motion->controller->set_body_rates(stabiliser_->update(
      *tick.head, imu_ != nullptr ? &imu_reading_ : nullptr, tick.delays.eyes_s, dt_s, seen_rad_s));
  return PortStatus::ok;
}

/// The head oscillates: slower constants.
void Loop::detect_hunting(Tick& tick, double dt_s) {
  if (hunting_.update(tick.command.reference_rad, dt_s)) {
    tick.hunting_hz = hunting_.frequency_hz();
    slowdown_ = std::min(most_slowdown, slowdown_ * slowdown_per_find);
    gaze_->motion->controller->set_slowdown(slowdown_);
  }
  tick.slowdown = slowdown_;
}

void Loop::run_driver(std::int64_t t_us, const CameraMotion* motion, Tick& tick) {
  if (!gaze_ || !gaze_->driver) return;
  Detector& detector = *detectors_[*gaze_->driver].detector;
  DetectorTick& driver = results_[*gaze_->driver];
  driver = runners_[*gaze_->driver].run(
      detector, t_us, t_us - slice_us, eye_events_, motion, [&](const DetectorTick& result) {
        if (motion == nullptr) return;
        const WaitingEstimate estimate{result.observed ? result.estimate : Estimate{},
                                       seen_pose(t_us, *motion), result.ready_us,
                                       t_us - sight_age_us_ - detector_lag_us_};
        if (latency_) {
          latency_->driver.push_back(estimate);
        } else if (t_us > start_us_) {
          pass_to_gate(estimate, tick);
        }
      });
  if (latency_ && motion != nullptr) pass_ready_estimates(t_us, *motion, tick);
}

void Loop::pass_to_gate(const WaitingEstimate& estimate, Tick& tick) {
  const double threshold = detectors_[*gaze_->driver].detector->threshold();
  const auto target_m =
      gaze_->gate->update(tick.t_us, estimate.estimate, threshold, camera_, estimate.root_from_camera);
  if (!target_m) return;
  tick.new_target_m = target_m;
  target_seen_us_ = estimate.seen_us;
}

/// An estimate that is ready within the tick's millisecond belongs to the tick.
void Loop::pass_ready_estimates(std::int64_t t_us, const CameraMotion& motion, Tick& tick) {
  std::vector<WaitingEstimate>& waiting = latency_->driver;
  latency_->used_us = t_us;
  const auto end = std::ranges::find_if(
      waiting, [&](const WaitingEstimate& estimate) { return estimate.ready_us >= t_us + slice_us; });
  for (auto ready = waiting.begin(); ready != end; ++ready) {
    latency_->used_us = std::max(latency_->used_us, ready->ready_us);
    if (t_us > start_us_) pass_to_gate(*ready, tick);
  }
  if (end == waiting.begin() && t_us > start_us_)
    pass_to_gate({Estimate{}, motion.root_from_camera, t_us, t_us}, tick);
  waiting.erase(waiting.begin(), end);
}

void Loop::run_stereo(std::int64_t t_us, const CameraMotion* motion, Tick& tick) {
  const LoopStereo& stereo = *gaze_->stereo;
  std::optional<CameraMotion> right_motion;
  if (motion != nullptr)
    right_motion =
        camera_motion(model_->chain, seen_head(tick), Eye::right, stereo.camera.mount.eye_from_camera());
  tick.right = runners_.back().run(*stereo.detector, t_us, late_us(t_us), other_events_,
                                   right_motion ? &*right_motion : nullptr, [](const DetectorTick&) {});
  if (!right_motion) return;
  if (!latency_) {
    locate_with_right(motion->root_from_camera, right_motion->root_from_camera,
                      tick.right->observed ? tick.right->estimate : Estimate{}, tick);
    return;
  }
  std::vector<WaitingEstimate>& waiting = latency_->right;
  if (!tick.right->busy) {
    waiting.push_back({tick.right->observed ? tick.right->estimate : Estimate{},
                       right_motion->root_from_camera, tick.right->ready_us, t_us - sight_age_us_});
  }
  while (!waiting.empty() && waiting.front().ready_us < t_us + slice_us) {
    latency_->newest_right = waiting.front();
    waiting.erase(waiting.begin());
  }
  locate_with_right(motion->root_from_camera, latency_->newest_right.root_from_camera,
                    latency_->newest_right.estimate, tick);
}

void Loop::locate_with_right(const Eigen::Isometry3d& root_from_left,
                             const Eigen::Isometry3d& root_from_right, const Estimate& right, Tick& tick) {
  const LoopStereo& stereo = *gaze_->stereo;
  if (!tick.new_target_m || !right.valid || !(right.score >= stereo.detector->threshold())) return;
  const auto met_m = stereo.locator.locate(*tick.new_target_m, root_from_left.translation(), right.circle,
                                           stereo.camera.camera, root_from_right);
  if (met_m) tick.new_target_m = met_m;
}

void Loop::run_shadows(std::int64_t t_us, const CameraMotion* motion) {
  for (const std::size_t i : shadows_) {
    results_[i].skipped = budget_ && clock_.now_us() - t_us >= budget_->shadows_until_us;
    if (!results_[i].skipped) run_shadow(i, t_us, motion);
  }
}

void Loop::run_shadow(std::size_t detector, std::int64_t t_us, const CameraMotion* motion) {
  results_[detector] = runners_[detector].run(*detectors_[detector].detector, t_us, late_us(t_us),
                                              eye_events_, motion, [](const DetectorTick&) {});
}

/// Up to here events of the tick at t_us are passed in slices, to all but the driving detector.
std::int64_t Loop::late_us(std::int64_t t_us) const {
  if (budget_) return std::numeric_limits<std::int64_t>::min();
  return latency_ ? t_us - slice_us : last_t_us_;
}

PortStatus Loop::move_head(double dt_s, Tick& tick) {
  std::optional<LoopMotion>& motion = gaze_->motion;
  HeadJointVector reference_rad = HeadJointVector::Zero();
  if (motion && motion->controller) {
    const bool resend = resend_target_ && !tick.new_target_m;
    resend_target_ = false;
    auto look_m = search_point(tick);
    if (!look_m) look_m = fixational_point(tick, dt_s);
    const bool own = resend || look_m;  // a target of the loop's own, not a new sight of the ball
    compensate_delays(tick);
    if (stabilise(tick, dt_s) == PortStatus::lost) return PortStatus::lost;
    const auto begin = std::chrono::steady_clock::now();
    reference_rad = motion->controller->step(*tick.head,
                                             look_m   ? look_m
                                             : resend ? target_m_
                                                      : tick.new_target_m,
                                             dt_s);
    tick.step_ns = std::chrono::nanoseconds(std::chrono::steady_clock::now() - begin).count();
    tick.target_status = own ? TargetStatus::none : motion->controller->target_status();
  } else {
    tick.target_status = check_target(tick);
  }
  update_target(tick);
  if (!motion) return PortStatus::ok;
  const double since_s = static_cast<double>(tick.t_us - motion_us_) * 1e-6;
  if (motion->port != nullptr) {
    if (since_s < motion->ramp_in_s) return PortStatus::ok;
    const auto look_m = tick.target_status == TargetStatus::ok ? tick.new_target_m : search_point(tick);
    return look_m ? note_lost(motion->port->look_at(*look_m), "gaze controller") : PortStatus::ok;
  }
  const double speed_share = since_s < motion->ramp_in_s ? since_s / motion->ramp_in_s : 1.0;
  tick.command = motion->limiter->apply(reference_rad, tick.head->head_position_rad(), dt_s, speed_share);
  if (motion_delay_ && is_finite(*tick.head))
    motion_delay_->update(tick.head->head_position_rad(), tick.command.reference_rad, dt_s);
  if (gaze_->follow.detect_hunting) detect_hunting(tick, dt_s);
  return send_command(tick);
}

PortStatus Loop::send_command(Tick& tick) {
  std::optional<HeadCommand> reference_rad = tick.command.reference_rad;
  if (latency_) {
    const LatencyConfig& config = latency_->config;
    const bool measured = config.kind == LatencyKind::measured;
    const double step_us = measured ? static_cast<double>(tick.step_ns) * 1e-3 : config.controller_us;
    const double delay_us = step_us + config.actuation_ms * 1e3;
    const std::int64_t begin_us = std::max(tick.t_us, latency_->used_us);
    latency_->commands.push(*reference_rad, begin_us + std::llround(std::ceil(delay_us)));
    reference_rad = latency_->commands.pop(tick.t_us);
  }
  if (!reference_rad) return PortStatus::ok;
  const HeadPort::CommandResult result = head_->command(*reference_rad);
  tick.command_rejected = result.rejected;
  return note_lost(result.status, "head");
}

/// Targets come only while the head's state is finite.
TargetStatus Loop::check_target(const Tick& tick) const {
  if (!tick.new_target_m) return TargetStatus::none;
  return check_gaze_target(*tick.new_target_m, HeadKinematics(model_->chain, tick.head->position_rad));
}

/// The next point of a search; none while the head looks long enough at the last one, or if there is a target.
std::optional<Eigen::Vector3d> Loop::search_point(const Tick& tick) {
  if (!search_us_ || tick.new_target_m || !is_finite(*tick.head)) return std::nullopt;
  const std::int64_t dwell_us = std::llround(gaze_->follow.search_dwell_s * 1e6);
  const std::int64_t place = (tick.t_us - *search_us_) / dwell_us;
  if (place == search_place_) return std::nullopt;
  search_place_ = place;
  const HeadKinematics head(model_->chain, tick.head->position_rad);
  const Eigen::Vector3d point_m = SearchScan(*target_m_).point(place, head);
  if (check_gaze_target(point_m, head) != TargetStatus::ok) return std::nullopt;
  return point_m;
}

/// A point beside the target while no current events show the ball.
std::optional<Eigen::Vector3d> Loop::fixational_point(const Tick& tick, double dt_s) {
  if (!fixational_ || !is_finite(*tick.head)) return std::nullopt;
  const DetectorTick& driver = results_[*gaze_->driver];
  const bool seen = driver.at_threshold && !driver.estimate.held;
  const bool follows = phase_ == GazePhase::following || phase_ == GazePhase::holding;
  const auto right_up_rad = fixational_->update(seen, follows, dt_s);
  if (!right_up_rad) return std::nullopt;
  const HeadKinematics head(model_->chain, tick.head->position_rad);
  const Eigen::Vector3d point_m = displaced(*target_m_, *right_up_rad, head);
  if (check_gaze_target(point_m, head) != TargetStatus::ok) return std::nullopt;
  return point_m;
}

void Loop::update_target(Tick& tick) {
  if (tick.target_status == TargetStatus::ok) {
    search_us_.reset();
    target_m_ = tick.new_target_m;
    target_us_ = tick.t_us;
    phase_ = GazePhase::following;
  } else if (phase_ == GazePhase::following &&
             static_cast<double>(tick.t_us - target_us_) * 1e-6 >= gaze_->follow.lost_after_s) {
    const bool rest = gaze_->follow.lost == WhenLost::rest;
    if (rest && gaze_->motion && gaze_->motion->controller) gaze_->motion->controller->rest();
    phase_ = rest ? GazePhase::resting : GazePhase::holding;
  } else if (phase_ == GazePhase::holding && gaze_->follow.lost == WhenLost::search &&
             static_cast<double>(tick.t_us - target_us_) * 1e-6 >=
                 gaze_->follow.lost_after_s + gaze_->follow.search_dwell_s) {
    phase_ = GazePhase::searching;
    search_us_ = tick.t_us;
    search_place_ = -1;
  }
  tick.target_m = target_m_;
  tick.target_us = target_us_;
  tick.phase = phase_;
  tick.rejected = gaze_->gate->rejected();
}

}  // namespace saccade
