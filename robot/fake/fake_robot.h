#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "robot/robot.h"

namespace saccade {

/// Script of a FakeRobot: its events, faults and head. Times in us of its own clock.
struct FakeRobotScript {
  ImageSize image_size{128, 128};
  std::vector<Event> events;     ///< sorted by time, inside the image
  std::int64_t lateness_us = 0;  ///< delay from an event's time stamp to its delivery
  std::int64_t start_us = 0;
  std::optional<std::int64_t> end_us;     ///< time ends here, as at the end of a recording
  std::optional<std::int64_t> lost_us;    ///< every port is lost from here on
  std::optional<std::int64_t> silent_us;  ///< the camera sends nothing from here on, not even empty packets
  std::optional<std::int64_t>
      freeze_us;  ///< the encoders repeat the reading of this time, with its time stamp
  /// In [first, second) the encoder of neck yaw reads NaN.
  std::optional<std::pair<std::int64_t, std::int64_t>> nan_us;
  std::optional<std::int64_t> outside_us;  ///< from here on neck yaw reads 2 deg above its upper limit
  /// From `first` on the board reports that neck yaw is in this mode. A joint that is off or in fault stays where it is.
  std::optional<std::pair<std::int64_t, JointDrive>> drive_us;
  std::optional<std::int64_t> refuse_us;  ///< the head rejects every command from here on
  std::optional<std::int64_t> stuck_us;   ///< neck yaw does not move from here on
  /// The first wait that would end at `first` or later ends later by `second`.
  std::optional<std::pair<std::int64_t, std::int64_t>> late_us;

  /// Readings of an inertial measurement unit, by the time at which they arrive, t_us; none: the robot has none.
  std::vector<ImuReading> imu;

  JointLimits limits;
  JointVector start_rad = JointVector::Zero();
  double lag_s = 0.05;  ///< time constant with which the head follows its reference, > 0
};

/// A robot for tests without noise: scripted events, and a head whose neck and eyes follow each reference with a
/// first-order lag. The lag is exact for any step: x += (reference - x)(1 - exp(-dt / lag)). Speed is not limited to
/// limits().max_speed_rad_s. The torso does not move.
class FakeRobot final : public Robot, public Clock, public EventSource, public HeadPort, public ImuPort {
 public:
  explicit FakeRobot(FakeRobotScript script);

  Clock& clock() override { return *this; }
  EventSource& events() override { return *this; }
  HeadPort* head() override { return this; }
  ImuPort* imu() override { return script_.imu.empty() ? nullptr : this; }

  [[nodiscard]] std::int64_t now_us() const override { return now_us_; }
  PortStatus wait_until(std::int64_t t_us) override;

  [[nodiscard]] ImageSize image_size() const override { return script_.image_size; }
  PortStatus read_until(std::int64_t t_us, std::vector<Event>& events) override;
  [[nodiscard]] std::int64_t heard_us() const override;
  [[nodiscard]] EventTraffic traffic() const override { return {}; }

  [[nodiscard]] JointLimits limits() const override { return script_.limits; }
  PortStatus read(HeadState& state) override;
  [[nodiscard]] HeadDrives drives() const override;
  CommandResult command(const HeadCommand& reference_rad) override;
  PortStatus stop() override;
  /// The newest scripted reading up to now; before the first one unchanged.
  PortStatus read_imu(ImuReading& reading) override;

  /// The newest reference, rad; before the first command the start position.
  [[nodiscard]] const HeadCommand& reference_rad() const { return reference_rad_; }

 private:
  [[nodiscard]] bool is_over() const;
  void move_head(std::int64_t t_us);

  FakeRobotScript script_;
  std::size_t next_event_ = 0;
  std::int64_t now_us_;
  PortStatus status_ = PortStatus::ok;
  HeadCommand reference_rad_ = HeadCommand::Zero();
  HeadState head_;
  HeadState encoders_;
};

}  // namespace saccade
