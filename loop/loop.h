#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "control/gaze_controller.h"
#include "control/gaze_gate.h"
#include "control/joint_limiter.h"
#include "core/detector.h"
#include "robot/ports.h"

namespace saccade {

/// A detector in the loop. All of them see the events of the same eye; one drives the gaze, the others shadow it.
struct LoopDetector {
  std::string name;
  std::unique_ptr<Detector> detector;
};

/// The right eye's part in the gaze: a detector like the one that drives, which sees the right eye's events, and what
/// makes a distance of both eyes' bearings.
struct LoopStereo {
  std::unique_ptr<Detector> detector;
  MountedCamera camera;  ///< what is believed of the right eye's
  StereoLocator locator;
};

/// What moves the head: a controller of ours and the limits of its commands, or the robot's own one behind `port`.
struct LoopMotion {
  std::unique_ptr<GazeController> controller;
  std::optional<JointLimiter> limiter;  ///< of its commands
  GazePort* port = nullptr;             ///< instead of both: gets the targets
  /// From the start on the limit of speed grows from 0 to its full value for so long; a port gets no target.
  double ramp_in_s = 0.0;
};

/// What turns detections into gaze, all of one robot.
struct LoopGaze {
  std::optional<std::size_t> driver;  ///< index of the detector that drives; none: no targets
  std::unique_ptr<GazeGate> gate;     ///< of the driver
  std::optional<LoopMotion> motion;   ///< none: nothing is sent to the head before Loop::take_over
  FollowConfig follow;
  std::optional<LoopStereo> stereo = std::nullopt;  ///< needs a driver
};

/// What is left out of a tick that has too much to do, so that no queue grows. Deterministic for a given clock.
///
///   1. Of the events that wait the newest `max_events` go to the detectors; older ones are recorded and left out.
///   2. The detector that drives comes first, and the head's command right after it.
///   3. The others come after that, in their order, while the tick is younger than `shadows_until_us`. One that is left
///      out misses the tick's events.
struct LoopBudget {
  std::size_t max_events = 0;
  std::int64_t shadows_until_us = 0;
};

/// What the gaze is about.
enum class GazePhase {
  none,       ///< nothing drives it
  searching,  ///< no target yet
  following,  ///< the newest target is not lost
  holding,    ///< it is lost; the head keeps looking there
  resting,    ///< it is lost; the head goes to its neutral pose
};

/// What one detector said in one tick.
struct DetectorTick {
  Estimate estimate;
  bool observed = false;  ///< an observation after design.md section 7: events came, or the estimate is held
  bool skipped = false;   ///< it was not asked, LoopBudget
  std::int64_t elapsed_ns = 0;
};

/// Everything that happened in one tick; valid until the next one.
struct Tick {
  std::int64_t t_us = 0;
  std::span<const Event> events;            ///< delivered in this tick, of both eyes
  std::size_t events_left_out = 0;          ///< the first of them, which no detector got (LoopBudget)
  std::span<const DetectorTick> detectors;  ///< in the order of the loop's detectors
  std::optional<DetectorTick> right;        ///< what LoopStereo's detector said
  std::optional<HeadState> head;  ///< not finite where a sensor fails; then nothing is detected or followed
  std::optional<Eigen::Vector3d> new_target_m;      ///< handed to the controller in this tick, root frame
  std::optional<Eigen::Vector3d> target_m;          ///< the newest one so far
  TargetStatus target_status = TargetStatus::none;  ///< what the controller made of new_target_m
  RejectedTargets rejected;                         ///< by the gate so far
  GazePhase phase = GazePhase::none;
  std::int64_t seen_us = 0;      ///< when target_m came
  JointLimiter::Result command;  ///< sent to the head, and which limits acted
  bool command_refused = false;  ///< by the head
  std::int64_t acted_us = 0;     ///< what the clock said when command or target had been sent
};

class LoopObserver {
 public:
  virtual ~LoopObserver() = default;
  virtual void on_tick(const Tick& tick) = 0;
};

/// The loop: every tick it asks the world for events and joints, thinks, and acts. The same for the
/// simulator, a recording and the robot; it knows only the ports.
///
/// Events may come in packets that span several milliseconds. The driving detector gets them in slices of 1 ms, and
/// the gate what it says after each, so that what a gate counts does not depend on how events were packed.
class Loop {
 public:
  /// `head` may be null (a bare recording): then there is no gaze and no camera motion.
  /// Detectors look through `eye`, which gaze needs to be the left one; `camera` is what is believed of its camera.
  /// `gaze` is absent where the head is not to be moved. Without `budget` nothing is left out.
  Loop(Clock& clock, EventSource& events, HeadPort* head, const MountedCamera& camera,
       std::vector<LoopDetector> detectors, std::optional<LoopGaze> gaze, Eye eye = Eye::left,
       std::optional<LoopBudget> budget = std::nullopt);

  /// Waits for t_us (later than the last one) and does one tick. `ended` when the world has no more: after
  /// the tick with the last events, or at once, without a tick. `lost` ends the tick where it is met; lost() names what.
  PortStatus tick(std::int64_t t_us, LoopObserver& observer);
  /// "clock", "event camera", "head" or "gaze controller" once the connection to it is lost; empty before.
  [[nodiscard]] std::string_view lost() const { return lost_; }

  /// From the next tick on `motion` moves the head. Only with a gaze.
  void take_over(LoopMotion motion);
  /// From now on nothing is sent to the head; detectors and gate go on.
  void let_go();

  /// For a person who tries things while it runs, from the next tick on. Whatever is not said stays as it is: the
  /// head's motion goes on from where it is, and a new controller is told the target that the last one follows.
  void set_detectors(std::vector<LoopDetector> detectors, std::optional<std::size_t> driver);
  void set_gate(std::unique_ptr<GazeGate> gate);
  /// Only where a controller of ours moves the head.
  void set_controller(std::unique_ptr<GazeController> controller);

  [[nodiscard]] std::span<const LoopDetector> detectors() const { return detectors_; }
  /// LoopStereo's; null where there is none.
  [[nodiscard]] const Detector* right_detector() const {
    return gaze_ && gaze_->stereo ? gaze_->stereo->detector.get() : nullptr;
  }

 private:
  /// What a detector makes of events; time comes to now_us where it is given.
  [[nodiscard]] static DetectorTick ask(Detector& detector, std::span<const Event> events,
                                        std::optional<std::int64_t> now_us, const CameraMotion* motion);
  void drive(std::int64_t t_us, const CameraMotion& motion, Tick& tick);
  void see_with_both_eyes(std::int64_t t_us, const CameraMotion* motion, Tick& tick);
  PortStatus act(double dt_s, Tick& tick);
  [[nodiscard]] static TargetStatus judge_target(const Tick& tick);
  void watch_target(Tick& tick);
  PortStatus note_lost(PortStatus status, std::string_view what);

  Clock& clock_;
  EventSource& source_;
  HeadPort* head_;
  Eye eye_;
  Camera camera_;
  Eigen::Isometry3d eye_from_camera_;
  std::vector<LoopDetector> detectors_;
  std::optional<LoopGaze> gaze_;
  std::optional<LoopBudget> budget_;
  std::string_view lost_;
  std::vector<Event> events_;
  std::vector<Event> seen_events_;   // of them those of eye_
  std::vector<Event> other_events_;  // and those of the other eye
  std::vector<DetectorTick> results_;
  std::optional<Eigen::Vector3d> target_m_;
  std::int64_t seen_us_ = 0;
  GazePhase phase_ = GazePhase::none;
  std::int64_t last_t_us_;
  std::int64_t start_us_ = 0;      // of the gaze
  std::int64_t took_over_us_ = 0;  // the head
  bool retell_target_ = false;     // to a controller that is new
};

}  // namespace saccade
