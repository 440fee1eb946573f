#pragma once

#include <chrono>
#include <set>
#include <vector>

#include "apps/live/live_server.h"
#include "apps/sweep/sweep_coordinator.h"

namespace saccade {

/// The live page of a sweep: how far it is, and its newest results.
class LiveSweep {
 public:
  explicit LiveSweep(const LiveAddress& address);

  [[nodiscard]] std::string link() const { return server_.link(); }
  /// Sends what is new, every 2 s at most.
  void show(const SweepCoordinator& coordinator);

 private:
  LiveServer server_;
  std::chrono::steady_clock::time_point next_;
  std::size_t last_missing_;
  std::set<std::int64_t> known_;      // runs with a result
  std::vector<std::int64_t> newest_;  // the newest last
  std::string results_;               // JSON of columns and rows
};

}  // namespace saccade
