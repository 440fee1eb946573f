#pragma once

#include <cstdint>
#include <memory>

namespace saccade {

/// Stands before every socket that YARP listens on in this process, those of its administration too, while an object of this
/// class exists: YARP's acceptor gets clients from here. One thread reads what clients send and passes on what ClientStream
/// accepts. Who sends anything else, does not introduce itself within 2 s or leaves a message half for 5 s loses the
/// connection. YARP has a thread for each connection; the gate bounds them: at most most_clients at a time, and 50 new ones a
/// second (200 at once) for each port. Others wait in the queue of the operating system.
///
/// Connections within the process pass unchecked. The program's own `accept` replaces that of the C library, which YARP calls.
/// At most one at a time.
class PortGate {
 public:
  static constexpr int most_clients = 128;
  /// Connections that have not introduced themselves; the oldest of more is closed.
  static constexpr int most_strangers = 32;

  /// Starts the thread, with the priority of this one. Throws RunError where the operating system gives no socket.
  PortGate();
  /// Closes every connection of clients, so that YARP waits for none of them.
  ~PortGate();
  PortGate(const PortGate&) = delete;
  PortGate& operator=(const PortGate&) = delete;

  struct Traffic {
    std::int64_t clients = 0;  ///< passed on to YARP so far
    std::int64_t refused = 0;  ///< closed so far, for what they sent or did not send
  };
  [[nodiscard]] Traffic traffic() const;

  /// For accept(): the next connection to a socket that listens, waiting for it; no_gate where no gate stands before it.
  static int next_connection(int listener);
  static constexpr int no_gate = -2;

 private:
  struct Current;
  class Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace saccade
