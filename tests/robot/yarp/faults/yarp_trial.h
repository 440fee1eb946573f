#pragma once

#include <yarp/dev/IControlMode.h>
#include <yarp/dev/PolyDriver.h>

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "apps/deploy/shared_memory.h"
#include "tests/robot/yarp/faults/robot_facts.h"
#include "tests/robot/yarp/yarp_world.h"

namespace saccade {

enum class YarpFaultKind {
  camera_silent,
  camera_broken,
  camera_halted,
  camera_killed,
  camera_cut,
  state_cut,
  commands_cut,
  board_halted,
  board_killed,
  encoder_not_a_number,
  joint_outside,
  joint_stuck,
  joint_off,
  joint_taken,
  strangers,
  name_server_halted,
  guard_killed,
  guard_halted,
  deploy_killed,
  deploy_halted,
  interrupted,
};

struct YarpFault {
  YarpFaultKind kind;
  const char* name;
  /// Texts of which the log of deploy has one; empty: deploy cannot write one, or nothing may stop the head.
  std::vector<std::string> causes;
};
[[nodiscard]] const std::vector<YarpFault>& yarp_faults();

struct YarpTrialResult {
  bool stopped_before = false;  ///< deploy stopped before the fault; nothing else holds
  std::optional<double>
      stop_ms;  ///< from the fault to the newest reference of deploy (of the guard: to its stop)
  std::optional<double> rest_ms;  ///< to the newest motion of a joint
  std::string problem;            ///< empty if the fault was answered as docs/safety.md says
};

/// A program beside this one, whose end can be awaited.
class Program {
 public:
  Program(const std::vector<std::string>& words, const std::filesystem::path& log);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;
  void send_signal(int signal) const { ::kill(pid_, signal); }
  /// Exit status, 128 + signal; none if it did not end in time.
  [[nodiscard]] std::optional<int> wait(double timeout_s);

 private:
  pid_t pid_;
  std::optional<int> status_;
};

/// A name server, a peer robot and a guard, and `saccade deploy` in each trial.
class YarpTrials {
 public:
  YarpTrials(std::string saccade, std::string robot);
  [[nodiscard]] YarpTrialResult run(const YarpFault& fault, double wait_s);

 private:
  void start_what_is_missing();
  void start_board();
  [[nodiscard]] std::vector<int> modes();
  /// Returns the time at which the fault came, ns.
  std::int64_t inject(YarpFaultKind kind, Program& deploy);
  void talk_as_a_stranger() const;
  [[nodiscard]] std::string log(const char* name) const;
  /// What deploy says of its stop; empty without one.
  [[nodiscard]] std::string stop_line() const;

  std::string saccade_;
  std::string robot_;
  YarpWorld& world_;
  SharedMemory memory_;
  RobotFacts& facts_;
  std::unique_ptr<Program> camera_, board_, guard_;
  std::unique_ptr<yarp::dev::PolyDriver> client_;
  yarp::dev::IControlMode* modes_ = nullptr;
};

}  // namespace saccade
