#include "apps/deploy/real_time.h"

#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <cerrno>
#include <system_error>

namespace saccade {
namespace {

constexpr int priority = 50;  // the middle: below the hardware drivers

std::string reason(int error) { return std::generic_category().message(error); }

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

RealTime::RealTime() {
  sched_param wanted{};
  wanted.sched_priority = priority;
  const int denied = pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted);
  summary_ = denied == 0 ? "real-time priority " + std::to_string(priority)
                         : "no real-time priority (" + reason(denied) + ")";
  rlimit most{};
  // With a limit on locked memory, locking future pages would make later allocations fail.
  const bool unlimited = getrlimit(RLIMIT_MEMLOCK, &most) == 0 && most.rlim_cur == RLIM_INFINITY;
  if (mlockall(unlimited ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT) == 0) {
    summary_ += ", memory locked";
  } else {
    summary_ += ", memory not locked (" + reason(errno) + ")";
  }
}

RealTime::~RealTime() {
  const sched_param ordinary{};
  pthread_setschedparam(pthread_self(), SCHED_OTHER, &ordinary);
  munlockall();
}

}  // namespace saccade
