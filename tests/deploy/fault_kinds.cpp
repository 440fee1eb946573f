#include "tests/deploy/fault_kinds.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <span>

#include "core/error.h"
#include "robot/event_packet.h"
#include "robot/number_list.h"
#include "tests/control/genova02.h"

namespace saccade {
namespace {

constexpr std::array<const char*, static_cast<std::size_t>(FaultKind::count)> names = {
    "camera silent",
    "joint readings frozen",
    "encoder not a number",
    "joint outside its limits",
    "joint switched off",
    "joint in hardware fault",
    "joint's mode changed",
    "reference rejected",
    "joint stuck",
    "tick late",
    "connection lost",
    "guard hangs",
    "stop by the guard",
    "operator stops",
    "operator quits",
    "camera's messages broken",
    "joints' messages broken",
    "the robot's programs halted",
    "deploy killed",
    "deploy halted, then continued",
    "guard killed",
    "operator insists on activation",
    "operator activates again and stops",
    "disk full",
    "disk slow",
    "disk fails",
};

/// A message as a broken or hostile sender makes it of a whole one: cut off, with a false count, or with false bytes.
std::vector<std::byte> broken(std::vector<std::byte> message, const RandomStream& random,
                              std::uint64_t trial) {
  const std::uint64_t choice = random.bits(60, trial) % 3;
  const auto place = [&](std::uint64_t stream) { return random.bits(stream, trial) % message.size(); };
  if (choice == 0) {
    message.resize(place(61));
  } else if (choice == 1) {
    const auto count = static_cast<std::int32_t>(random.bits(62, trial));
    std::memcpy(message.data() + 4, &count, sizeof count);
  } else {
    for (std::uint64_t i = 0; i < 8; ++i)
      message[place(63 + i)] = static_cast<std::byte>(random.bits(72 + i, trial));
  }
  return message;
}

constexpr std::uint64_t most_attempts = 64;

/// Breaks messages of the camera until the parser rejects one. One that it accepts has no more events than bytes.
void check_broken_camera_messages(const RandomStream& random, std::uint64_t trial) {
  const auto format = static_cast<PacketFormat>(random.bits(59, trial) % packet_format_names().size());
  for (std::uint64_t attempt = 0; attempt < most_attempts; ++attempt) {
    EventPacket packet{1000, std::vector<WireEvent>(50, {1, 2})};
    std::vector<std::byte> message;
    write_packet(packet, format, message);
    message = broken(message, random, trial * most_attempts + attempt);
    if (!read_packet(message, format, packet).empty()) return;
    SACCADE_CHECK(packet.events.size() * 4 <= message.size());
  }
  SACCADE_CHECK(false && "a broken message that is rejected");
}

/// The same with readings of the joints.
void check_broken_joint_messages(const RandomStream& random, std::uint64_t trial) {
  std::vector<std::byte> message(8 + 6 * sizeof(double));
  const std::array<std::int32_t, 2> head = {256 + 10, 6};
  std::memcpy(message.data(), head.data(), sizeof head);
  for (std::uint64_t attempt = 0; attempt < most_attempts; ++attempt) {
    std::array<double, 12> values{};
    int count = 0;
    if (!read_number_list(broken(message, random, trial * most_attempts + attempt), values, count).empty())
      return;
  }
  SACCADE_CHECK(false && "a broken message that is rejected");
}

void demand_stop(Faults& faults, StopCause cause, std::int64_t at_us) {
  if (!faults.demand || at_us < faults.demand->second) faults.demand = {cause, at_us};
}

void silence(std::optional<std::int64_t>& since_us, std::int64_t at_us) {
  since_us = std::min(since_us.value_or(at_us), at_us);
}

void add(Faults& faults, FaultKind kind, std::int64_t at_us, const RandomStream& random,
         std::uint64_t trial) {
  FakeRobotScript& script = faults.script;
  switch (kind) {
    case FaultKind::broken_camera_messages:
      check_broken_camera_messages(random, trial);
      [[fallthrough]];
    case FaultKind::camera_silent:
      silence(script.silent_us, at_us);
      break;
    case FaultKind::broken_joint_messages:
      check_broken_joint_messages(random, trial);
      [[fallthrough]];
    case FaultKind::joints_frozen:
      silence(script.freeze_us, at_us);
      break;
    case FaultKind::robot_halted:
      silence(script.silent_us, at_us);
      silence(script.freeze_us, at_us);
      break;
    case FaultKind::encoder_not_a_number:
      script.nan_us = {at_us, at_us + 1'000 + static_cast<std::int64_t>(random.uniform(0.0, 2e5, 90, trial))};
      break;
    case FaultKind::joint_outside:
      script.outside_us = at_us;
      break;
    case FaultKind::joint_off:
      script.drive_us = {at_us, JointDrive::off};
      break;
    case FaultKind::joint_fault:
      script.drive_us = {at_us, JointDrive::fault};
      break;
    case FaultKind::joint_taken:
      script.drive_us = {at_us, JointDrive::held};
      break;
    case FaultKind::command_refused:
      script.refuse_us = at_us;
      break;
    case FaultKind::joint_stuck:
      script.stuck_us = at_us;
      break;
    case FaultKind::tick_late:
      script.late_us = {at_us, static_cast<std::int64_t>(random.uniform(21e3, 95e3, 91, trial))};
      break;
    case FaultKind::connection_lost:
      script.lost_us = at_us;
      break;
    case FaultKind::guard_lost:
      demand_stop(faults, StopCause::guard_lost, at_us);
      break;
    case FaultKind::guard_stops:
      demand_stop(faults, StopCause::guard_stops, at_us);
      break;
    case FaultKind::guard_killed:
      faults.guard_killed_us = at_us;
      break;
    case FaultKind::deploy_killed:
      faults.killed_us = at_us;
      break;
    case FaultKind::deploy_halted:
      faults.halted_us = {at_us, at_us + static_cast<std::int64_t>(random.uniform(5e3, 8e5, 92, trial))};
      break;
    case FaultKind::operator_insists:
      faults.insists = true;
      silence(script.silent_us, at_us);
      break;
    case FaultKind::operator_hurries:
      faults.hurries_us = at_us;
      break;
    case FaultKind::operator_stops:
      faults.stop_us = at_us;
      break;
    case FaultKind::operator_quits:
    case FaultKind::count:
      faults.quit_us = at_us;
      break;
    case FaultKind::disk_full:
    case FaultKind::disk_slow:
    case FaultKind::disk_fails:
      faults.disk = kind;
      break;
  }
  faults.list.emplace_back(kind, at_us);
}

/// Whether a trial with `faults` may have this one too. A guard and a deploy that die together leave nobody who stops the
/// head, and neither does a lost connection (docs/safety.md).
bool fits(const Faults& faults, FaultKind kind) {
  const auto any = [&](std::initializer_list<FaultKind> kinds) {
    return std::ranges::any_of(kinds, [&](FaultKind other) { return faults.has(other); });
  };
  const auto is_one_of = [&](std::initializer_list<FaultKind> kinds) {
    return std::ranges::find(kinds, kind) != kinds.end();
  };
  const auto exclude = [&](std::initializer_list<FaultKind> some, std::initializer_list<FaultKind> others) {
    return (is_one_of(some) && any(others)) || (is_one_of(others) && any(some));
  };
  if (exclude(
          {FaultKind::deploy_killed, FaultKind::deploy_halted},
          {FaultKind::guard_killed, FaultKind::guard_lost, FaultKind::tick_late, FaultKind::connection_lost}))
    return false;
  // An activation after a fault that has passed is no error of the operator.
  if (faults.insists || (kind == FaultKind::operator_insists && !faults.list.empty())) return false;
  if (is_of_disk(kind) && faults.disk) return false;
  return !faults.has(kind);
}

}  // namespace

const char* name_of(FaultKind kind) { return names.at(static_cast<std::size_t>(kind)); }

std::vector<StopCause> right_causes(FaultKind kind) {
  switch (kind) {
    case FaultKind::camera_silent:
    case FaultKind::broken_camera_messages:
    case FaultKind::operator_insists:
      return {StopCause::camera_silent};
    case FaultKind::joints_frozen:
    case FaultKind::broken_joint_messages:
      return {StopCause::joints_stale};
    case FaultKind::robot_halted:
      return {StopCause::camera_silent, StopCause::joints_stale};
    case FaultKind::encoder_not_a_number:
      return {StopCause::joints_not_finite};
    case FaultKind::joint_outside:
      return {StopCause::joint_outside};
    case FaultKind::joint_off:
      return {StopCause::joint_off};
    case FaultKind::joint_fault:
      return {StopCause::joint_fault};
    case FaultKind::joint_taken:
      return {StopCause::joint_taken};
    case FaultKind::command_refused:
      return {StopCause::command_refused};
    case FaultKind::joint_stuck:
      return {StopCause::joint_lags};
    case FaultKind::tick_late:
      return {StopCause::tick_late, StopCause::guard_stops};
    case FaultKind::deploy_halted:
      return {StopCause::guard_stops, StopCause::tick_late};
    case FaultKind::connection_lost:
      return {StopCause::lost};
    case FaultKind::guard_lost:
    case FaultKind::guard_killed:
      return {StopCause::guard_lost};
    case FaultKind::guard_stops:
      return {StopCause::guard_stops};
    case FaultKind::operator_stops:
    case FaultKind::operator_quits:
    case FaultKind::operator_hurries:
    case FaultKind::disk_full:
    case FaultKind::disk_slow:
    case FaultKind::disk_fails:
      return {StopCause::operator_stop};
    case FaultKind::deploy_killed:
    case FaultKind::count:
      break;
  }
  return {};
}

bool Faults::has(FaultKind kind) const {
  return std::ranges::any_of(list, [kind](const auto& fault) { return fault.first == kind; });
}

bool Faults::is_dead(std::int64_t t_us) const {
  return (killed_us && t_us >= *killed_us) ||
         (halted_us && t_us >= halted_us->first && t_us < halted_us->second);
}

std::string Faults::text() const {
  std::string text;
  for (const auto& [kind, at_us] : list)
    text += fmt::format("{}{} at {} us", text.empty() ? "" : ", ", name_of(kind), at_us);
  return text;
}

Faults make_faults(const RandomStream& random, std::uint64_t trial) {
  Faults faults;
  faults.script.limits = genova02_limits();
  faults.script.lag_s = random.uniform(0.01, 0.06, 0, trial);
  const auto count = 1 + (random.bits(1, trial) % 4 == 0 ? 1 + random.bits(2, trial) % 2 : 0);
  const auto first_us = static_cast<std::int64_t>(random.uniform(2e5, 1.5e6, 3, trial));
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto kind =
        static_cast<FaultKind>(random.bits(10 + i, trial) % static_cast<std::uint64_t>(FaultKind::count));
    if (!fits(faults, kind)) continue;
    const auto later_us = i == 0 ? 0.0 : random.uniform(0.0, 8e4, 20 + i, trial);
    add(faults, kind, first_us + static_cast<std::int64_t>(later_us), random, trial);
  }
  // A fault of the disk alone stops nothing: the operator does, to see that it still works.
  if (std::ranges::all_of(faults.list, [](const auto& fault) { return is_of_disk(fault.first); }))
    faults.stop_us = first_us + 500'000;
  return faults;
}

}  // namespace saccade
