#pragma once

#include <chrono>
#include <set>
#include <vector>

#include "apps/live/live_server.h"
#include "apps/sweep/sweep_coordinator.h"

namespace saccade {

/// The live page of a sweep: how far it is, its newest results, and pictures of the worst runs, which alone have some.
class LiveSweep {
 public:
  enum class When { in_time, at_once };

  LiveSweep(const LiveAddress& address, SweepFolder folder);

  [[nodiscard]] std::string link() const { return server_.link(); }
  /// Sends what is new: every 2 s at most, when the last run is done, and at once.
  void show(const SweepCoordinator& coordinator, When when = When::in_time);

 private:
  LiveServer server_;
  SweepFolder folder_;
  std::chrono::steady_clock::time_point next_;
  std::size_t last_missing_;
  std::size_t runs_ = 0;
  std::set<std::int64_t> known_;      // runs with a result
  std::vector<std::int64_t> newest_;  // the newest last
  std::string results_;               // JSON of columns and rows
};

}  // namespace saccade
