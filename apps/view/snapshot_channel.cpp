#include "apps/view/snapshot_channel.h"

#include <utility>

namespace saccade {

void SnapshotChannel::publish() {
  const std::lock_guard lock(mutex_);
  std::swap(back_, published_);
  fresh_ = true;
  requested_.store(false, std::memory_order_relaxed);
}

bool SnapshotChannel::take(Snapshot& snapshot) {
  const std::lock_guard lock(mutex_);
  requested_.store(true, std::memory_order_relaxed);
  if (!fresh_) return false;
  std::swap(snapshot, published_);
  fresh_ = false;
  return true;
}

}  // namespace saccade
