#pragma once

#include <yarp/os/Contact.h>
#include <yarp/os/Network.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

namespace saccade {

/// Our being on the YARP network. Nothing of YARP works without one.
class YarpNetwork {
 public:
  /// Throws RunError where no name server answers within timeout_s.
  explicit YarpNetwork(double timeout_s);

 private:
  yarp::os::Network network_;
};

/// Does something again and again in a thread of its own, as long as it lives.
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

/// Looks 25 times a second whether a port of ours that somebody else opened for us (remote_controlboard) still has its
/// connection, which YARP tells nobody but him.
class OutputWatch {
 public:
  OutputWatch(const std::string& from, std::string to);
  /// The connection is gone, for good.
  [[nodiscard]] bool lost() const { return lost_; }

 private:
  [[nodiscard]] bool stands() const;

  yarp::os::Contact from_;
  std::string to_;
  std::atomic<bool> lost_ = false;
  Periodic watch_;
};

[[nodiscard]] bool name_server_answers(double timeout_s);
/// Whether somebody answers under that name.
[[nodiscard]] bool port_answers(const std::string& name, double timeout_s);
/// Connects two ports; false where it does not work out.
[[nodiscard]] bool connect_ports(const std::string& from, const std::string& to, const std::string& carrier,
                                 double timeout_s);

}  // namespace saccade
