#include "apps/deploy/guard_run.h"

#include <fmt/format.h>

#include <chrono>
#include <limits>
#include <thread>

#include "apps/deploy/guard_head.h"
#include "apps/deploy/guard_link.h"
#include "config/robot_file.h"
#include "core/error.h"
#include "session/close_within.h"
#include "session/interrupt.h"
#include "session/real_time.h"

namespace saccade {
namespace {

constexpr auto look_period = std::chrono::milliseconds(2);
constexpr std::int64_t retry_ns = 5'000'000;

/// Says on the board that there is no guard, whatever ends the scope.
class Presence {
 public:
  explicit Presence(GuardBoard& board) : board_(board) {}
  Presence(const Presence&) = delete;
  Presence& operator=(const Presence&) = delete;
  ~Presence() { board_.connected = 0; }

 private:
  GuardBoard& board_;
};

void print(const std::string& line) {
  fmt::print(stderr, "{}\n", line);
  std::fflush(stderr);
}

/// Prints each change of the connection, and each new reason why it cannot be made again.
class Connection {
 public:
  bool update(GuardHead& head) {
    const bool connected = head.is_connected();
    if (connected != connected_) print(connected ? "connected to the head" : "the head is not connected");
    connected_ = connected;
    if (connected) problem_.clear();
    if (connected || ++looks_ % looks_per_problem != 0) return connected;
    if (std::string problem = head.problem(); !problem.empty() && problem != problem_) {
      print("the connection to the head is tried again each second: " + problem);
      problem_ = std::move(problem);
    }
    return connected;
  }

 private:
  static constexpr int looks_per_problem = 250;  // every 0.5 s
  bool connected_ = false;
  int looks_ = 0;
  std::string problem_;
};

}  // namespace

void guard(const GuardOptions& options, const Registry& registry) {
  const RobotFile file = read_robot_file(options.robot, options.assignments, registry);
  catch_interrupts();
  use_small_stacks();
  auto head =
      std::make_unique<GuardHead>([&file] { return open_head_stopper(file.robot, robot_context(file)); });
  const std::string name = file.robot.head_name();
  SharedMemory present("guarding-" + name, 1);
  if (!present.lock()) throw RunError("the head " + name + " has a guard on this machine already");
  SharedMemory memory("guard-" + name, sizeof(GuardBoard));
  GuardBoard& board = *static_cast<GuardBoard*>(memory.data());
  const Presence presence(board);
  const std::int64_t hang_ns = std::llround(file.deploy.watchdog.hang_ms * 1e6);
  board.guard_hang_ns = hang_ns;
  const RealTime real_time;
  print(real_time.summary());
  if (!real_time.granted()) {
    print("warning: other programs of this machine can delay the guard's stop: " + how_to_permit_real_time());
  }
  print("guards the head " + name);

  GuardWatch watch(hang_ns);
  const std::int64_t end_ns = options.duration_s ? machine_ns() + std::llround(*options.duration_s * 1e9)
                                                 : std::numeric_limits<std::int64_t>::max();
  Connection connection;
  std::uint64_t unreached = 0;  // the activation whose head could not be stopped
  std::int64_t told_ns = hang_ns;
  while (!interrupted() && machine_ns() < end_ns) {
    board.connected = connection.update(*head) ? 1 : 0;
    board.guard_ns = machine_ns();
    const std::uint64_t moving = board.moving;
    if (const std::int64_t other_ns = board.hang_ns; moving != 0 && other_ns != told_ns) {
      told_ns = other_ns;
      print(fmt::format(
          "warning: deploy has deploy.watchdog.hang_ms {:g}, this guard {:g}: start both with the same file "
          "and --set",
          1e-6 * static_cast<double>(other_ns), 1e-6 * static_cast<double>(hang_ns)));
    }
    if (unreached != 0 && moving != unreached)
      unreached = 0;  // deploy has stopped the head, or has begun again
    if (unreached != 0 && head->stop()) {
      unreached = 0;
      print("the head was stopped: its connection is back");
    }
    if (watch.look(board, machine_ns()) == GuardWatch::Action::stop) {
      const std::int64_t age_ns = watch.age_ns();
      const std::int64_t began_ns = machine_ns();
      bool reached = head->stop();
      board.stopped = moving;  // deploy, if it goes on, sends nothing more
      while (!reached && machine_ns() - began_ns < 20 * retry_ns) {
        std::this_thread::sleep_for(std::chrono::nanoseconds(retry_ns));
        reached = head->stop();
      }
      if (!reached) unreached = moving;
      print(fmt::format("no tick of deploy for {:.1f} ms: {} {:.1f} ms after the last tick",
                        1e-6 * static_cast<double>(age_ns),
                        reached ? "the head was stopped" : "the head could not be stopped,",
                        1e-6 * static_cast<double>(age_ns + machine_ns() - began_ns)));
    }
    std::this_thread::sleep_for(look_period);
  }
  board.connected = 0;
  close_within(longest_close, [&] { head.reset(); }, {});
}

}  // namespace saccade
