#pragma once

#include <atomic>
#include <mutex>

#include "apps/view/snapshot.h"

namespace saccade {

/// Passes the newest snapshot from the loop's thread to the window's (a triple buffer). The loop's thread fills one
/// only after the window's thread has requested one, and waits for nothing but a swap.
class SnapshotChannel {
 public:
  /// The loop's thread: whether the window's thread has requested a snapshot. If so, fill back() and publish() it.
  [[nodiscard]] bool requested() const { return requested_.load(std::memory_order_relaxed); }
  [[nodiscard]] Snapshot& back() { return back_; }
  void publish();
  /// The window's thread: swaps a snapshot that is new into `snapshot` and returns true; requests the next one.
  bool take(Snapshot& snapshot);
  /// The window's thread: requests no more snapshots.
  void stop() { requested_.store(false, std::memory_order_relaxed); }

 private:
  std::atomic<bool> requested_ = true;
  std::mutex mutex_;
  bool fresh_ = false;  // under mutex_
  Snapshot back_;       // of the loop's thread
  Snapshot published_;  // under mutex_
};

}  // namespace saccade
