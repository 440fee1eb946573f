#pragma once

#include <atomic>
#include <memory>
#include <string>

#include "apps/view/loop_history.h"
#include "apps/view/snapshot_channel.h"

namespace saccade {

class SimRobot;
struct Scenario;

/// Passes snapshots of a run from the run's thread to the window's. The snapshots refer to nothing of the run, which may
/// end or throw at any time.
class RunFeed {
 public:
  explicit RunFeed(const Scenario& scenario);

  /// The run's thread, after each tick: fills a snapshot if the window has requested one.
  void record(const Tick& tick, const SimRobot& robot, const Loop& loop);
  /// The run's thread: no more ticks come, and the window closes.
  void close() { closed_ = true; }

  /// The window's thread.
  [[nodiscard]] bool closed() const { return closed_; }
  [[nodiscard]] SnapshotChannel& channel() { return channel_; }

 private:
  Camera camera_;
  std::string driver_;
  LoopHistory history_;
  std::shared_ptr<const mjModel> model_;  // a copy of the world's, made in the first tick
  SnapshotChannel channel_;
  std::atomic<bool> closed_ = false;
};

}  // namespace saccade
