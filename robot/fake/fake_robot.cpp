#include "robot/fake/fake_robot.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "core/error.h"
#include "core/units.h"

namespace saccade {

FakeRobot::FakeRobot(FakeRobotScript script)
    : script_(std::move(script)),
      now_us_(script_.start_us),
      reference_rad_(script_.start_rad.tail<gaze_slots>()) {
  SACCADE_CHECK(script_.lag_s > 0.0 && script_.lateness_us >= 0);
  SACCADE_CHECK(std::is_sorted(script_.events.begin(), script_.events.end(),
                               [](const Event& a, const Event& b) { return a.t_us < b.t_us; }));
  SACCADE_CHECK(std::ranges::is_sorted(script_.imu, {}, &ImuReading::t_us));
  head_.t_us = now_us_;
  head_.position_rad = script_.start_rad;
  encoders_ = head_;
}

/// Over when the end has come and the events up to it have been read.
bool FakeRobot::is_over() const {
  if (!script_.end_us || now_us_ < *script_.end_us) return false;
  return next_event_ == script_.events.size() || script_.events[next_event_].t_us > *script_.end_us;
}

void FakeRobot::move_head(std::int64_t t_us) {
  const double dt_s = 1e-6 * static_cast<double>(t_us - head_.t_us);
  const HeadCommand start_rad = head_.head_position_rad();
  const HeadCommand left_rad = (reference_rad_ - start_rad) * std::exp(-dt_s / script_.lag_s);
  const bool off = drives().joints[head_index(neck_yaw)] >= JointDrive::off;
  const bool rests = off || (script_.stuck_us && now_us_ >= *script_.stuck_us);
  const double yaw_rad = head_.position_rad[neck_yaw];
  head_.t_us = t_us;
  head_.position_rad.tail<gaze_slots>() = reference_rad_ - left_rad;
  head_.velocity_rad_s.tail<gaze_slots>() = left_rad / script_.lag_s;
  if (!rests) return;
  head_.position_rad[neck_yaw] = yaw_rad;
  head_.velocity_rad_s[neck_yaw] = 0.0;
}

HeadDrives FakeRobot::drives() const {
  HeadDrives drives = HeadDrives::all(JointDrive::references);
  if (script_.drive_us && now_us_ >= script_.drive_us->first)
    drives.joints[head_index(neck_yaw)] = script_.drive_us->second;
  return drives;
}

PortStatus FakeRobot::wait_until(std::int64_t t_us) {
  if (status_ != PortStatus::ok) return status_;
  if (t_us <= now_us_) return status_;
  if (script_.late_us && t_us >= script_.late_us->first)
    t_us += std::exchange(script_.late_us, std::nullopt)->second;
  if (is_over()) return status_ = PortStatus::ended;
  if (script_.lost_us && t_us >= *script_.lost_us) return status_ = PortStatus::lost;
  if (!script_.freeze_us || now_us_ < *script_.freeze_us) {
    move_head(std::min(t_us, script_.freeze_us.value_or(t_us)));
    encoders_ = head_;
  }
  move_head(t_us);
  now_us_ = t_us;
  return status_;
}

PortStatus FakeRobot::read_until(std::int64_t t_us, std::vector<Event>& events) {
  if (status_ != PortStatus::ok) return status_;
  SACCADE_CHECK(t_us <= now_us_);
  const std::int64_t end_us = script_.end_us.value_or(t_us);
  for (; next_event_ < script_.events.size(); ++next_event_) {
    const Event& event = script_.events[next_event_];
    if (event.t_us > end_us || event.t_us + script_.lateness_us > t_us) break;
    if (script_.silent_us && event.t_us >= *script_.silent_us) continue;
    events.push_back(event);
  }
  return is_over() ? PortStatus::ended : PortStatus::ok;
}

std::int64_t FakeRobot::heard_us() const { return std::min(now_us_, script_.silent_us.value_or(now_us_)); }

PortStatus FakeRobot::read(HeadState& state) {
  if (status_ != PortStatus::ok) return status_;
  state = encoders_;
  const auto& fault_us = script_.nan_us;
  if (fault_us && now_us_ >= fault_us->first && now_us_ < fault_us->second) {
    state.position_rad[neck_yaw] = std::numeric_limits<double>::quiet_NaN();
  }
  if (script_.outside_us && now_us_ >= *script_.outside_us) {
    state.position_rad[neck_yaw] = script_.limits.max_rad[neck_yaw] + 2.0 * rad_per_deg;
  }
  return status_;
}

HeadPort::CommandResult FakeRobot::command(const HeadCommand& reference_rad) {
  const bool rejected =
      !is_allowed(reference_rad, script_.limits) || (script_.refuse_us && now_us_ >= *script_.refuse_us);
  if (status_ == PortStatus::ok && !rejected) reference_rad_ = reference_rad;
  return {status_, rejected};
}

PortStatus FakeRobot::read_imu(ImuReading& reading) {
  if (status_ != PortStatus::ok) return status_;
  const auto next = std::ranges::upper_bound(script_.imu, now_us_, {}, &ImuReading::t_us);
  if (next != script_.imu.begin()) reading = *std::prev(next);
  return status_;
}

PortStatus FakeRobot::stop() {
  if (status_ == PortStatus::ok) reference_rad_ = head_.head_position_rad();
  return status_;
}

}  // namespace saccade
