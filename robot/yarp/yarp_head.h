#pragma once

#include <yarp/dev/IControlLimits.h>
#include <yarp/dev/IControlMode.h>
#include <yarp/dev/IEncodersTimed.h>
#include <yarp/dev/IPositionDirect.h>
#include <yarp/dev/PolyDriver.h>

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "robot/robot.h"
#include "robot/steady_clock.h"
#include "robot/stop_reference.h"
#include "robot/yarp/state_input.h"
#include "robot/yarp/yarp_config.h"
#include "robot/yarp/yarp_network.h"

namespace saccade {

/// Runs a request that can block in a separate thread. Returns true if `ask` returned true in time. `ask` can outlive the
/// call, so it must own what it uses.
[[nodiscard]] bool answered_within(double timeout_s, std::function<bool()> ask);

/// Reads the three torso joints from state:o of their board (yaw, roll, pitch, deg) in the order of Joint. Without a board
/// the torso is upright.
class TorsoInput {
 public:
  TorsoInput(const YarpConfig& config, const SteadyClock& clock);
  /// Fills the torso joints of a state. The time of the state becomes that of the older reading.
  void read(HeadState& state) const;
  [[nodiscard]] bool lost() const { return input_ != nullptr && input_->lost(); }
  [[nodiscard]] std::vector<StartUpCheck> check() const;

 private:
  std::unique_ptr<StateInput> input_;
};

/// Controls the six head joints through their control board. Converts between degrees and radians.
///
/// YARP drops a message without notice while the previous one is still being sent. So the last references are sent three
/// more times if no others follow within 3 ms. This way a stop command arrives.
class YarpHead final : public HeadPort {
 public:
  YarpHead(const YarpConfig& config, const JointLimits& limits, const SteadyClock& clock);
  ~YarpHead() override;

  [[nodiscard]] JointLimits limits() const override { return limits_; }
  PortStatus read(HeadState& state) override;
  CommandResult command(const HeadCommand& reference_rad) override;
  PortStatus stop() override;

  [[nodiscard]] std::vector<StartUpCheck> check();
  void activate();
  void release();

 private:
  using Modes = std::array<int, head_joint_count>;
  using Degrees = std::array<double, head_joint_count>;

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

  [[nodiscard]] bool open_board(const YarpConfig& config);
  [[nodiscard]] bool is_lost();
  /// The modes as the board streams them; none if it does not.
  [[nodiscard]] std::optional<Modes> modes() const;
  [[nodiscard]] bool set_modes(const Modes& modes) const;
  void send(const HeadCommand& reference_rad);
  void send_again();
  [[nodiscard]] StartUpCheck limits_check() const;

  std::string part_;
  double timeout_s_;
  const SteadyClock& clock_;
  JointLimits ours_;
  JointLimits limits_;
  StateInput state_input_;
  TorsoInput torso_;
  std::shared_ptr<Board> board_;  // null where it cannot be opened
  std::unique_ptr<OutputWatch> commands_;
  std::mutex send_mutex_;  // of the three that follow
  Degrees sent_deg_{};
  std::int64_t sent_us_ = 0;
  int repeats_left_ = 0;
  Modes found_modes_{};
  StopReference stop_reference_;
  bool active_ = false;
  bool lost_ = false;
  std::unique_ptr<Periodic> repeater_;
};

}  // namespace saccade
