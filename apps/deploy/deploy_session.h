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

/// A change of the session's state, or an activation that was refused (`state` is then what it stays).
struct DeployChange {
  std::int64_t t_us = 0;
  DeployState state = DeployState::unconfigured;
  std::optional<Fault> stop;  ///< why, where the head was stopped
  std::int64_t took_us = 0;   ///< from the stop's fact to the head being told to stop
  std::string refused;        ///< why it was not activated
};

/// When a tick did what, in the robot's clock.
struct TickTiming {
  std::int64_t due_us = 0;
  std::int64_t begin_us = 0;  ///< when it began: begin - due is its lateness
  std::int64_t end_us = 0;    ///< when everything in it was done
  /// From the newest event's stamp to the command; none in a tick without events. What a camera's transport takes at
  /// least is not in it, where stamps are put onto the robot's clock by their arrival.
  std::optional<std::int64_t> latency_us;
  std::int64_t missed = 0;  ///< ticks before it that were due and left out
  EventTraffic traffic;
  DeployState state = DeployState::unconfigured;
};

/// Hears everything in the thread of the ticks.
class DeployObserver {
 public:
  virtual ~DeployObserver() = default;
  /// After each tick. Neither allocates, throws nor waits; `tick` is valid until it returns.
  virtual void on_tick(const Tick& tick, const TickTiming& timing) = 0;
  virtual void on_change(const DeployChange& change) = 0;
  /// Robot::news.
  virtual void on_news(std::int64_t t_us, const std::string& line) = 0;
};

/// What an operator asks for. Any thread may call; the session sees it at its next tick.
class Operator {
 public:
  void activate() { wish_ = Wish::activate; }
  void stop() { wish_ = Wish::stop; }
  /// The head stops and the session ends.
  void quit(StopCause cause) {
    quit_cause_ = cause;
    quit_ = true;
  }

 private:
  friend class DeploySession;
  enum class Wish { none, activate, stop };
  std::atomic<Wish> wish_ = Wish::none;
  std::atomic<StopCause> quit_cause_ = StopCause::operator_stop;
  std::atomic<bool> quit_ = false;
};

struct DeploySessionConfig {
  std::int64_t tick_us = 1000;
  WatchdogConfig watchdog;
};

/// The loop on a robot: when a tick begins, whether the head may be moved in it, and what happens when it may not. Has
/// no clock but the robot's and no thread.
///
/// Ticks are due every tick_us. One that is over when the next is due is followed at once by the newest one that is
/// due, and those in between are left out: time that is lost is not made up for.
///
/// Before each tick of an active head the watchdog looks. On a fault, and when the operator stops it: the loop lets the
/// head go, the head (or the robot's gaze controller) is told to stop, the time that took is noted, and the
/// joints are given back (Robot::release). Detection goes on. A lost connection ends the session.
class DeploySession {
 public:
  using MakeMotion = std::function<LoopMotion()>;

  /// `robot`, `loop` (of the robot's ports), `wishes` and `observer` outlive it. `make_motion` gives what moves the
  /// head, anew at every activation; empty where nothing shall move it, then activation is refused.
  DeploySession(Robot& robot, Loop& loop, MakeMotion make_motion, Operator& wishes, DeployObserver& observer,
                const DeploySessionConfig& config);

  /// Every start-up check has passed; ticks are due from now on.
  void set_ready();
  /// One tick; false when the session is over: the operator quit, the recording ended, the connection was lost.
  bool tick();

  [[nodiscard]] DeployState state() const { return state_; }
  /// Why the head was stopped last.
  [[nodiscard]] const std::optional<Fault>& last_stop() const { return last_stop_; }

 private:
  class LastTick final : public LoopObserver {
   public:
    void on_tick(const Tick& seen) override { tick = seen; }
    std::optional<Tick> tick;
  };

  [[nodiscard]] std::int64_t plan_tick();
  [[nodiscard]] TickFacts facts(std::int64_t due_us);
  void activate(const TickFacts& facts);
  void stop(const Fault& fault);
  void change(DeployState state, const std::optional<Fault>& stop, std::int64_t took_us, std::string refused);
  bool end(PortStatus status);

  Robot& robot_;
  Loop& loop_;
  MakeMotion make_motion_;
  Operator& wishes_;
  DeployObserver& observer_;
  std::int64_t tick_us_;
  Watchdog watchdog_;
  LastTick last_;
  DeployState state_ = DeployState::unconfigured;
  std::optional<Fault> last_stop_;
  std::int64_t due_us_;         // of the last tick
  std::int64_t last_begin_us_;  // the connection stood then
  std::int64_t missed_ = 0;
};

}  // namespace saccade
