#include "loop/watchdog.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "head/head_model.h"

namespace saccade {
namespace {

// Of FollowWatch. Friction and backlash let a joint rest by less than the second while its reference moves.
constexpr double stuck_within_rad = 0.2 * rad_per_deg, stuck_reference_rad = 3.0 * rad_per_deg;

constexpr double look_ms = 2.0;  // between two looks of those who stop the head when no tick comes

double longest_silence_ms(const WatchdogConfig& config) {
  return std::max(config.camera_silent_ms, config.joints_stale_ms);
}

double ms(std::int64_t us) { return static_cast<double>(us) * 1e-3; }

std::optional<Fault> check_drives(const HeadDrives& drives, const HeadModel& head, std::int64_t now_us) {
  for (int j = 0; j < head.gaze_joints(); ++j) {
    const JointDrive drive = drives.joints[static_cast<std::size_t>(j)];
    if (drive == JointDrive::references) continue;
    const StopCause cause = drive == JointDrive::off     ? StopCause::joint_off
                            : drive == JointDrive::fault ? StopCause::joint_fault
                                                         : StopCause::joint_taken;
    return Fault{cause, now_us, head.name_of(torso_slots + j), 0.0};
  }
  return std::nullopt;
}

}  // namespace

void describe(FieldVisitor& v, WatchdogConfig& config) {
  v.real("safe_within_ms", config.safe_within_ms, {1.0, 1000.0},
         "longest time from a fault to the stop of the head");
  v.real("tick_late_ms", config.tick_late_ms, {1.0, 1000.0}, "delay of a tick above which the head stops");
  v.real("camera_silent_ms", config.camera_silent_ms, {2.0, 1000.0},
         "time without a packet from the camera after which the head stops");
  v.real("joints_stale_ms", config.joints_stale_ms, {2.0, 1000.0},
         "age of the newest reading of the joints above which the head stops");
  v.real("joint_outside_deg", config.joint_outside_deg, {0.0, 10.0},
         "distance of a joint outside its limits above which the head stops");
  v.real("joint_lag_deg", config.joint_lag_deg, {0.1, 180.0},
         "distance of a joint from its reference above which it does not follow");
  v.real("joint_lag_ms", config.joint_lag_ms, {10.0, 10000.0},
         "time for which a joint does not follow after which the head stops");
  v.real("hang_ms", config.hang_ms, {5.0, 1000.0},
         "time without a tick after which a thread of its own, and the guard, stop the head");
  const double unnoticed = std::max(config.tick_late_ms, config.hang_ms + look_ms);
  const double longest = longest_silence_ms(config) + unnoticed;
  v.require(longest <= config.safe_within_ms, "safe_within_ms", text_of(config.safe_within_ms),
            "at least " + text_of(longest) +
                ": the longer of camera_silent_ms and joints_stale_ms, and then a tick that is late "
                "(tick_late_ms) or hangs (hang_ms, seen 2 ms later)");
}

double longest_halt_ms(const WatchdogConfig& config) {
  return config.safe_within_ms - longest_silence_ms(config) - look_ms;
}

std::string Fault::description() const {
  switch (cause) {
    case StopCause::operator_stop:
      return "by the operator";
    case StopCause::interrupted:
      return "by a signal";
    case StopCause::ended:
      return "the run is over";
    case StopCause::lost:
      return fmt::format("lost the connection to the {}", part);
    case StopCause::camera_silent:
      return fmt::format("no packet from the camera for {:.1f} ms", amount);
    case StopCause::joints_stale:
      return fmt::format("no reading of the joints for {:.1f} ms", amount);
    case StopCause::joints_not_finite:
      return fmt::format("{} is not a number", part);
    case StopCause::joint_outside:
      return fmt::format("{} is {:.1f} deg outside its limits", part, amount);
    case StopCause::joint_off:
      return fmt::format("{} was switched off", part);
    case StopCause::joint_fault:
      return fmt::format("{} is in hardware fault", part);
    case StopCause::joint_taken:
      return fmt::format("{} no longer follows references: its mode was changed, or is not reported", part);
    case StopCause::command_refused:
      return "the head rejected a reference";
    case StopCause::joint_lags:
      return fmt::format("{} has not followed its reference for {:.0f} ms", part, amount);
    case StopCause::tick_hangs:
      return fmt::format("no tick for {:.1f} ms", amount);
    case StopCause::guard_lost:
      return fmt::format("no sign of the guard for {:.1f} ms", amount);
    case StopCause::guard_stops:
      return "by the guard";
    case StopCause::tick_late:
      return fmt::format("a tick came {:.1f} ms late", amount);
  }
  return {};
}

Watchdog::Watchdog(const WatchdogConfig& config, const JointLimits& limits)
    : config_(config), limits_(limits) {
  check_config("watchdog", config);
}

std::optional<Fault> Watchdog::check(const TickFacts& facts) const {
  const double silent_ms = ms(facts.now_us - facts.heard_us);
  if (silent_ms > config_.camera_silent_ms)
    return Fault{StopCause::camera_silent, facts.heard_us, {}, silent_ms};
  if (facts.head) {
    const HeadState& head = *facts.head;
    const double stale_ms = ms(facts.now_us - head.t_us);
    if (stale_ms > config_.joints_stale_ms) return Fault{StopCause::joints_stale, head.t_us, {}, stale_ms};
    for (const HeadJoint& joint : limits_.head->joints) {
      const Eigen::Index j = joint.slot;
      const std::string_view name = joint.name;
      if (!std::isfinite(head.position_rad[j]) || !std::isfinite(head.velocity_rad_s[j]))
        return Fault{StopCause::joints_not_finite, head.t_us, name, 0.0};
      if (joint.role == JointRole::torso) continue;
      const double outside_deg = deg_per_rad * std::max(limits_.min_rad[j] - head.position_rad[j],
                                                        head.position_rad[j] - limits_.max_rad[j]);
      if (outside_deg > config_.joint_outside_deg)
        return Fault{StopCause::joint_outside, head.t_us, name, outside_deg};
    }
  }
  if (facts.drives) {
    if (const auto fault = check_drives(*facts.drives, *limits_.head, facts.now_us)) return fault;
  }
  if (facts.refused_us) return Fault{StopCause::command_refused, *facts.refused_us, {}, 0.0};
  if (facts.lags_since_us) {
    const double lag_ms = ms(facts.now_us - *facts.lags_since_us);
    const std::string_view name = limits_.head->name_of(facts.lagging);
    if (lag_ms > config_.joint_lag_ms) return Fault{StopCause::joint_lags, facts.now_us, name, lag_ms};
  }
  const double late_ms = ms(facts.now_us - facts.due_us);
  if (late_ms > config_.tick_late_ms) return Fault{StopCause::tick_late, facts.due_us, {}, late_ms};
  return std::nullopt;
}

const HeadJointVector& FollowWatch::reference_at(std::int64_t read_us) const {
  const std::size_t oldest = sent_ - std::min(sent_, history_.size());
  std::size_t i = sent_ - 1;
  while (i > oldest && history_[i % history_.size()].t_us > read_us) --i;
  return history_[i % history_.size()].reference_rad;
}

void FollowWatch::update(std::int64_t t_us, const HeadJointVector& reference_rad, std::int64_t read_us,
                         const HeadJointVector& position_rad) {
  history_[sent_++ % history_.size()] = {t_us, reference_rad};
  const HeadJointVector& then_rad = reference_at(read_us);
  for (Eigen::Index j = 0; j < gaze_slots; ++j) {
    Joint& joint = joints_[static_cast<std::size_t>(j)];
    const double reference = then_rad[j], position = position_rad[j];
    if (!(std::abs(reference - position) > lag_rad_)) {
      joint.far_since_us.reset();
    } else if (!joint.far_since_us) {
      joint.far_since_us = t_us;
    }
    if (!joint.rest_rad || !(std::abs(position - *joint.rest_rad) <= stuck_within_rad)) {
      joint.rest_rad = position;
      joint.least_rad = joint.largest_rad = reference;
      joint.stuck_since_us.reset();
    }
    joint.least_rad = std::min(joint.least_rad, reference);
    joint.largest_rad = std::max(joint.largest_rad, reference);
    if (!joint.stuck_since_us && joint.largest_rad - joint.least_rad > stuck_reference_rad)
      joint.stuck_since_us = t_us;
  }
}

void FollowWatch::add_to(TickFacts& facts) const {
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    for (const std::optional<std::int64_t>& since_us : {joints_[j].far_since_us, joints_[j].stuck_since_us}) {
      if (!since_us || (facts.lags_since_us && *facts.lags_since_us <= *since_us)) continue;
      facts.lags_since_us = since_us;
      facts.lagging = torso_slots + static_cast<int>(j);
    }
  }
}

}  // namespace saccade
