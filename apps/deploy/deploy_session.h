#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "loop/loop.h"
#include "loop/watchdog.h"
#include "robot/robot.h"

namespace saccade {

/// Control of a robot's motors:
///
///     unconfigured --all checks passed--> ready --operator--> active --operator or fault--> stopped
///                                                               ^---------operator---------'
///
/// The head moves only in `active`. `stopped` is the safe state: the head was stopped and its joints released, nothing
/// is sent to it, until the operator activates it again.
enum class DeployState { unconfigured, ready, active, stopped };
[[nodiscard]] std::string_view name_of(DeployState state);

/// A change of the session's state, or a rejected activation (`state` stays).
struct DeployChange {
  std::int64_t t_us = 0;
  DeployState state = DeployState::unconfigured;
  std::optional<Fault> stop;  ///< if the head was stopped
  std::int64_t took_us = 0;   ///< from the fact that caused the stop to the stop command
  std::string rejected;       ///< reason of a rejected activation
  std::string warning;        ///< of an activation: what does not protect the head
};

/// Timing of a tick, us of the robot's clock.
struct TickTiming {
  std::int64_t due_us = 0;
  std::int64_t begin_us = 0;  ///< begin - due is the delay
  std::int64_t end_us = 0;    ///< after all detectors
  /// From the newest event's time stamp to the command; none in a tick without events. Does not include the least delay
  /// of the camera's transport if time stamps are mapped to the robot's clock by arrival.
  std::optional<std::int64_t> latency_us;
  std::int64_t missed = 0;  ///< due ticks before it that were skipped
  EventTraffic traffic;
  DeployState state = DeployState::unconfigured;
  bool guarded = true;  ///< whether every overseer protects the head
};

/// Called in the thread of the ticks.
class DeployObserver {
 public:
  virtual ~DeployObserver() = default;
  /// After each tick. Must not allocate, throw or wait; `tick` is valid until it returns.
  virtual void on_tick(const Tick& tick, const TickTiming& timing) = 0;
  virtual void on_change(const DeployChange& change) = 0;
  /// Robot::news.
  virtual void on_news(std::int64_t t_us, const std::string& line) = 0;
};

/// Watches the session from another thread or process and can stop the head without it. The session calls it in the
/// thread of the ticks. on_tick() and fault() do not wait, lock or allocate.
class Overseer {
 public:
  virtual ~Overseer() = default;
  /// At the start of each tick.
  virtual void on_tick() = 0;
  /// Why the head has to stop, or was stopped already; none if all is well. Only asked while the head is active. `amount`
  /// is the age of the cause, ms; the session adds the time.
  [[nodiscard]] virtual std::optional<Fault> fault() = 0;
  /// Why the head must not be activated now; empty if it may.
  [[nodiscard]] virtual std::string why_not() { return {}; }
  /// After an activation: what it lacks although the head may move; empty for nothing.
  [[nodiscard]] virtual std::string warning() { return {}; }
  /// Whether it would stop the active head now. May change in fault().
  [[nodiscard]] virtual bool protects() const { return true; }
  /// The head is about to be activated, which may take long; earlier stops are over.
  virtual void activating() {}
  /// From now on the head moves, as long as ticks come.
  virtual void activated() {}
  /// The stop command is on its way to the head; releasing it may take long.
  virtual void stopped() {}
  /// The head is released, so the stop has reached it as far as there is a connection.
  virtual void released() {}
};

/// Requests of an operator, carried out at the next tick. May be called from any thread.
class OperatorRequests {
 public:
  /// Has no effect while a stop waits for its tick.
  void activate() {
    Request none = Request::none;
    request_.compare_exchange_strong(none, Request::activate);
  }
  /// Stops an active head; ends the attempts to activate one (DeploySession::keep_activating).
  void stop() { request_ = Request::stop; }
  /// The head stops and the session ends.
  void quit(StopCause cause) {
    quit_cause_ = cause;
    quit_ = true;
  }

 private:
  friend class DeploySession;
  enum class Request { none, activate, stop };
  std::atomic<Request> request_ = Request::none;
  std::atomic<StopCause> quit_cause_ = StopCause::operator_stop;
  std::atomic<bool> quit_ = false;
};

struct DeploySessionConfig {
  std::int64_t tick_us = 1000;
  WatchdogConfig watchdog;
  std::vector<Overseer*> overseers = {};  ///< outlive the session
  /// Whether the joints have to follow their references. Not in a dry run, and not where a recorded head moves as it did.
  bool joints_follow = true;
};

/// Runs a loop on a robot in real time: schedules the ticks, activates the head and stops it. Has no clock but the
/// robot's, and no thread.
///
/// Ticks are due every tick_us. A tick that is less than half of that behind begins at once; otherwise the ticks that are
/// due already are skipped and the next one begins when it is due: lost time is not made up for, and an overloaded loop
/// leaves its processor to the threads that receive events and readings.
///
/// Before each tick with an active head the watchdog checks the robot. On a fault, and on the operator's request, the
/// loop stops sending, the head (or the robot's gaze controller) gets a stop command, the delay is measured, and the
/// joints are released (Robot::release). Detection continues. A lost connection ends the session.
///
/// While the head is active the watchdog also checks what the ports report of the joints: their modes, rejected
/// references, and joints that do not follow. Overseers are asked in each tick.
class DeploySession {
 public:
  using MakeMotion = std::function<LoopMotion()>;

  /// `robot`, `loop` (on that robot), `requests` and `observer` outlive it. `make_motion` is called at each activation;
  /// if it is empty, activation is rejected.
  DeploySession(Robot& robot, Loop& loop, MakeMotion make_motion, OperatorRequests& requests,
                DeployObserver& observer, const DeploySessionConfig& config);

  /// To be called after all start-up checks have passed; ticks are due from now on.
  void set_ready();
  /// Tries to activate the head every 100 ms, in ticks after the first that are not late, until it is active. After
  /// `within_us` without success the session ends. A stop that the operator requests ends the attempts.
  void keep_activating(std::int64_t within_us);
  /// Why the newest request to activate the head had no success; empty if it had.
  [[nodiscard]] const std::string& not_activated() const { return not_activated_; }
  /// One tick. Returns false at the end: the operator quit, the recording ended, or the connection was lost.
  bool tick();

  [[nodiscard]] DeployState state() const { return state_; }
  /// The newest stop of the head.
  [[nodiscard]] const std::optional<Fault>& last_stop() const { return last_stop_; }

 private:
  class LastTick final : public LoopObserver {
   public:
    void on_tick(const Tick& newest) override { tick = newest; }
    std::optional<Tick> tick;
  };

  /// Requests to activate the head until a time.
  struct Attempts {
    std::int64_t from_us = 0;
    std::int64_t until_us = 0;
    std::int64_t next_us = 0;
  };

  [[nodiscard]] std::int64_t plan_tick();
  /// Returns false if the session is over: the time for activation has passed.
  bool try_to_activate(const TickFacts& facts);
  [[nodiscard]] std::optional<Fault> find_fault(const TickFacts& facts);
  void reject(std::string reason);
  [[nodiscard]] TickFacts facts(std::int64_t due_us);
  PortStatus run_loop(std::int64_t planned_us, std::int64_t begin_us);
  bool catch_up();
  void note_command(const Tick& tick);
  void note_protection(std::int64_t now_us);
  void activate(const TickFacts& facts);
  void stop(const Fault& fault);
  void change(DeployState state, const std::optional<Fault>& stop, std::int64_t took_us, std::string rejected,
              std::string warning = {});
  bool end(PortStatus status);

  Robot& robot_;
  Loop& loop_;
  MakeMotion make_motion_;
  OperatorRequests& requests_;
  DeployObserver& observer_;
  std::int64_t tick_us_;
  std::int64_t tick_late_us_;
  Watchdog watchdog_;
  FollowWatch follows_;
  std::vector<Overseer*> overseers_;
  bool joints_follow_;
  std::optional<Attempts> attempts_;
  std::string not_activated_;
  std::optional<std::int64_t> refused_us_;  // when the head rejected the newest reference
  LastTick last_;
  DeployState state_ = DeployState::unconfigured;
  std::optional<Fault> last_stop_;
  std::int64_t due_us_;         // of the last tick
  std::int64_t last_begin_us_;  // the connection was intact then
  std::int64_t missed_ = 0;
  bool caught_up_ = false;  // in this tick
  bool guarded_ = true;     // in the newest tick of the active head
  bool has_ticked_ = false;
};

}  // namespace saccade
