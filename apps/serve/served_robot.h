#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/serve/gaze_server.h"
#include "apps/serve/serve_session.h"
#include "apps/serve/served_ports.h"
#include "config/scenario.h"
#include "loop/loop.h"
#include "robot/yarp/control_board.h"
#include "robot/yarp/event_port.h"
#include "robot/yarp/gaze_ports.h"
#include "robot/yarp/port_gate.h"
#include "sim/sim_robot.h"

namespace saccade {

/// A simulated robot on YARP ports: an observer that exchanges data between the ports and the robot after each tick.
class ServedRobot final : public ServedPorts {
 public:
  using Log = std::function<void(std::int64_t t_us, const std::string& text)>;

  /// Opens the ports. All references outlive it. `log` receives a message for each change on the ports. Throws
  /// InputError for an unknown format or codec, RunError if a port cannot be opened.
  ServedRobot(const ServeOptions& options, const Scenario& scenario, SimRobot& robot, Log log);
  ~ServedRobot() override { gate_.reset(); }
  ServedRobot(const ServedRobot&) = delete;
  ServedRobot& operator=(const ServedRobot&) = delete;

  /// Whether a client reads the camera, and one has set a mode or sent a command or a gaze request.
  [[nodiscard]] bool has_client() override;
  /// A tick while the simulation stands still.
  void idle() override;
  void on_tick(const Tick& tick) override;
  /// The run is over as planned: announces the end of the camera.
  void announce_end() override;
  /// Takes the names of all ports from the name server. The ports stay open; closing them, YARP can wait for a client for
  /// ever, and YARP 3.12 can end the program with a segmentation fault.
  void leave() override;
  /// After announce_end(), every millisecond: the boards answer clients that release the head.
  void linger() override { (void)step_boards(last_state_, 0.0); }

  /// Target of the gaze controller, m, root frame; none before the first.
  [[nodiscard]] const std::optional<Eigen::Vector3d>& target_m() const override { return target_m_; }
  [[nodiscard]] std::int64_t commands() const override { return head_.use().commands; }
  [[nodiscard]] int readers() const override { return camera_.readers(); }
  [[nodiscard]] std::int64_t packets() const override { return camera_.messages(); }
  /// Counts of events, packets, commands and requests so far, in one line.
  [[nodiscard]] std::string traffic() const override;
  [[nodiscard]] std::string opened() const override { return opened_; }

 private:
  HeadCommand step_boards(const HeadState& state, double dt_s);
  void send_gaze_reports();
  void log_changes();

  std::string opened_;
  SimRobot& robot_;
  Log log_;
  std::optional<PortGate> gate_{std::in_place};  // there before the ports; closes first
  std::vector<std::string> port_names_;
  GazeServer gaze_;
  YarpEventPort camera_;
  YarpControlBoard head_;
  YarpControlBoard torso_;
  YarpGazePorts gaze_ports_;
  HeadState last_state_;
  std::int64_t t_us_ = 0;
  std::int64_t paused_us_ = 0;  // while the camera's clock went on and the simulated time did not
  std::vector<Event> shifted_;  // the events of a tick on the camera's clock
  std::int64_t ticks_ = 0;
  std::int64_t events_ = 0;
  std::int64_t requests_ = 0;
  std::optional<Eigen::Vector3d> target_m_;
  std::vector<std::string> pending_events_;  // of the gaze controller, until the next report
  int readers_ = 0;
  std::int64_t commands_ = 0;
  std::int64_t commanded_us_ = 0;
  bool commanded_ = false;
  bool has_target_ = false;
};

}  // namespace saccade
