#pragma once

#include <yarp/os/Bottle.h>
#include <yarp/os/Port.h>
#include <yarp/os/PortReader.h>
#include <yarp/os/PortReport.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>

#include "robot/sender_clock.h"
#include "robot/steady_clock.h"

namespace saccade {

/// The envelope of the message that is being read: when it was sent, us on the sender's clock. None where it has none or
/// says 0, as devices without a clock do.
[[nodiscard]] std::optional<std::int64_t> sent_us(yarp::os::ConnectionReader& reader);

/// A port of ours that one of the robot's streams a few numbers to, and what came last.
class StateInput final : private yarp::os::PortReader, private yarp::os::PortReport {
 public:
  static constexpr int most_values = 12;

  /// What came last. Not finite where nothing came.
  struct State {
    std::int64_t t_us = 0;  ///< on our clock
    int count = 0;          ///< how many numbers there were
    std::array<double, most_values> value{};
    std::array<double, most_values> rate{};  ///< per second, from the last two messages
  };

  /// Opens `local` and connects `remote` to it. Throws RunError where `local` cannot be opened.
  StateInput(const std::string& local, std::string remote, const std::string& carrier, double timeout_s,
             const SteadyClock& clock);
  ~StateInput() override;
  StateInput(const StateInput&) = delete;
  StateInput& operator=(const StateInput&) = delete;

  [[nodiscard]] const std::string& remote() const { return remote_; }
  /// Nothing came so far: count is 0.
  [[nodiscard]] State state() const;
  /// The connection never was, or closed.
  [[nodiscard]] bool lost() const { return lost_; }

 private:
  bool read(yarp::os::ConnectionReader& reader) override;
  void report(const yarp::os::PortInfo& info) override;

  std::string remote_;
  const SteadyClock& clock_;
  yarp::os::Port port_;
  std::atomic<bool> lost_ = false;
  yarp::os::Bottle message_;
  mutable std::mutex mutex_;
  SenderClock sender_;
  std::optional<std::int64_t> last_sent_us_;
  State state_;
};

}  // namespace saccade
