#include "apps/deploy/guard_link.h"

#include <fmt/format.h>

#include "core/error.h"

namespace saccade {

GuardLink::GuardLink(const std::string& head, GuardUse use, std::int64_t bound_ns)
    : memory_("guard-" + head, sizeof(GuardBoard)),
      board_(*static_cast<GuardBoard*>(memory_.data())),
      use_(use),
      bound_ns_(bound_ns) {
  if (!memory_.lock())
    throw RunError("another deploy on this machine moves the head " + head + ": stop it first");
  board_.moving = 0;
  board_.hang_ns = bound_ns_;
  activation_ = board_.activations;
}

GuardLink::~GuardLink() { board_.moving = 0; }

bool GuardLink::has_guard() const {
  return board_.connected.load() == 1 && board_.guard_hang_ns.load() == bound_ns_ &&
         machine_ns() - board_.guard_ns.load() <= bound_ns_;
}

std::string GuardLink::guard_problem() const {
  if (machine_ns() - board_.guard_ns.load() > bound_ns_)
    return "none watches this head: start `saccade guard` with the same file";
  if (const std::int64_t other_ns = board_.guard_hang_ns.load(); other_ns != bound_ns_)
    return fmt::format(
        "the one that watches this head has deploy.watchdog.hang_ms {:g}, and this deploy {:g}: start both "
        "with the "
        "same file and --set",
        1e-6 * static_cast<double>(other_ns), 1e-6 * static_cast<double>(bound_ns_));
  if (board_.connected.load() != 1)
    return "the one that watches this head has no connection to it, and tries again each second";
  return {};
}

void GuardLink::on_tick() { board_.tick_ns.store(machine_ns(), std::memory_order_release); }

std::optional<Fault> GuardLink::fault() {
  if (use_ == GuardUse::none) return std::nullopt;
  if (board_.stopped.load(std::memory_order_acquire) == activation_)
    return Fault{StopCause::guard_stops, 0, {}, 0.0};
  guarded_ = has_guard();
  if (guarded_ || use_ == GuardUse::optional) return std::nullopt;
  return Fault{StopCause::guard_lost, 0, {}, 1e-6 * static_cast<double>(machine_ns() - board_.guard_ns)};
}

std::string GuardLink::why_not() {
  if (use_ != GuardUse::required) return {};
  const std::string problem = guard_problem();
  return problem.empty() ? problem : "deploy.guard is required and " + problem;
}

std::string GuardLink::warning() {
  if (use_ == GuardUse::none) return "no guard: deploy.guard is none";
  const std::string problem = guard_problem();
  return problem.empty() ? problem : "no guard: " + problem;
}

void GuardLink::activating() {
  board_.moving = 0;
  activation_ = board_.activations + 1;
  board_.activations = activation_;
}

void GuardLink::activated() {
  guarded_ = use_ != GuardUse::none && has_guard();
  on_tick();
  board_.moving = activation_;
}

void GuardLink::released() { board_.moving = 0; }

GuardWatch::Action GuardWatch::look(const GuardBoard& board, std::int64_t now_ns) {
  const std::uint64_t moving = board.moving.load(std::memory_order_acquire);
  age_ns_ = now_ns - board.tick_ns.load(std::memory_order_acquire);
  if (moving == 0 || moving == handled_ || age_ns_ <= bound_ns_) return Action::none;
  handled_ = moving;
  return Action::stop;
}

}  // namespace saccade
