#pragma once

#include <yarp/os/ConnectionReader.h>
#include <yarp/os/Contact.h>
#include <yarp/os/Network.h>
#include <yarp/os/Port.h>
#include <yarp/os/PortInfo.h>
#include <yarp/os/PortReport.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

namespace saccade {

/// Longest wait for the answer of a name server where no configuration gives one.
inline constexpr double name_server_timeout_s = 2.0;

/// The envelope of the last message of a camera that ends as planned (saccade serve).
inline constexpr const char* end_of_camera = "end";

/// Takes a message that must not be used off its connection, in fixed memory.
void skip_message(yarp::os::ConnectionReader& reader);
/// The same, and asks YARP to close the connection.
void discard(yarp::os::ConnectionReader& reader);

/// Threads of YARP that receive events and readings run as urgently as the thread that called share_priority() last: an
/// overloaded thread of ticks with real-time priority takes a processor for itself, and its own inputs would wait for one. With
/// the same priority they run on the other one at once, and do not interrupt it. Without that right nothing changes.
void share_priority();
/// Called by such a thread with each message of the sender that is configured.
void adopt_priority();

/// Closes an input port. YARP would ask the other side first to disconnect, and wait for its answer for ever if that
/// program is halted: this side drops the connection before.
void close_input(yarp::os::Port& port, const std::string& remote);

/// The connection to the YARP network, which all YARP calls need.
class YarpNetwork {
 public:
  /// Throws RunError if no name server answers within timeout_s.
  explicit YarpNetwork(double timeout_s);

 private:
  yarp::os::Network network_;
};

/// Counts the outputs of a port as YARP reports them: give it to setReporter() before the port is opened. Port::getOutputCount()
/// walks through YARP's list of connections, while the thread of a connection that is cut deletes a part of it: with a
/// call per tick a reader that was killed could end the program (YARP 3.12).
class OutputCount final : public yarp::os::PortReport {
 public:
  [[nodiscard]] int count() const { return count_; }

 private:
  void report(const yarp::os::PortInfo& info) override;

  std::atomic<int> count_ = 0;
};

/// Calls a function periodically in a separate thread until it is destroyed.
class Periodic {
 public:
  Periodic(std::chrono::milliseconds period, std::function<void()> work);
  ~Periodic();
  Periodic(const Periodic&) = delete;
  Periodic& operator=(const Periodic&) = delete;

 private:
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ending_ = false;
  std::thread thread_;
};

/// An IPv4 address and port, in the order of the network; 0 where it is not known.
struct Ipv4Address {
  std::uint32_t host = 0;
  std::uint16_t port = 0;
};

/// Checks 25 times per second whether a port that another component opened (remote_controlboard) is still connected. YARP
/// reports that to the component that opened the port only, and its list of connections must not be asked for while one is
/// cut (OutputCount): the state of the TCP connection to the other port is that of the operating system. Only where a
/// carrier without such a connection is used is YARP's list asked.
class OutputWatch {
 public:
  OutputWatch(const std::string& from, std::string to);
  /// True if the connection is lost; it does not return.
  [[nodiscard]] bool lost() const { return lost_; }

 private:
  [[nodiscard]] bool is_connected();
  [[nodiscard]] bool is_listed() const;

  yarp::os::Contact from_;
  std::string to_;
  Ipv4Address address_;  // of `to`
  int socket_;           // of this process, connected to it; -1 for a carrier without one
  std::atomic<bool> lost_ = false;
  Periodic watch_;
};

[[nodiscard]] bool name_server_answers(double timeout_s);
/// Whether a port of that name answers.
[[nodiscard]] bool port_answers(const std::string& name, double timeout_s);
/// Connects two ports; returns false on failure.
[[nodiscard]] bool connect_ports(const std::string& from, const std::string& to, const std::string& carrier,
                                 double timeout_s);

}  // namespace saccade
