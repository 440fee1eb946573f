#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "config/scenario.h"
#include "control/gaze_controller.h"
#include "control/joint_limiter.h"
#include "loop/loop.h"
#include "python/object_parts.h"
#include "session/observations.h"
#include "sim/sim_robot.h"

namespace saccade::python {

/// A scenario in lockstep: time passes in step() only, by one tick of 1 ms. It uses the simulator as `saccade run` does, so
/// that the same scenario, seed and commands give the same events.
///
/// Who moves the head: with `closed_loop` the scenario's own detectors and gaze. Without it only command() and look_at();
/// before the first of them the head keeps its initial pose.
class Simulation final : private LoopObserver {
 public:
  /// `errors`: of the scenario's parts that are Python objects. Throws InputError and RunError as SimRobot does.
  Simulation(Scenario scenario, bool closed_loop, std::shared_ptr<ObjectErrors> errors);

  /// From the next step() on the references of the six head joints, rad, until the next command() or look_at(). Only
  /// without `closed_loop`. Returns false, and changes nothing, where the head rejects them (is_allowed).
  bool command(const HeadCommand& reference_rad);
  /// From the next step() on the scenario's gaze controller turns the eyes to this point, root frame, m, until command().
  /// Only without `closed_loop`. Throws InputError where the controller follows no targets. Returns the target's status.
  TargetStatus look_at(const Eigen::Vector3d& target_m);

  /// So many ticks, fewer where the scenario ends. Throws what a part in Python raised.
  void step(std::int64_t ticks);

  [[nodiscard]] const Scenario& scenario() const { return scenario_; }
  [[nodiscard]] const SimRobot& robot() const { return robot_; }
  /// The scene from outside, sRGB, height x width x 3.
  void draw_scene(ImageSize size, std::span<std::uint8_t> rgb) {
    robot_.draw_scene(profile_view(), size, rgb);
  }
  /// Events of the newest step; takes them.
  [[nodiscard]] std::vector<Event> take_events() { return std::move(events_); }
  [[nodiscard]] const HeadState& head() const { return head_; }
  /// The newest references that the head accepted; none before the first.
  [[nodiscard]] const std::optional<HeadCommand>& reference_rad() const { return reference_rad_; }
  /// Observations of the scenario's detectors in the newest tick, not valid where there is none; empty without
  /// `closed_loop`.
  [[nodiscard]] const std::vector<std::pair<std::string, Estimate>>& detectors() const { return detectors_; }
  /// Newest accepted target, root frame.
  [[nodiscard]] const std::optional<Eigen::Vector3d>& target_m() const { return target_m_; }

 private:
  void on_tick(const Tick& tick) override;
  void refuse_in_closed_loop(const char* what) const;
  void step_controller();
  void tick();

  Scenario scenario_;
  std::shared_ptr<ObjectErrors> errors_;
  SimRobot robot_;
  Loop loop_;  // without detectors and gaze unless closed_loop_
  bool closed_loop_;
  Observations observations_;
  bool moves_head_ = false;  // the loop sends references in each tick
  std::unique_ptr<GazeController> controller_;
  std::optional<JointLimiter> limiter_;
  bool following_ = false;                       // the controller moves the head
  std::optional<Eigen::Vector3d> new_target_m_;  // for the controller's next step
  std::vector<Event> events_;
  HeadState head_;
  std::optional<HeadCommand> reference_rad_;
  std::optional<Eigen::Vector3d> target_m_;
  std::vector<std::pair<std::string, Estimate>> detectors_;
};

}  // namespace saccade::python
