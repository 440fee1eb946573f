#include "apps/loop.h"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "control/head_kinematics.h"

namespace saccade {
namespace {

constexpr std::int64_t slice_us = 1'000;

}  // namespace

Loop::Loop(Clock& clock, EventSource& events, HeadPort* head, const MountedCamera& camera,
           std::vector<LoopDetector> detectors, std::optional<LoopGaze> gaze, Eye eye)
    : clock_(clock),
      source_(events),
      head_(head),
      eye_(eye),
      camera_(camera.camera),
      eye_from_camera_(camera.mount.eye_from_camera()),
      detectors_(std::move(detectors)),
      gaze_(std::move(gaze)),
      results_(detectors_.size()),
      last_t_us_(clock.now_us()) {
  SACCADE_CHECK(!gaze_ || (eye_ == Eye::left && (gaze_->driver || !gaze_->stereo)));
  SACCADE_CHECK(!gaze_ || (head_ != nullptr && (!gaze_->driver || *gaze_->driver < detectors_.size())));
  if (gaze_) check_config("gaze", gaze_->follow);
  if (gaze_) start_us_ = last_t_us_ + std::llround(gaze_->follow.start_s * 1e6);
  if (gaze_ && gaze_->driver) phase_ = GazePhase::searching;
}

PortStatus Loop::tick(std::int64_t t_us, LoopObserver& observer) {
  const auto need = [](PortStatus status, const char* what) {
    if (status == PortStatus::lost) throw RunError(std::string("lost the connection to the ") + what);
    return status;
  };
  if (need(clock_.wait_until(t_us), "clock") == PortStatus::ended) return PortStatus::ended;
  events_.clear();
  const PortStatus status = need(source_.read_until(t_us, events_), "event camera");
  seen_events_.clear();
  other_events_.clear();
  for (const Event& event : events_) {
    (event.camera == static_cast<std::uint8_t>(eye_) ? seen_events_ : other_events_).push_back(event);
  }

  Tick tick;
  tick.t_us = t_us;
  std::optional<CameraMotion> known_motion;
  if (head_ != nullptr) {
    need(head_->read(tick.head.emplace()), "head");
    if (is_finite(*tick.head)) known_motion = camera_motion(*tick.head, eye_, eye_from_camera_);
  }
  const CameraMotion* motion = known_motion ? &*known_motion : nullptr;
  for (std::size_t i = 0; i < detectors_.size(); ++i) {
    if (gaze_ && gaze_->driver == i && motion != nullptr && t_us > start_us_) {
      drive(t_us, *motion, tick);
    } else {
      results_[i] = ask(*detectors_[i].detector, seen_events_, t_us, motion);
    }
  }
  if (gaze_ && gaze_->stereo) see_with_both_eyes(t_us, motion, tick);
  tick.events = events_;
  tick.detectors = results_;
  if (gaze_) act(static_cast<double>(t_us - last_t_us_) * 1e-6, tick);
  last_t_us_ = t_us;
  observer.on_tick(tick);
  return status;
}

DetectorTick Loop::ask(Detector& detector, std::span<const Event> events, std::optional<std::int64_t> now_us,
                       const CameraMotion* motion) {
  const auto begin = std::chrono::steady_clock::now();
  detector.process(events, motion);
  if (now_us) detector.advance_to(*now_us, motion);
  const Estimate estimate = detector.estimate();
  const auto end = std::chrono::steady_clock::now();
  return {estimate, estimate.valid && (!events.empty() || estimate.held),
          std::chrono::duration_cast<std::chrono::nanoseconds>(end - begin).count()};
}

void Loop::drive(std::int64_t t_us, const CameraMotion& motion, Tick& tick) {
  Detector& detector = *detectors_[*gaze_->driver].detector;
  std::int64_t elapsed_ns = 0;
  const auto look = [&](std::span<const Event> events, std::optional<std::int64_t> now_us) {
    const DetectorTick seen = ask(detector, events, now_us, &motion);
    elapsed_ns += seen.elapsed_ns;
    const auto target_m = gaze_->gate->update(t_us, seen.observed ? seen.estimate : Estimate{},
                                              detector.threshold(), camera_, motion.root_from_camera);
    if (target_m) tick.new_target_m = target_m;
    return seen.estimate;
  };
  std::span<const Event> left = seen_events_;
  while (!left.empty() && left.front().t_us <= t_us - slice_us) {
    const std::int64_t until_us = t_us - (t_us - left.front().t_us) / slice_us * slice_us;
    const auto slice_end = std::ranges::upper_bound(left, until_us, {}, &Event::t_us);
    const auto slice = left.first(static_cast<std::size_t>(slice_end - left.begin()));
    look(slice, std::nullopt);
    left = left.subspan(slice.size());
  }
  const Estimate estimate = look(left, t_us);
  results_[*gaze_->driver] = {estimate, estimate.valid && (!seen_events_.empty() || estimate.held),
                              elapsed_ns};
}

void Loop::see_with_both_eyes(std::int64_t t_us, const CameraMotion* motion, Tick& tick) {
  const LoopStereo& stereo = *gaze_->stereo;
  std::optional<CameraMotion> right_motion;
  if (motion != nullptr)
    right_motion = camera_motion(*tick.head, Eye::right, stereo.camera.mount.eye_from_camera());
  tick.right = ask(*stereo.detector, other_events_, t_us, right_motion ? &*right_motion : nullptr);
  const bool seen_by_both = tick.new_target_m && right_motion && tick.right->observed &&
                            tick.right->estimate.score >= stereo.detector->threshold();
  if (!seen_by_both) return;
  const auto met_m = stereo.locator.locate(*tick.new_target_m, motion->root_from_camera.translation(),
                                           tick.right->estimate.circle, stereo.camera.camera,
                                           right_motion->root_from_camera);
  if (met_m) tick.new_target_m = met_m;
}

void Loop::act(double dt_s, Tick& tick) {
  const HeadJointVector wanted = gaze_->controller->step(*tick.head, tick.new_target_m, dt_s);
  tick.target_status = gaze_->controller->target_status();
  watch_target(tick);
  tick.command = gaze_->limiter.apply(wanted, tick.head->head_position_rad(), dt_s);
  const HeadPort::CommandResult result = head_->command(tick.command.reference_rad);
  if (result.status == PortStatus::lost) throw RunError("lost the connection to the head");
  tick.command_refused = result.refused;
}

void Loop::watch_target(Tick& tick) {
  if (tick.target_status == TargetStatus::ok) {
    target_m_ = tick.new_target_m;
    seen_us_ = tick.t_us;
    phase_ = GazePhase::following;
  } else if (phase_ == GazePhase::following &&
             static_cast<double>(tick.t_us - seen_us_) * 1e-6 >= gaze_->follow.lost_after_s) {
    const bool rest = gaze_->follow.lost == "rest";
    if (rest) gaze_->controller->rest();
    phase_ = rest ? GazePhase::resting : GazePhase::holding;
  }
  tick.target_m = target_m_;
  tick.seen_us = seen_us_;
  tick.phase = phase_;
  tick.rejected = gaze_->gate->rejected();
}

}  // namespace saccade
