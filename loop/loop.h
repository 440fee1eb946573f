#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "control/fixational_movement.h"
#include "control/gaze_controller.h"
#include "control/gaze_gate.h"
#include "control/hunting_detector.h"
#include "control/image_rotation.h"
#include "control/joint_limiter.h"
#include "core/detector.h"
#include "loop/delays.h"
#include "loop/detector_runner.h"
#include "loop/latency.h"
#include "loop/seen_heads.h"
#include "robot/robot.h"
#include "threads/worker_threads.h"

namespace saccade {

/// A detector in the loop. All detectors get the events of the same eye; the driving one supplies the gaze targets, the
/// others (shadow detectors) run for comparison.
struct LoopDetector {
  std::string name;
  std::unique_ptr<Detector> detector;
};

/// Stereo: a second instance of the driving detector on the right eye's events, and the triangulation of both.
struct LoopStereo {
  std::unique_ptr<Detector> detector;
  MountedCamera camera;  ///< assumed calibration of the right eye
  StereoLocator locator;
};

/// Source of head motion: a gaze controller with its limiter, or the robot's own controller behind `port`.
struct LoopMotion {
  std::unique_ptr<GazeController> controller;
  std::optional<JointLimiter> limiter;  ///< of the controller's references
  GazePort* port = nullptr;             ///< instead of controller and limiter: receives the targets
  /// Duration over which the speed limit grows linearly from 0 to its full value; a port gets no target during it.
  double ramp_in_s = 0.0;
};

/// Everything between detections and head motion.
struct LoopGaze {
  std::optional<std::size_t> driver;  ///< index of the driving detector; none: no targets
  std::unique_ptr<GazeGate> gate;     ///< turns the driving detector's estimates into targets
  std::optional<LoopMotion> motion;   ///< none: the loop sends nothing until Loop::set_motion
  FollowConfig follow;
  std::optional<LoopStereo> stereo = std::nullopt;  ///< needs a driver
};

/// Limits of the work in one tick, so that no queue grows under overload. Deterministic for a given clock.
///
///   1. Detectors get the newest `max_events` of the waiting events; older ones are recorded and not detected on.
///   2. The driving detector runs first, the command to the head follows at once.
///   3. Shadow detectors run afterwards, in their order, while the tick is younger than `shadows_until_us`. A skipped
///      detector never gets the events of that tick.
///   4. A tick that comes late has several ms to make up for. Work that only serves later estimates is done for the last
///      `work_us` of them alone (Detector::leave_out_work_before): with that of all, a late tick would make the next one later.
struct LoopBudget {
  std::size_t max_events = 0;
  std::int64_t shadows_until_us = 0;
  std::int64_t work_us = 2'000;
};

/// State of the gaze.
enum class GazePhase {
  none,       ///< no driving detector
  searching,  ///< no target so far, or the head looks around for a lost one
  following,  ///< the newest target is not lost
  holding,    ///< target lost; the head keeps looking at its last position
  resting,    ///< target lost; the head moves to its neutral pose
};

/// Result of one tick; valid until the next one.
struct Tick {
  std::int64_t t_us = 0;
  std::span<const Event> events;    ///< delivered in this tick, of both eyes
  std::size_t events_left_out = 0;  ///< how many of them, from the first on, no detector got (LoopBudget)
  std::span<const DetectorTick> detectors;  ///< in the order of Loop::detectors()
  std::optional<DetectorTick> right;        ///< of LoopStereo's detector
  /// Encoder reading. While it is not finite no detector runs, nothing is followed and the head holds.
  std::optional<HeadState> head;
  std::optional<Eigen::Vector3d> new_target_m;      ///< target of this tick, root frame
  std::optional<Eigen::Vector3d> target_m;          ///< newest accepted target so far, root frame
  TargetStatus target_status = TargetStatus::none;  ///< whether new_target_m was accepted
  RejectedTargets rejected;                         ///< by the gate so far
  GazePhase phase = GazePhase::none;
  std::int64_t target_us = 0;  ///< time of target_m
  JointLimiter::Result
      command;  ///< reference to the head, sent at once without a latency; which limits acted
  bool command_rejected = false;  ///< by the head
  double slowdown = 1.0;          ///< of the controller's time constants, see FollowConfig::detect_hunting
  double hunting_hz = 0.0;        ///< frequency of the oscillation that was found in this tick; 0: none
  GazeDelays delays;              ///< that the controller compensates
  std::int64_t acted_us = 0;      ///< clock after the command or target was sent
  std::int64_t step_ns = 0;       ///< time of the controller's step
};

class LoopObserver {
 public:
  virtual ~LoopObserver() = default;
  virtual void on_tick(const Tick& tick) = 0;
};

/// The closed loop: each tick reads events and joints, runs the detectors, and sends a command to the head. It works
/// through the ports of a Robot alone, so it is the same for the simulator, a recording and a real robot.
///
/// Events may arrive late, in packets that span several milliseconds. Detectors get late events in slices of 1 ms that end
/// whole milliseconds before the tick; the estimate after a slice is about the slice's end. The gate gets the estimate
/// after each slice, so that results do not depend on how events were packed. With a budget shadow detectors get all
/// events of a tick at once.
///
/// With FollowConfig::delay.sight the detectors get the motion of the camera, and the gate its pose, at the instant that the
/// events are about; without it those of the tick in which the detector begins. Controllers get the age of the targets and
/// the delay of the joints (GazeController::set_delays).
///
/// With a LatencyConfig the loop is that of a robot whose parts take time. Events reach the detectors after the delay of
/// transport. Each detector has its own queue and processor (DetectorRunner). The gate gets an estimate in the tick in which
/// it is ready, with the pose of the camera when the detector began. The head gets a command in the first tick in
/// which it is ready: after the estimate, the step of the controller and the delay of actuation. The clock of the
/// robot is not affected.
///
/// With several threads shadow detectors run beside the driving one and the controller, and what detectors can do before
/// the next events (Detector::work_ahead) beside Clock::wait_until(). With one thread both come after the command. Results
/// do not depend on the number of threads.
class Loop {
 public:
  /// `robot` outlives the loop; without a head (a bare recording) there is no gaze and no camera motion.
  /// Detectors get the events of `eye`, which must be the left one if there is a gaze; `camera` is its assumed
  /// calibration. Without `gaze` the loop never moves the head. Without `budget` a tick has no limit of work. A `latency`
  /// other than `none` excludes a budget and a robot with a gaze controller of its own. `threads`: that run detectors too,
  /// null with a budget; the robot may use them in Clock::wait_until() as well.
  Loop(Robot& robot, const MountedCamera& camera, std::vector<LoopDetector> detectors,
       std::optional<LoopGaze> gaze, Eye eye = Eye::left, std::optional<LoopBudget> budget = std::nullopt,
       const LatencyConfig& latency = {}, std::shared_ptr<WorkerThreads> threads = nullptr);

  /// Waits for t_us, which is later than the last tick, then does one tick and calls `observer`. Returns `ended` if
  /// no more data will come: after the tick with the last events, or without a tick. On `lost` the tick is incomplete
  /// and not observed; lost() names the port.
  PortStatus tick(std::int64_t t_us, LoopObserver& observer);
  /// "clock", "event camera", "head", "inertial sensor" or "gaze controller" after the connection to it was lost; empty before.
  [[nodiscard]] std::string_view lost() const { return lost_; }

  /// From the next tick on `motion` moves the head. Only with a gaze.
  void set_motion(LoopMotion motion);
  /// From the next tick on nothing is sent to the head; detectors and gate continue.
  void clear_motion();

  /// These replace parts of the running loop from the next tick on; all other state stays. A new controller receives
  /// the target that the old one follows.
  void set_detectors(std::vector<LoopDetector> detectors, std::optional<std::size_t> driver);
  void set_gate(std::unique_ptr<GazeGate> gate);
  /// Only while LoopMotion::controller moves the head.
  void set_controller(std::unique_ptr<GazeController> controller);

  /// The head that the gaze computes with; the default one for a robot without a head.
  [[nodiscard]] const std::shared_ptr<const HeadModel>& head() const { return model_; }
  [[nodiscard]] std::span<const LoopDetector> detectors() const { return detectors_; }
  /// What moves the head; null without a gaze, and where the robot's own controller does.
  [[nodiscard]] const GazeController* controller() const {
    return gaze_ && gaze_->motion ? gaze_->motion->controller.get() : nullptr;
  }
  /// LoopStereo's detector; null without stereo.
  [[nodiscard]] const Detector* right_detector() const {
    return gaze_ && gaze_->stereo ? gaze_->stereo->detector.get() : nullptr;
  }

 private:
  /// An estimate of the driving detector that the gate has not got yet.
  struct WaitingEstimate {
    Estimate estimate;                                                   ///< not valid: no observation
    Eigen::Isometry3d root_from_camera = Eigen::Isometry3d::Identity();  ///< when the detector began
    std::int64_t ready_us = 0;
    std::int64_t seen_us = 0;  ///< instant that the estimate is about
  };
  /// What is on its way, or not ready yet, with a latency.
  struct Latency {
    LatencyConfig config;
    TransportDelay transport;
    CommandDelay commands;
    std::vector<WaitingEstimate> driver;  ///< by time
    std::vector<WaitingEstimate> right;   ///< of the stereo detector
    WaitingEstimate newest_right;         ///< that is ready
    std::int64_t used_us = 0;  ///< when the newest estimate that the gate got in this tick was ready
  };
  void make_runners();
  void select_events(Tick& tick);
  void run_driver(std::int64_t t_us, const CameraMotion* motion, Tick& tick);
  void run_stereo(std::int64_t t_us, const CameraMotion* motion, Tick& tick);
  void run_shadows(std::int64_t t_us, const CameraMotion* motion);
  void run_shadow(std::size_t detector, std::int64_t t_us, const CameraMotion* motion);
  PortStatus wait_until(std::int64_t t_us);
  void work_ahead(std::size_t runner);
  void pass_to_gate(const WaitingEstimate& estimate, Tick& tick);
  void pass_ready_estimates(std::int64_t t_us, const CameraMotion& motion, Tick& tick);
  void update_sight_age(std::int64_t t_us);
  [[nodiscard]] const HeadState& seen_head(const Tick& tick) const;
  [[nodiscard]] Eigen::Isometry3d seen_pose(std::int64_t t_us, const CameraMotion& motion) const;
  void compensate_delays(Tick& tick);
  PortStatus stabilise(const Tick& tick, double dt_s);
  void detect_hunting(Tick& tick, double dt_s);
  void locate_with_right(const Eigen::Isometry3d& root_from_left, const Eigen::Isometry3d& root_from_right,
                         const Estimate& right, Tick& tick);
  [[nodiscard]] std::int64_t late_us(std::int64_t t_us) const;
  PortStatus send_command(Tick& tick);
  PortStatus move_head(double dt_s, Tick& tick);
  [[nodiscard]] TargetStatus check_target(const Tick& tick) const;
  void update_target(Tick& tick);
  [[nodiscard]] std::optional<Eigen::Vector3d> search_point(const Tick& tick);
  [[nodiscard]] std::optional<Eigen::Vector3d> fixational_point(const Tick& tick, double dt_s);
  PortStatus note_lost(PortStatus status, std::string_view port);

  Clock& clock_;
  EventSource& source_;
  HeadPort* head_;
  std::shared_ptr<const HeadModel> model_;  // of the head, or the default one
  ImuPort* imu_;
  Eye eye_;
  Camera camera_;
  Eigen::Isometry3d eye_from_camera_;
  std::vector<LoopDetector> detectors_;
  std::optional<LoopGaze> gaze_;
  std::optional<LoopBudget> budget_;
  std::shared_ptr<WorkerThreads> threads_;  // null: shadow detectors and work ahead come after the command
  std::vector<std::size_t> shadows_;        // the detectors that do not drive
  std::string_view lost_;
  std::vector<Event> events_;
  std::vector<Event> eye_events_;    // of them those of eye_
  std::vector<Event> other_events_;  // and those of the other eye
  std::vector<DetectorTick> results_;
  std::vector<DetectorRunner> runners_;  // of each detector, then of the stereo one
  std::optional<Latency> latency_;
  std::optional<SeenHeads> seen_heads_;  // if the age of events is compensated
  std::int64_t sight_age_us_ = 0;        // of the events of this tick
  std::int64_t detector_lag_us_ = 0;     // of the driving detector's circle behind them
  std::int64_t target_seen_us_ = 0;      // instant that the target of this tick is about
  std::optional<MotionDelayEstimator> motion_delay_;
  std::optional<FixationalMovement> fixational_;
  std::optional<Stabiliser> stabiliser_;
  std::optional<ImageRotation> image_rotation_;  // for the stabilisation
  ImuReading imu_reading_;
  HuntingDetector hunting_;
  double slowdown_ = 1.0;
  std::optional<Eigen::Vector3d> target_m_;
  std::int64_t target_us_ = 0;
  GazePhase phase_ = GazePhase::none;
  std::int64_t last_t_us_;
  std::int64_t start_us_ = 0;              // of the gaze
  std::int64_t motion_us_ = 0;             // of the motion
  bool resend_target_ = false;             // to a new controller
  std::optional<std::int64_t> search_us_;  // since when the head searches a lost target
  std::int64_t search_place_ = -1;         // the newest point of the search that was sent
};

}  // namespace saccade
