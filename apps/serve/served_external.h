#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/serve/served_ports.h"
#include "external/robot_server.h"
#include "robot/steady_clock.h"
#include "sim/sim_robot.h"

namespace saccade {

/// A simulated robot behind the protocol of external/robot_frames.h (docs/external_robots.md).
class ServedExternal final : public ServedPorts {
 public:
  using Log = std::function<void(std::int64_t t_us, const std::string& text)>;

  /// Listens at `address`. `robot` outlives it. `log` receives a message for each client that comes or goes. Throws
  /// InputError for an address that is none, RunError if it cannot listen there.
  ServedExternal(const std::string& address, SimRobot& robot, Log log);

  [[nodiscard]] bool has_client() override { return server_.follows(); }
  void idle() override;
  void on_tick(const Tick& tick) override;
  void announce_end() override { server_.send_end(); }
  void linger() override { (void)server_.receive(); }
  void leave() override {}
  [[nodiscard]] const std::optional<Eigen::Vector3d>& target_m() const override { return target_m_; }
  [[nodiscard]] std::int64_t commands() const override { return server_.references(); }
  [[nodiscard]] int readers() const override { return server_.clients(); }
  [[nodiscard]] std::int64_t packets() const override { return packets_; }
  [[nodiscard]] std::string traffic() const override;
  [[nodiscard]] std::string opened() const override { return "the robot is at " + address_; }

 private:
  void exchange(const HeadState& state, std::span<const Event> events);

  std::string address_;
  SimRobot& robot_;
  Log log_;
  RobotServer server_;
  std::int64_t t_us_ = 0;
  SteadyClock clock_;           // the robot's, from its start on
  std::int64_t paused_us_ = 0;  // while the robot's clock went on and the simulated time did not
  std::vector<Event> shifted_;  // the events of a tick on the robot's clock
  std::int64_t events_ = 0, packets_ = 0;
  std::optional<Eigen::Vector3d> target_m_;  // none: no gaze controller is offered
};

}  // namespace saccade
