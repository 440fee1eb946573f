#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "robot/ports.h"

namespace saccade {

/// What a FakeRobot shall do. Instants are in its own clock, us.
struct FakeRobotScript {
  ImageSize image_size{128, 128};
  std::vector<Event> events;     ///< sorted by time, inside the image
  std::int64_t lateness_us = 0;  ///< an event is delivered this long after its stamp
  std::int64_t start_us = 0;
  std::optional<std::int64_t> end_us;   ///< the world is over here, as at the end of a recording
  std::optional<std::int64_t> lost_us;  ///< every port is lost from here on
  std::optional<std::int64_t>
      silent_us;  ///< nothing comes from the camera from here on, no empty packet either
  std::optional<std::int64_t> freeze_us;  ///< the encoders say the same from here on, with that stamp
  /// In [first, second) the encoder of the neck's yaw reads NaN.
  std::optional<std::pair<std::int64_t, std::int64_t>> nan_us;
  std::optional<std::int64_t> outside_us;  ///< from here on it reads 2 deg beyond its upper limit
  /// The first wait that would end at `first` or later ends `second` later than that.
  std::optional<std::pair<std::int64_t, std::int64_t>> late_us;

  JointLimits limits;
  JointVector start_rad = JointVector::Zero();
  double lag_s = 0.05;  ///< time constant with which the head follows its reference, > 0
};

/// A robot for tests, without noise: scripted events, and a head whose neck and eyes follow each reference
/// with a first-order lag, exactly (x += (reference - x)(1 - exp(-dt / lag)), whatever the steps). It does
/// not hold limits().max_speed_rad_s. The torso stays.
class FakeRobot final : public Clock, public EventSource, public HeadPort {
 public:
  explicit FakeRobot(FakeRobotScript script);

  [[nodiscard]] std::int64_t now_us() const override { return now_us_; }
  PortStatus wait_until(std::int64_t t_us) override;

  [[nodiscard]] ImageSize image_size() const override { return script_.image_size; }
  PortStatus read_until(std::int64_t t_us, std::vector<Event>& events) override;
  [[nodiscard]] std::int64_t heard_us() const override;
  [[nodiscard]] EventTraffic traffic() const override { return {}; }

  [[nodiscard]] JointLimits limits() const override { return script_.limits; }
  PortStatus read(HeadState& state) override;
  CommandResult command(const HeadCommand& reference_rad) override;
  PortStatus stop() override;

  /// The reference that holds now; where the head started, before the first command.
  [[nodiscard]] const HeadCommand& reference_rad() const { return reference_rad_; }

 private:
  [[nodiscard]] bool is_over() const;
  void move_head(std::int64_t t_us);

  FakeRobotScript script_;
  std::size_t next_event_ = 0;
  std::int64_t now_us_;
  PortStatus status_ = PortStatus::ok;
  HeadCommand reference_rad_;
  HeadState head_;
  HeadState encoders_;
};

}  // namespace saccade
