#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "loop/loop.h"

namespace saccade {

/// What offers a simulated robot to clients: an observer that exchanges data between them and the robot after each tick.
class ServedPorts : public LoopObserver {
 public:
  /// Whether a client reads the camera and has taken the head.
  [[nodiscard]] virtual bool has_client() = 0;
  /// A tick while the simulation stands still.
  virtual void idle() = 0;
  /// The run is over as planned.
  virtual void announce_end() = 0;
  /// After announce_end(), every millisecond: answers clients that release the head.
  virtual void linger() = 0;
  /// The end of the program: takes what other programs find it by. Connections end with the program; closing them could wait
  /// for a client for ever.
  virtual void leave() = 0;
  /// Target of the gaze controller on the ports, m, root frame; none without one.
  [[nodiscard]] virtual const std::optional<Eigen::Vector3d>& target_m() const = 0;
  [[nodiscard]] virtual std::int64_t commands() const = 0;
  [[nodiscard]] virtual int readers() const = 0;
  [[nodiscard]] virtual std::int64_t packets() const = 0;
  /// Counts of events, packets, commands and requests so far, in one line.
  [[nodiscard]] virtual std::string traffic() const = 0;
  /// "/icub/head, ... are open".
  [[nodiscard]] virtual std::string opened() const = 0;
};

}  // namespace saccade
