#pragma once

#include <yarp/os/Port.h>
#include <yarp/os/PortReader.h>
#include <yarp/os/PortReport.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include "robot/latest_value.h"
#include "robot/sender_clock.h"
#include "robot/steady_clock.h"

namespace saccade {

/// Age below which a reading counts as new in start-up checks.
inline constexpr std::int64_t fresh_us = 200'000;

/// The time of sending from the envelope of the current message, us on the clock of the sender. None without an envelope,
/// or if the time is 0, as from devices without a clock.
[[nodiscard]] std::optional<std::int64_t> sent_us(yarp::os::ConnectionReader& reader);

/// An input port for a stream of a few numbers from the robot. Stores the newest message of `remote`; messages of other
/// senders, and those that are not a short list of numbers, are counted and discarded. A message that does not end, or
/// that claims a false count, has no effect on who reads the state.
class StateInput final : private yarp::os::PortReader, private yarp::os::PortReport {
 public:
  static constexpr int most_values = 12;

  /// The newest message. Values are not finite where none was received.
  struct State {
    std::int64_t t_us = 0;  ///< on the local clock
    int count = 0;          ///< of numbers in the message
    std::array<double, most_values> value{};
    std::array<double, most_values> rate{};  ///< per second, from the last two messages
  };

  /// Opens `local` and connects `remote` to it. Throws RunError if `local` cannot be opened.
  StateInput(const std::string& local, std::string remote, const std::string& carrier, double timeout_s,
             const SteadyClock& clock);
  ~StateInput() override;
  StateInput(const StateInput&) = delete;
  StateInput& operator=(const StateInput&) = delete;

  [[nodiscard]] const std::string& remote() const { return remote_; }
  /// The newest message; count is 0 before the first.
  [[nodiscard]] State state() const { return state_.read(); }
  /// True if the connection was never made, or is closed.
  [[nodiscard]] bool lost() const { return lost_; }
  /// Messages discarded so far.
  [[nodiscard]] std::int64_t discarded() const { return discarded_; }

 private:
  bool read(yarp::os::ConnectionReader& reader) override;
  void report(const yarp::os::PortInfo& info) override;

  std::string remote_;
  const SteadyClock& clock_;
  yarp::os::Port port_;
  std::atomic<bool> lost_ = false;
  std::atomic<std::int64_t> discarded_ = 0;
  LatestValue<State> state_;
  std::mutex mutex_;  // of the threads of YARP, each with a whole message: of what follows
  SenderClock sender_;
  std::optional<std::int64_t> last_sent_us_;
};

}  // namespace saccade
