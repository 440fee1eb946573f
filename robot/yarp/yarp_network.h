#pragma once

#include <yarp/os/Contact.h>
#include <yarp/os/Network.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace saccade {

/// Our being on the YARP network. Nothing of YARP works without one.
class YarpNetwork {
 public:
  /// Throws RunError where no name server answers within timeout_s.
  explicit YarpNetwork(double timeout_s);

 private:
  yarp::os::Network network_;
};

/// A thread that looks after what YARP tells nobody: whether the name server answers, once a second, and whether ports
/// of ours that others opened for us still have their connection, 20 times a second.
class YarpWatch {
 public:
  /// A port of ours, and the one that it has to be connected to.
  struct Output {
    std::string from;
    std::string to;
  };
  YarpWatch(const std::vector<Output>& outputs, double timeout_s);
  ~YarpWatch();

  [[nodiscard]] bool has_name_server() const { return has_name_server_; }
  /// One of the outputs is gone, for good.
  [[nodiscard]] bool lost() const { return lost_; }

 private:
  void run(double timeout_s);
  [[nodiscard]] bool outputs_stand() const;

  std::vector<std::pair<yarp::os::Contact, std::string>> outputs_;
  std::atomic<bool> has_name_server_ = true;
  std::atomic<bool> lost_ = false;
  std::mutex mutex_;
  std::condition_variable wake_;
  bool ending_ = false;
  std::thread thread_;
};

/// Whether somebody answers under that name.
[[nodiscard]] bool port_answers(const std::string& name, double timeout_s);
/// Connects two ports; false where it does not work out.
[[nodiscard]] bool connect_ports(const std::string& from, const std::string& to, const std::string& carrier,
                                 double timeout_s);

}  // namespace saccade
