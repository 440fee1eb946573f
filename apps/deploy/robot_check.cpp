#include "apps/deploy/robot_check.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cerrno>
#include <cmath>
#include <memory>
#include <system_error>
#include <thread>

#include "apps/deploy/deploy_loop.h"
#include "apps/deploy/guard_link.h"
#include "apps/deploy/shared_memory.h"
#include "core/error.h"
#include "session/real_time.h"
#include "session/version.h"
#ifdef SACCADE_YARP
#include "robot/yarp/yarp_robot.h"
#endif

namespace saccade {
namespace {

namespace fs = std::filesystem;

constexpr double bytes_per_mb = 1e6;

StartUpCheck check_yarp(const RobotFile& file) {
  StartUpCheck check{"YARP", true, {}};
#ifdef SACCADE_YARP
  check.found = "version " + yarp_version();
  (void)file;
#else
  check.passed = file.robot.backend != "yarp";
  check.found = check.passed ? "not in this build; the backend " + file.robot.backend + " does not need it"
                             : fmt::format(
                                   "not in this build: build YARP {} or newer and pass "
                                   "-DCMAKE_PREFIX_PATH=PREFIX (docs/robot.md)",
                                   least_yarp_version());
#endif
  return check;
}

StartUpCheck check_priority() {
  StartUpCheck check{"real-time priority", false, {}};
  int denied = 0;
  std::thread([&] {
    sched_param wanted{};
    wanted.sched_priority = deploy_priority;
    denied = pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
  }).join();
  check.passed = denied == 0;
  check.found =
      check.passed ? "permitted" : std::generic_category().message(denied) + ": " + how_to_permit_real_time();
  return check;
}

StartUpCheck check_memory_lock() {
  StartUpCheck check{"locked memory", false, {}};
  rlimit most{};
  const bool known = getrlimit(RLIMIT_MEMLOCK, &most) == 0;
  if (mlockall(MCL_CURRENT) == 0) {
    munlockall();
    check.passed = true;
    check.found = "permitted";
  } else {
    check.found = std::generic_category().message(errno) + ": ";
    if (known && most.rlim_cur != RLIM_INFINITY)
      check.found += fmt::format("the limit is {} kB; ", most.rlim_cur / 1024);
    check.found += fmt::format("write `@robot - memlock unlimited` into {}", limits_file);
  }
  return check;
}

StartUpCheck check_processors() {
  const unsigned count = std::thread::hardware_concurrency();
  return {"processors", count >= 2,
          fmt::format("{}{}", count, count >= 2 ? "" : ": two are needed, for the ticks and for the files")};
}

StartUpCheck check_shared_memory() {
  StartUpCheck check{"shared memory", true, "for the guard"};
  try {
    const SharedMemory memory("check", 1);
  } catch (const RunError& error) {
    check.passed = false;
    check.found = error.what();
  }
  return check;
}

StartUpCheck check_disk(const RobotFile& file, const fs::path& out) {
  fs::path folder = fs::absolute(out);
  while (!fs::exists(folder) && folder.has_relative_path()) folder = folder.parent_path();
  StartUpCheck check{"disk of " + folder.string(), false, {}};
  std::error_code error;
  const fs::space_info space = fs::space(folder, error);
  const double free_mb = error ? 0.0 : static_cast<double>(space.available) / bytes_per_mb;
  const auto least_mb = static_cast<double>(file.output.least_free_mb);
  check.passed = !error && free_mb >= least_mb;
  check.found = error ? error.message()
                      : fmt::format(
                            "{:.0f} MB free; --record ends at {:.0f} (output.least_free_mb) and goes on in "
                            "the next file after {} MB or {:g} s",
                            free_mb, least_mb, file.output.rotate_mb, file.output.rotate_s);
  return check;
}

StartUpCheck check_guard(const RobotFile& file) {
  StartUpCheck check{"guard", true, {}};
  if (file.robot.head_name().empty() || file.deploy.guard == GuardUse::none) {
    check.found = "not used";
    return check;
  }
  try {
    const GuardLink link(file.robot.head_name(), file.deploy.guard,
                         std::llround(file.deploy.watchdog.hang_ms * 1e6));
    const std::string problem = link.guard_problem();
    check.passed = problem.empty() || file.deploy.guard != GuardUse::required;
    check.found = problem.empty() ? "watches the head " + file.robot.head_name() : problem;
  } catch (const RunError& error) {
    check.passed = false;
    check.found = error.what();
  }
  return check;
}

}  // namespace

std::vector<StartUpCheck> machine_checks(const RobotFile& file, const fs::path& out) {
  return {check_yarp(file),      check_priority(),      check_memory_lock(), check_processors(),
          check_shared_memory(), check_disk(file, out), check_guard(file)};
}

std::vector<StartUpCheck> robot_checks(const RobotCheckOptions& options, const Registry& registry) {
  const RobotFile file = read_robot_file(options.robot, options.assignments, registry);
  std::vector<StartUpCheck> checks = machine_checks(file, options.out);
  try {
    const std::unique_ptr<Robot> robot = open_robot(file.robot, robot_context(file));
    for (StartUpCheck& check : start_up_checks(*robot, file)) checks.push_back(std::move(check));
  } catch (const std::runtime_error& error) {
    checks.push_back({"robot", false, error.what()});
  }
  return checks;
}

}  // namespace saccade
