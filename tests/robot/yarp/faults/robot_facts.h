#pragma once

#include <atomic>
#include <cstdint>

namespace saccade {

/// What a peer robot does wrong, and what its control board sees; in shared memory of the campaign and of the peers.
/// Times: machine_ns().
struct RobotFacts {
  enum Camera : int { sends, is_silent, sends_broken_messages };
  enum Joints : int { are_read, one_is_not_a_number, one_is_outside, one_is_stuck };

  // Written by the campaign.
  std::atomic<int> camera;
  std::atomic<int> joints;
  // Written by the board.
  std::atomic<std::uint64_t> references;    ///< counts the references that differ from the one before
  std::atomic<std::int64_t> referenced_ns;  ///< of the newest of them
  std::atomic<std::int64_t>
      held_ns;  ///< of the newest change of what the servos hold, changes of mode included
  std::atomic<std::int64_t> moved_ns;  ///< of the newest step with a joint faster than 1 deg/s
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

}  // namespace saccade
