#pragma once

#include <atomic>
#include <cstdint>
#include <string>

#include "apps/deploy/deploy_session.h"
#include "apps/deploy/shared_memory.h"
#include "config/robot_file.h"

namespace saccade {

/// What deploy and its guard write for each other, in shared memory. Every value has one writer; no side waits. A process
/// that is killed or halted leaves its last values, whose age the other side sees. Times: machine_ns().
struct GuardBoard {
  // Written by deploy.
  std::atomic<std::int64_t> tick_ns;       ///< of the newest tick
  std::atomic<std::uint64_t> activations;  ///< counts them
  std::atomic<std::uint64_t> moving;       ///< the number of the activation while the head is active, else 0
  std::atomic<std::int64_t> hang_ns;       ///< its deploy.watchdog.hang_ms
  // Written by the guard.
  std::atomic<std::int64_t> guard_ns;    ///< of its newest look at the board
  std::atomic<std::uint32_t> connected;  ///< 1 while a stop would reach the head
  std::atomic<std::uint64_t> stopped;    ///< the number of the activation that it stopped last
  std::atomic<std::int64_t>
      guard_hang_ns;  ///< its deploy.watchdog.hang_ms: a tick that is older makes it stop the head
};
static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

/// The side of deploy: one per head and machine.
class GuardLink final : public Overseer {
 public:
  /// `bound_ns`: deploy.watchdog.hang_ms; age of the guard's newest look above which it is lost. Throws RunError if another
  /// deploy uses the head.
  GuardLink(const std::string& head, GuardUse use, std::int64_t bound_ns);
  ~GuardLink() override;

  void on_tick() override;
  [[nodiscard]] std::optional<Fault> fault() override;
  [[nodiscard]] std::string why_not() override;
  [[nodiscard]] std::string warning() override;
  [[nodiscard]] bool protects() const override { return guarded_; }
  void activating() override;
  void activated() override;
  /// Not before: a deploy that is killed after its stop command and before a thread has sent it leaves the head to the guard.
  void released() override;

  /// Whether a guard that can stop the head, and that stops it after the same time, looks at the board now.
  [[nodiscard]] bool has_guard() const;
  /// Why there is none; empty if there is one.
  [[nodiscard]] std::string guard_problem() const;

 private:
  SharedMemory memory_;
  GuardBoard& board_;
  GuardUse use_;
  std::int64_t bound_ns_;
  std::uint64_t activation_ = 0;
  bool guarded_ = false;  // at the newest tick since the activation
};

/// The side of the guard: what it decides from one look at the board.
class GuardWatch {
 public:
  enum class Action { none, stop };
  /// `bound_ns`: age of deploy's newest tick above which the head is stopped.
  explicit GuardWatch(std::int64_t bound_ns) : bound_ns_(bound_ns) {}
  /// Once for each activation, if deploy moves the head and its newest tick is too old.
  [[nodiscard]] Action look(const GuardBoard& board, std::int64_t now_ns);
  /// Age of deploy's newest tick at the newest look, ns.
  [[nodiscard]] std::int64_t age_ns() const { return age_ns_; }

 private:
  std::int64_t bound_ns_;
  std::int64_t age_ns_ = 0;
  std::uint64_t handled_ = 0;  // the activation that it stopped
};

}  // namespace saccade
