#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>

#include "apps/deploy/shared_memory.h"
#include "head/head_state.h"

namespace saccade {

/// Six joints in shared memory, which deploy moves and its guard stops, as they do with the board of a robot: the joints
/// follow references only from take() to hold(), and hold their newest reference when every process has ended. Each joint
/// follows its reference with a first-order lag; the torso is upright. Times: machine_ns(), as seconds of one clock for
/// all processes.
///
/// No process waits for another: changes go into a ring of entries, of which the newest one of the newest take() or
/// hold() counts. A process that is killed or halted within a change leaves an entry that nobody reads.
class SharedHead {
 public:
  static constexpr double lag_s = 0.03;

  /// Opens the head of this name, or creates it, at rest with all joints 0 and held. Throws RunError.
  explicit SharedHead(const std::string& name);

  /// State at this time; t_us is that time in us.
  [[nodiscard]] HeadState state(std::int64_t now_ns) const;
  /// Whether the joints follow references.
  [[nodiscard]] bool follows() const;
  /// The joints stop where they are and follow references of this call's number from now on.
  std::uint64_t take();
  /// Returns false, without effect, unless `number` is of the newest take() and no hold() came since.
  bool command(std::uint64_t number, const HeadJointVector& reference_rad);
  /// The joints stop where they are and follow no references.
  void hold();

  /// When the newest accepted command and the newest hold() came; 0 for none.
  [[nodiscard]] std::int64_t commanded_ns() const { return memory().commanded_ns; }
  [[nodiscard]] std::int64_t held_ns() const { return memory().held_ns; }

 private:
  struct Motion {
    std::uint64_t number = 0;  ///< of the take() or hold()
    std::int64_t begin_ns = 0;
    bool follows = false;
    HeadJointVector from_rad = HeadJointVector::Zero();
    HeadJointVector reference_rad = HeadJointVector::Zero();

    [[nodiscard]] HeadJointVector position_rad(std::int64_t now_ns) const;
  };
  static constexpr std::size_t words = 3 + 2 * gaze_slots;
  struct Entry {
    std::atomic<std::uint64_t> count;  ///< 1 + its place in the order of all entries; 0 while it is written
    std::array<std::atomic<std::uint64_t>, words> word;
  };
  struct Memory {
    std::atomic<std::uint64_t> number;
    std::atomic<std::uint64_t> next;
    std::atomic<std::int64_t> commanded_ns;
    std::atomic<std::int64_t> held_ns;
    std::array<Entry, 64> ring;
  };

  [[nodiscard]] Memory& memory() const { return *static_cast<Memory*>(shared_.data()); }
  [[nodiscard]] Motion newest() const;
  void publish(const Motion& motion);
  std::uint64_t begin(bool follows);

  SharedMemory shared_;
};

}  // namespace saccade
