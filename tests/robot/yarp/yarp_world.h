#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>
#include <yarp/os/Network.h>

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/recording/temp_folder.h"

namespace saccade {

/// Waits for something, looking every millisecond; false when it did not come.
inline bool eventually(double timeout_s, const std::function<bool()>& holds) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
  while (!holds()) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

/// A program that runs beside the test and ends with it.
class Child {
 public:
  /// What it prints goes into `log`.
  Child(const std::vector<std::string>& arguments, const std::filesystem::path& log) {
    std::vector<char*> words;
    for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    pid_ = ::fork();
    if (pid_ != 0) return;
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    (void)!std::freopen(log.c_str(), "a", stdout);
    (void)!std::freopen(log.c_str(), "a", stderr);
    ::execv(words[0], words.data());
    ::_exit(127);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() { kill(); }

  void kill() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
    pid_ = 0;
  }
  void send_signal(int signal) const { ::kill(pid_, signal); }
  [[nodiscard]] pid_t pid() const { return pid_; }
  /// Waits until it ends; its exit status, or 128 and the signal that ended it.
  int wait() {
    int status = 0;
    ::waitpid(pid_, &status, 0);
    pid_ = 0;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

 private:
  pid_t pid_ = 0;
};

/// A YARP network that nobody else is on: a name server on loopback, at a port of its own, with its configuration in a
/// folder of its own. One per process.
class YarpWorld {
 public:
  static YarpWorld& get() {
    static YarpWorld world;
    return world;
  }

  void start_name_server() {
    server_ =
        std::make_unique<Child>(std::vector<std::string>{SACCADE_YARP_BIN "/yarpserver", "--ip", "127.0.0.1",
                                                         "--socket", std::to_string(port_), "--read",
                                                         "--portdb", ":memory:", "--subdb", ":memory:"},
                                folder_ / "yarpserver.log");
    const bool started = eventually(5.0, [] { return yarp::os::Network::checkNetwork(0.2); });
    EXPECT_TRUE(started) << "yarpserver does not start";
  }
  void kill_name_server() { server_.reset(); }
  void signal_name_server(int signal) const { server_->send_signal(signal); }

  [[nodiscard]] std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }

 private:
  YarpWorld() : port_(free_port()) {
    const std::filesystem::path config = folder_ / "yarp";
    std::filesystem::create_directories(config);
    std::ofstream(config / "yarp.conf") << "127.0.0.1 " << port_ << " yarp\n";
    for (const char* name : {"XDG_CONFIG_HOME", "XDG_DATA_HOME", "XDG_CACHE_HOME"}) {
      ::setenv(name, (folder_ / "").c_str(), 1);
    }
    ::setenv("YARP_DATA_DIRS", SACCADE_YARP_BIN "/../share/yarp", 1);  // where YARP finds its devices
    ::unsetenv("YARP_CONF");
    ::unsetenv("YARP_NAMESPACE");
    network_ = std::make_unique<yarp::os::Network>();
    start_name_server();
  }

  /// The name server gives ports away from its own on, so that each process has a range, below the one that the system
  /// takes ports from by itself.
  static int free_port() {
    for (int slot = static_cast<int>(::getpid());; ++slot) {
      const int port = 11000 + slot % 100 * 200;
      const int probe = ::socket(AF_INET, SOCK_STREAM, 0);
      sockaddr_in address{};
      address.sin_family = AF_INET;
      address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      address.sin_port = htons(static_cast<std::uint16_t>(port));
      const bool is_free = ::bind(probe, reinterpret_cast<sockaddr*>(&address), sizeof(address)) == 0;
      ::close(probe);
      if (is_free) return port;
    }
  }

  TempFolder folder_;
  int port_;
  std::unique_ptr<yarp::os::Network> network_;
  std::unique_ptr<Child> server_;
};

}  // namespace saccade
