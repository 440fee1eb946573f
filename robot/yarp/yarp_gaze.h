#pragma once

#include <yarp/os/Bottle.h>
#include <yarp/os/BufferedPort.h>
#include <yarp/os/PortReport.h>
#include <yarp/os/RpcClient.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "robot/binary_semaphore.h"
#include "robot/robot.h"
#include "robot/steady_clock.h"
#include "robot/yarp/state_input.h"
#include "robot/yarp/yarp_config.h"
#include "robot/yarp/yarp_network.h"

namespace saccade {

/// The client of iKinGazeCtrl or of a server with its interface: sends targets, and reads the head state from the joints
/// that the server streams.
class YarpGaze final : public GazePort, public HeadPort, private yarp::os::PortReport {
 public:
  YarpGaze(const YarpConfig& config, const JointLimits& limits, const SteadyClock& clock);
  ~YarpGaze() override;

  PortStatus look_at(const Eigen::Vector3d& target_m) override;
  /// Stops gaze and head. The request is sent in a separate thread.
  PortStatus stop() override;
  /// Sends the newest target if it had to wait. Call once per tick.
  void flush();

  [[nodiscard]] JointLimits limits() const override { return limits_; }
  PortStatus read(HeadState& state) override;
  /// Always rejected: the gaze controller commands the joints.
  CommandResult command(const HeadCommand& reference_rad) override;

  [[nodiscard]] std::vector<StartUpCheck> check();
  void activate();
  void release();
  /// Robot::halt.
  void halt();
  /// HeadStopper::stop.
  [[nodiscard]] bool take_over() { return ask("stop").has_value(); }
  [[nodiscard]] bool is_lost();
  /// Whether it is connected and its readings are new.
  [[nodiscard]] bool answers();

 private:
  /// The answer after [ack]; none for [nack] or without an answer in time.
  [[nodiscard]] std::optional<yarp::os::Bottle> ask(const std::string& request);
  [[nodiscard]] std::string settings_refused();
  void report(const yarp::os::PortInfo& info) override;
  void stop_when_told();

  YarpGazeConfig config_;
  const SteadyClock& clock_;
  JointLimits limits_;
  StateInput joints_;
  yarp::os::BufferedPort<yarp::os::Bottle> targets_;
  OutputCount request_outputs_;  // outlives the port
  yarp::os::RpcClient requests_;
  std::atomic<bool> lost_ = false;
  bool active_ = false;
  std::optional<std::int64_t> context_;  // what the settings were
  std::optional<Eigen::Vector3d> waiting_m_;
  std::int64_t sent_us_;
  std::mutex ask_mutex_;  // one request at a time
  BinarySemaphore stop_wanted_;
  std::atomic<bool> halted_ = false;
  std::atomic<bool> ending_ = false;
  std::thread stopper_;
};

}  // namespace saccade
