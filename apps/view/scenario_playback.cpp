#include <cmath>
#include <functional>
#include <optional>

#include "apps/view/detector_change.h"
#include "apps/view/playback.h"
#include "apps/view/sim_snapshot.h"
#include "config/scenario.h"
#include "session/scenario_loop.h"
#include "session/session.h"
#include "sim/sim_robot.h"

namespace saccade {
namespace {

class ScenarioPlayback final : public Playback, private LoopObserver {
 public:
  explicit ScenarioPlayback(const Scenario& scenario)
      : scenario_(scenario),
        settings_(view_settings(scenario.detectors, scenario.gaze.detector)),
        history_(empty_history()) {
    if (moves_head()) settings_.controller = scenario.gaze.controller;
    if (has_driver()) settings_.gate = scenario.gaze.gate;
    restart();
    model_ = copy_of_model(robot_->world());
  }

  [[nodiscard]] const LoopHistory& history() const override { return history_; }

  bool tick() override {
    const std::int64_t t_us = history_.now_us() + tick_us;
    if (t_us > history_.end_us()) return false;
    return session_->tick(t_us);
  }

  void restore_before(std::int64_t t_us) override {
    if (t_us <= history_.now_us()) restart();
  }

  void apply(const ViewSettings& settings) override {
    ChangedDetectors changed =
        change_detectors(settings, settings_, *loop_, history_, scenario_.calibration, Eye::left);
    const std::size_t selected = settings.selected_in_loop();
    std::unique_ptr<GazeController> controller;
    std::unique_ptr<GazeGate> gate;
    const bool gaze_changed =
        resolved_scenario(with_gaze(settings)) != resolved_scenario(with_gaze(settings_)) ||
        settings.selected_name() != settings_.selected_name();
    if (gaze_changed) {
      if (settings.controller)
        controller = make_gaze_controller(*settings.controller, aiming_limits(scenario_, robot_->limits()));
      if (settings.gate) gate = make_gate(*settings.gate);
    }
    loop_->set_detectors(std::move(changed.detectors), has_driver() ? std::optional(selected) : std::nullopt);
    if (controller) loop_->set_controller(std::move(controller));
    if (gate) loop_->set_gate(std::move(gate));
    history_.replace_outputs(std::move(changed.outputs), selected);
    settings_ = settings;
  }

  void fill(Snapshot& snapshot) override {
    history_.fill(snapshot, *loop_);
    fill_simulated(*robot_, model_, snapshot);
  }

  [[nodiscard]] const ViewSettings& settings() const override { return settings_; }
  [[nodiscard]] std::vector<float> event_counts() const override { return {}; }

 private:
  void on_tick(const Tick& tick) override {
    history_.record(tick, simulated_truth(*robot_, scenario_.sim.camera, tick), *loop_,
                    settings_.selected_in_loop());
  }

  [[nodiscard]] bool has_driver() const { return scenario_.gaze.detector != "none"; }
  [[nodiscard]] bool moves_head() const {
    return has_driver() || !scenario_.gaze.controller.follows_targets();
  }
  [[nodiscard]] LoopHistory empty_history() const {
    return {scenario_.sim.camera, Eye::left, 0, std::llround(scenario_.run.duration_s * 1e3) * tick_us};
  }
  /// The scenario with the controller and the gate of the settings.
  [[nodiscard]] Scenario with_gaze(const ViewSettings& settings) const {
    Scenario scenario = scenario_;
    if (settings.controller) scenario.gaze.controller = *settings.controller;
    if (settings.gate) scenario.gaze.gate = *settings.gate;
    return scenario;
  }

  /// Starts the simulation again with the settings of now.
  void restart() {
    Scenario scenario = with_gaze(settings_);
    scenario.detectors = settings_.enabled();
    if (has_driver()) scenario.gaze.detector = settings_.selected_name();
    std::vector<LoopDetector> detectors = make_detectors(scenario.detectors, scenario.calibration.camera);
    std::optional<LoopGaze> gaze;
    if (robot_) gaze = make_gaze(scenario, robot_->limits());
    session_.reset();
    loop_.reset();
    robot_ = std::make_unique<SimRobot>(scenario.sim, static_cast<std::uint64_t>(scenario.seed));
    if (!model_) gaze = make_gaze(scenario, robot_->limits());  // for the first time
    loop_.emplace(make_loop(scenario, *robot_, std::move(detectors), std::move(gaze)));
    session_.emplace(*robot_, *loop_).add_observer(*this);
    history_ = empty_history();
  }

  Scenario scenario_;
  ViewSettings settings_;
  LoopHistory history_;
  std::unique_ptr<SimRobot> robot_;
  std::shared_ptr<const mjModel> model_;  // the same after each restart
  std::optional<Loop> loop_;
  std::optional<Session> session_;
};

}  // namespace

std::unique_ptr<Playback> make_scenario_playback(const Scenario& scenario) {
  return std::make_unique<ScenarioPlayback>(scenario);
}

}  // namespace saccade
