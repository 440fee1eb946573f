#include "loop/loop.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "control/head_kinematics.h"

namespace saccade {
namespace {

constexpr std::int64_t slice_us = 1'000;
constexpr std::size_t event_capacity = 1 << 16;  // a tick with more of them allocates
constexpr std::size_t late_capacity = 64;        // estimates; any more are not reported

DetectorTick run_detector(Detector& detector, std::span<const Event> events,
                          std::optional<std::int64_t> now_us, const CameraMotion* motion) {
  const auto begin = std::chrono::steady_clock::now();
  detector.process(events, motion);
  if (now_us) detector.advance_to(*now_us, motion);
  DetectorTick result;
  result.estimate = detector.estimate();
  const auto end = std::chrono::steady_clock::now();
  result.observed = result.estimate.valid && (!events.empty() || result.estimate.held);
  result.on_time = result.observed;
  result.elapsed_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(end - begin).count();
  return result;
}

}  // namespace

/// The events of a tick for one detector, in slices.
class Loop::Slices {
 public:
  /// Events up to `late_us` are passed in slices of their own, the others at once.
  Slices(Detector& detector, std::int64_t t_us, std::int64_t late_us, const CameraMotion* motion,
         std::vector<LateEstimate>& late)
      : detector_(detector), t_us_(t_us), late_us_(late_us), motion_(motion), late_(late) {}

  /// `on_slice` gets the result of each slice, the last one included.
  template <class OnSlice>
  [[nodiscard]] DetectorTick run(std::span<const Event> events, OnSlice on_slice) {
    late_.clear();
    std::int64_t elapsed_ns = 0;
    std::span<const Event> left = events;
    while (!left.empty() && left.front().t_us <= late_us_) {
      const std::int64_t until_us = t_us_ - (t_us_ - left.front().t_us) / slice_us * slice_us;
      const auto slice_end = std::ranges::upper_bound(left, until_us, {}, &Event::t_us);
      const auto slice = left.first(static_cast<std::size_t>(slice_end - left.begin()));
      const DetectorTick result = run_detector(detector_, slice, std::nullopt, motion_);
      elapsed_ns += result.elapsed_ns;
      if (result.observed && late_.size() < late_capacity) late_.push_back({until_us, result.estimate});
      on_slice(result);
      left = left.subspan(slice.size());
    }
    DetectorTick result = run_detector(detector_, left, t_us_, motion_);
    on_slice(result);
    result.observed = result.estimate.valid && (!events.empty() || result.estimate.held);
    result.elapsed_ns += elapsed_ns;
    result.late = late_;
    return result;
  }
  [[nodiscard]] DetectorTick run(std::span<const Event> events) {
    return run(events, [](const DetectorTick&) {});
  }

 private:
  Detector& detector_;
  std::int64_t t_us_;
  std::int64_t late_us_;
  const CameraMotion* motion_;
  std::vector<LateEstimate>& late_;
};

Loop::Loop(Robot& robot, const MountedCamera& camera, std::vector<LoopDetector> detectors,
           std::optional<LoopGaze> gaze, Eye eye, std::optional<LoopBudget> budget)
    : clock_(robot.clock()),
      source_(robot.events()),
      head_(robot.head()),
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
  for (std::vector<Event>* const buffer : {&events_, &eye_events_, &other_events_})
    buffer->reserve(event_capacity);
  reserve_late_estimates();
}

void Loop::reserve_late_estimates() {
  late_.resize(detectors_.size() + 1);
  for (std::vector<LateEstimate>& late : late_) late.reserve(late_capacity);
}

void Loop::set_motion(LoopMotion motion) {
  SACCADE_CHECK(gaze_ && (motion.controller != nullptr) == motion.limiter.has_value() &&
                (motion.controller == nullptr) == (motion.port != nullptr));
  gaze_->motion = std::move(motion);
  motion_us_ = last_t_us_;
}

void Loop::clear_motion() {
  if (gaze_) gaze_->motion.reset();
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
  reserve_late_estimates();
  if (gaze_) gaze_->driver = driver;
}

void Loop::set_gate(std::unique_ptr<GazeGate> gate) {
  SACCADE_CHECK(gaze_ && gate);
  gaze_->gate = std::move(gate);
}

void Loop::set_controller(std::unique_ptr<GazeController> controller) {
  SACCADE_CHECK(gaze_ && gaze_->motion && gaze_->motion->controller && controller);
  gaze_->motion->controller = std::move(controller);
  resend_target_ = phase_ == GazePhase::following || phase_ == GazePhase::holding;
}

PortStatus Loop::tick(std::int64_t t_us, LoopObserver& observer) {
  const PortStatus time = note_lost(clock_.wait_until(t_us), "clock");
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
    if (is_finite(*tick.head)) known_motion = camera_motion(*tick.head, eye_, eye_from_camera_);
  }
  const CameraMotion* motion = known_motion ? &*known_motion : nullptr;
  const bool detects = head_ == nullptr || motion != nullptr;
  std::ranges::fill(results_, DetectorTick{});
  if (detects) {
    run_driver(t_us, motion, tick);
    if (gaze_ && gaze_->stereo) run_stereo(t_us, motion, tick);
  }
  if (gaze_) {
    const PortStatus moved = move_head(static_cast<double>(t_us - last_t_us_) * 1e-6, tick);
    if (moved == PortStatus::lost) return moved;
  }
  tick.acted_us = clock_.now_us();
  if (detects) run_shadows(t_us, motion);
  last_t_us_ = t_us;
  observer.on_tick(tick);
  return status;
}

/// Splits the newest events of the tick by eye.
void Loop::select_events(Tick& tick) {
  if (budget_ && events_.size() > budget_->max_events)
    tick.events_left_out = events_.size() - budget_->max_events;
  eye_events_.clear();
  other_events_.clear();
  for (const Event& event : tick.events.subspan(tick.events_left_out)) {
    (event.camera == static_cast<std::uint8_t>(eye_) ? eye_events_ : other_events_).push_back(event);
  }
}

void Loop::run_driver(std::int64_t t_us, const CameraMotion* motion, Tick& tick) {
  if (!gaze_ || !gaze_->driver) return;
  Detector& detector = *detectors_[*gaze_->driver].detector;
  const bool gate = motion != nullptr && t_us > start_us_;
  Slices slices(detector, t_us, t_us - slice_us, motion, late_[*gaze_->driver]);
  results_[*gaze_->driver] = slices.run(eye_events_, [&](const DetectorTick& result) {
    if (!gate) return;
    const auto target_m = gaze_->gate->update(t_us, result.observed ? result.estimate : Estimate{},
                                              detector.threshold(), camera_, motion->root_from_camera);
    if (target_m) tick.new_target_m = target_m;
  });
}

void Loop::run_stereo(std::int64_t t_us, const CameraMotion* motion, Tick& tick) {
  const LoopStereo& stereo = *gaze_->stereo;
  std::optional<CameraMotion> right_motion;
  if (motion != nullptr)
    right_motion = camera_motion(*tick.head, Eye::right, stereo.camera.mount.eye_from_camera());
  Slices slices(*stereo.detector, t_us, last_t_us_, right_motion ? &*right_motion : nullptr, late_.back());
  tick.right = slices.run(other_events_);
  const bool in_both_eyes = tick.new_target_m && right_motion && tick.right->observed &&
                            tick.right->estimate.score >= stereo.detector->threshold();
  if (!in_both_eyes) return;
  const auto met_m = stereo.locator.locate(*tick.new_target_m, motion->root_from_camera.translation(),
                                           tick.right->estimate.circle, stereo.camera.camera,
                                           right_motion->root_from_camera);
  if (met_m) tick.new_target_m = met_m;
}

void Loop::run_shadows(std::int64_t t_us, const CameraMotion* motion) {
  for (std::size_t i = 0; i < detectors_.size(); ++i) {
    if (gaze_ && gaze_->driver == i) continue;
    results_[i].skipped = budget_ && clock_.now_us() - t_us >= budget_->shadows_until_us;
    if (results_[i].skipped) continue;
    const std::int64_t late_us = budget_ ? std::numeric_limits<std::int64_t>::min() : last_t_us_;
    results_[i] = Slices(*detectors_[i].detector, t_us, late_us, motion, late_[i]).run(eye_events_);
  }
}

PortStatus Loop::move_head(double dt_s, Tick& tick) {
  std::optional<LoopMotion>& motion = gaze_->motion;
  HeadJointVector reference_rad = HeadJointVector::Zero();
  if (motion && motion->controller) {
    const bool resend = resend_target_ && !tick.new_target_m;
    resend_target_ = false;
    reference_rad = motion->controller->step(*tick.head, resend ? target_m_ : tick.new_target_m, dt_s);
    tick.target_status = resend ? TargetStatus::none : motion->controller->target_status();
  } else {
    tick.target_status = check_target(tick);
  }
  update_target(tick);
  if (!motion) return PortStatus::ok;
  const double since_s = static_cast<double>(tick.t_us - motion_us_) * 1e-6;
  if (motion->port != nullptr) {
    const bool send = tick.target_status == TargetStatus::ok && since_s >= motion->ramp_in_s;
    return send ? note_lost(motion->port->look_at(*tick.new_target_m), "gaze controller") : PortStatus::ok;
  }
  const double speed_share = since_s < motion->ramp_in_s ? since_s / motion->ramp_in_s : 1.0;
  tick.command = motion->limiter->apply(reference_rad, tick.head->head_position_rad(), dt_s, speed_share);
  const HeadPort::CommandResult result = head_->command(tick.command.reference_rad);
  tick.command_rejected = result.rejected;
  return note_lost(result.status, "head");
}

/// Targets come only while the head's state is finite.
TargetStatus Loop::check_target(const Tick& tick) {
  if (!tick.new_target_m) return TargetStatus::none;
  return check_gaze_target(*tick.new_target_m, HeadKinematics(tick.head->position_rad));
}

void Loop::update_target(Tick& tick) {
  if (tick.target_status == TargetStatus::ok) {
    target_m_ = tick.new_target_m;
    target_us_ = tick.t_us;
    phase_ = GazePhase::following;
  } else if (phase_ == GazePhase::following &&
             static_cast<double>(tick.t_us - target_us_) * 1e-6 >= gaze_->follow.lost_after_s) {
    const bool rest = gaze_->follow.lost == WhenLost::rest;
    if (rest && gaze_->motion && gaze_->motion->controller) gaze_->motion->controller->rest();
    phase_ = rest ? GazePhase::resting : GazePhase::holding;
  }
  tick.target_m = target_m_;
  tick.target_us = target_us_;
  tick.phase = phase_;
  tick.rejected = gaze_->gate->rejected();
}

}  // namespace saccade
