#pragma once

#include <yarp/dev/IControlLimits.h>
#include <yarp/dev/IControlMode.h>
#include <yarp/dev/IEncodersTimed.h>
#include <yarp/dev/IPositionDirect.h>
#include <yarp/dev/PolyDriver.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "robot/binary_semaphore.h"
#include "robot/latest_value.h"
#include "robot/reference_outlet.h"
#include "robot/robot.h"
#include "robot/steady_clock.h"
#include "robot/yarp/state_input.h"
#include "robot/yarp/yarp_config.h"
#include "robot/yarp/yarp_network.h"

namespace saccade {

/// For threads of YARP that nobody can end: from now on std::exit() ends the program before global objects are destroyed and
/// the code of YARP's devices is unloaded, which these threads use. Streams of <cstdio> are flushed; the exit status stays.
void end_without_destructors();

/// Runs a request that can block in a separate thread. Returns true if `ask` returned true in time. `ask` can outlive the
/// call, so it must own what it uses; without an answer in time the program ends as after end_without_destructors().
[[nodiscard]] bool answered_within(double timeout_s, std::function<bool()> ask);

/// Reads the torso joints from state:o of their board (deg, in the order of HeadModel::torso_motors). Without a board the
/// torso is upright.
class TorsoInput {
 public:
  TorsoInput(const YarpConfig& config, const HeadModel& head, const SteadyClock& clock);
  /// Fills the torso joints of a state. The time of the state becomes that of the older reading.
  void read(HeadState& state) const;
  [[nodiscard]] bool lost() const { return input_ != nullptr && input_->lost(); }
  [[nodiscard]] std::vector<StartUpCheck> check() const;

 private:
  std::vector<int> motors_;  // slots, in the order of the board
  std::unique_ptr<StateInput> input_;
};

/// Controls the joints of neck and eyes through their control board, whose axes are those joints in the order of the
/// head's description. Converts between degrees and radians.
///
/// read(), drives(), command(), stop() and halt() use memory alone: threads of this class exchange it with YARP, so that
/// none of them waits for the network or for a lock. One thread sends the newest reference at once; YARP drops a message
/// without notice while the previous one is still being sent, so the last reference is sent three more times if no other
/// follows within 3 ms. This way a stop command arrives. Another thread reads speeds and modes of the joints every 5 ms.
class YarpHead final : public HeadPort {
 public:
  YarpHead(const YarpConfig& config, const JointLimits& limits, const SteadyClock& clock);
  ~YarpHead() override;
  YarpHead(const YarpHead&) = delete;
  YarpHead& operator=(const YarpHead&) = delete;

  [[nodiscard]] JointLimits limits() const override { return limits_; }
  PortStatus read(HeadState& state) override;
  [[nodiscard]] HeadDrives drives() const override;
  CommandResult command(const HeadCommand& reference_rad) override;
  PortStatus stop() override;

  [[nodiscard]] std::vector<StartUpCheck> check();
  void activate();
  void release();
  /// Robot::halt.
  void halt();
  /// HeadStopper::stop: the joints in position-direct mode hold, and change to position mode.
  [[nodiscard]] bool take_over();
  [[nodiscard]] bool is_lost();
  /// Whether it is connected and its readings are new.
  [[nodiscard]] bool answers();

 private:
  /// Of both the first joints_ elements count.
  using Modes = std::array<int, gaze_slots>;
  using Degrees = ReferenceOutlet::Degrees;

  /// The state that request threads share. It keeps YARP initialised until the last of them ends.
  struct Board {
    yarp::os::Network network;
    yarp::dev::PolyDriver driver;
    yarp::dev::IEncodersTimed* encoders = nullptr;
    yarp::dev::IControlLimits* limits = nullptr;
    yarp::dev::IControlMode* modes = nullptr;
    yarp::dev::IPositionDirect* references = nullptr;
    int axes = 0;
    std::array<Degrees, 2> limits_deg{};
  };

  /// What the board streams of its joints besides positions.
  struct Reports {
    Degrees speed_deg_s{};
    bool has_speeds = false;
    Modes modes{};
    bool has_modes = false;
  };

  [[nodiscard]] std::span<const int> used(const Modes& modes) const {
    return std::span(modes).first(static_cast<std::size_t>(joints_));
  }
  [[nodiscard]] bool open_board(const YarpConfig& config);
  void read_reports();
  /// The modes as the board streams them; none if it does not.
  [[nodiscard]] std::optional<Modes> modes() const;
  /// Sets the mode of the joints at which `wanted` differs from `now`, and of no others.
  [[nodiscard]] bool set_modes(const Modes& now, const Modes& wanted) const;
  [[nodiscard]] Degrees in_degrees(const HeadCommand& reference_rad) const;
  void send(const HeadCommand& reference_rad);
  void send_references();
  void set_positions(const Degrees& reference_deg) const;
  [[nodiscard]] std::optional<HeadCommand> stop_reference() const;

  std::string part_;
  double timeout_s_;
  const SteadyClock& clock_;
  JointLimits limits_;
  int joints_;  // that gaze commands
  StateInput state_input_;
  TorsoInput torso_;
  std::shared_ptr<Board> board_;  // null where it cannot be opened
  std::unique_ptr<OutputWatch> commands_;
  StartUpCheck limits_check_;
  Modes found_modes_{};
  bool active_ = false;
  std::atomic<bool> lost_ = false;
  std::mutex reports_mutex_;  // of those who write reports_: the reporter, and activate()
  LatestValue<Reports> reports_;
  ReferenceOutlet outlet_;
  BinarySemaphore to_send_;  // a reference to send
  std::atomic<bool> sends_ = true;
  std::atomic<bool> repeats_ = false;
  std::unique_ptr<Periodic> reporter_;
  std::thread sender_;
};

}  // namespace saccade
