#include "session/close_within.h"

#include <fmt/format.h>

#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <thread>

namespace saccade {

void close_within(std::chrono::milliseconds limit, const std::function<void()>& close,
                  const std::string& error) {
  std::mutex mutex;
  std::condition_variable wake;
  bool closed = false;
  std::thread watch([&] {
    std::unique_lock lock(mutex);
    if (wake.wait_for(lock, limit, [&] { return closed; })) return;
    fmt::print(
        stderr,
        "the connections of the robot do not close within {} ms: the program ends without closing them\n",
        limit.count());
    if (!error.empty()) fmt::print(stderr, "saccade: {}\n", error);
    std::fflush(nullptr);
    std::_Exit(error.empty() ? 0 : 1);
  });
  close();
  {
    const std::lock_guard lock(mutex);
    closed = true;
  }
  wake.notify_all();
  watch.join();
}

}  // namespace saccade
