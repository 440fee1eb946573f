#include "session/real_time.h"

#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cerrno>
#include <fstream>
#include <system_error>

namespace saccade {
namespace {

constexpr const char* autogroup_file = "/proc/sys/kernel/sched_autogroup_enabled";

std::string reason(int error) { return std::generic_category().message(error); }

/// Of the whole program; what came of it, in words.
std::string lock_memory() {
  rlimit most{};
  // With a limit on locked memory, locking future pages would make later allocations fail.
  const bool unlimited = getrlimit(RLIMIT_MEMLOCK, &most) == 0 && most.rlim_cur == RLIM_INFINITY;
  if (mlockall(unlimited ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT) == 0) return "memory locked";
  return "memory not locked (" + reason(errno) + ")";
}

}  // namespace

void use_small_stacks() {
  pthread_attr_t attributes;
  if (pthread_attr_init(&attributes) != 0) return;
  std::size_t bytes = 0;
  if (pthread_getattr_default_np(&attributes) == 0 && pthread_attr_getstacksize(&attributes, &bytes) == 0 &&
      bytes > small_stack_bytes && pthread_attr_setstacksize(&attributes, small_stack_bytes) == 0)
    pthread_setattr_default_np(&attributes);
  pthread_attr_destroy(&attributes);
}

std::string how_to_permit_real_time() {
  std::string text =
      "write `@robot - rtprio 99` into " + std::string(limits_file) + ", join the group and log in again";
  char autogroup = '0';
  if (std::ifstream(autogroup_file) >> autogroup && autogroup == '1')
    text += "; autogroup scheduling is on, with which `nice` has no effect on the programs of other sessions";
  return text;
}

bool is_virtual_machine() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("flags")) return (line + ' ').find(" hypervisor ") != std::string::npos;
  }
  return false;
}

RealTime::RealTime(int priority, LockMemory lock) : lock_(lock) {
  // Before the priority: the system fetches every page meanwhile, which would delay the other real-time programs.
  const std::string memory = lock_ == LockMemory::yes ? ", " + lock_memory() : std::string();
  sched_param wanted{};
  wanted.sched_priority = priority;
  const int denied = pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
  granted_ = denied == 0;
  summary_ = (granted_ ? "real-time priority " + std::to_string(priority)
                       : "no real-time priority (" + reason(denied) + ")") +
             memory;
}

RealTime::~RealTime() {
  const sched_param ordinary{};
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &ordinary);
  if (lock_ == LockMemory::yes) munlockall();
}

}  // namespace saccade
