// Kills and halts `saccade deploy` beside `saccade guard`: SACCADE ROBOT.yaml COUNT. Prints the times from the signal to
// the stop of the head. Status 1 if the head was not stopped, or moved later.
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "apps/deploy/shared_head.h"
#include "core/random.h"

namespace saccade {
namespace {

pid_t start(const std::vector<std::string>& words, const std::filesystem::path& log) {
  std::fflush(nullptr);  // the child has a copy of what is not written yet
  const pid_t child = ::fork();
  if (child != 0) return child;
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  (void)!std::freopen(log.c_str(), "w", stdout);
  (void)!std::freopen(log.c_str(), "a", stderr);
  (void)!std::freopen("/dev/null", "r", stdin);
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  ::execv(arguments[0], arguments.data());
  ::_exit(127);
}

/// Waits for something that has to happen; false after a minute.
template <class Holds>
bool eventually(const Holds& holds) {
  for (int i = 0; i < 60'000; ++i) {
    if (holds()) return true;
    ::usleep(1000);
  }
  return false;
}

void print(const char* what, std::vector<double>& ms) {
  std::ranges::sort(ms);
  const auto at = [&](double share) {
    return ms[std::min(ms.size() - 1, static_cast<std::size_t>(share * static_cast<double>(ms.size())))];
  };
  fmt::print("| {} | {} | {:.1f} | {:.1f} | {:.1f} |\n", what, ms.size(), at(0.5), at(0.99), ms.back());
}

}  // namespace
}  // namespace saccade

int main(int count_of_arguments, char** arguments) {
  using namespace saccade;
  if (count_of_arguments != 4) {
    fmt::print(stderr, "usage: saccade_guard_trials SACCADE ROBOT.yaml COUNT\n");
    return 2;
  }
  const std::string saccade = arguments[1];
  const std::string robot = arguments[2];
  const int count = std::atoi(arguments[3]);
  const std::string name = "trials-" + std::to_string(::getpid());
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / ("saccade-" + name);
  std::filesystem::create_directories(folder);
  SharedHead head(name);
  const std::string key = "practice.head=" + name;
  const pid_t guard = start({saccade, "guard", robot, "--set", key}, folder / "guard.txt");
  int failures = 0;
  const RandomStream random(1, "guard trials");
  fmt::print("| signal | trials | median ms | 99 % | worst |\n|---|---|---|---|---|\n");
  for (const int signal : {SIGKILL, SIGSTOP}) {
    std::vector<double> ms;
    for (int trial = 0; trial < count; ++trial) {
      const std::int64_t commanded_ns = head.commanded_ns();
      const pid_t deploy = start({saccade, "deploy", robot, "--set", key, "--set", "deploy.guard=required",
                                  "--set", "deploy.ramp_in_s=0.1", "--set", "gaze.start_s=0", "--activate",
                                  "--force", "--out", (folder / "run").string()},
                                 folder / "deploy.txt");
      if (!eventually([&] { return head.commanded_ns() != commanded_ns; })) {
        fmt::print(stderr, "deploy does not move the head: {}\n", (folder / "deploy.txt").string());
        return 1;
      }
      ::usleep(static_cast<useconds_t>(random.uniform(1e5, 4e5, 0, static_cast<std::uint64_t>(trial))));
      const std::int64_t before_ns = head.held_ns();
      const std::int64_t signal_ns = machine_ns();
      ::kill(deploy, signal);
      const bool stopped = eventually([&] { return head.held_ns() != before_ns; });
      const std::int64_t held_ns = head.held_ns();
      if (signal == SIGSTOP) {
        ::usleep(50'000);
        ::kill(deploy, SIGCONT);
      }
      int status = 0;
      ::waitpid(deploy, &status, 0);
      const bool still = head.commanded_ns() <= held_ns && !head.follows();
      if (!stopped || !still) {
        ++failures;
        fmt::print(stderr, "trial {}: {}\n", trial, stopped ? "a reference after the stop" : "no stop");
      }
      if (signal == SIGSTOP && !(WIFEXITED(status) && WEXITSTATUS(status) == 1)) {
        ++failures;
        fmt::print(stderr, "trial {}: deploy did not end with status 1 after SIGCONT\n", trial);
      }
      ms.push_back(1e-6 * static_cast<double>(held_ns - signal_ns));
    }
    print(signal == SIGKILL ? "SIGKILL" : "SIGSTOP, then SIGCONT", ms);
  }
  ::kill(guard, SIGTERM);
  ::waitpid(guard, nullptr, 0);
  for (const char* kind : {"guard-practice_", "guarding-practice_", "practice-"})
    ::unlink(("/dev/shm/saccade-" + std::string(kind) + name).c_str());
  if (failures == 0) std::filesystem::remove_all(folder);
  return failures == 0 ? 0 : 1;
}
