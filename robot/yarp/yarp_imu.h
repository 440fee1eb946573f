#pragma once

#include <Eigen/Core>

#include "robot/ports.h"
#include "robot/robot.h"
#include "robot/yarp/state_input.h"
#include "robot/yarp/yarp_config.h"

namespace saccade {

/// The inertial sensor of a robot on YARP, a port of 12 numbers (imu_reading_of). `lost` when its connection closes. The
/// angular velocity is NaN while the newest message is older than 40 ms, or unreadable.
class YarpImu final : public ImuPort {
 public:
  /// Throws RunError if the local port cannot be opened.
  YarpImu(const YarpConfig& config, const Eigen::Matrix3d& head_from_imu, const SteadyClock& clock);

  PortStatus read_imu(ImuReading& reading) override;
  /// Whether readings arrive.
  [[nodiscard]] StartUpCheck check() const;

 private:
  const SteadyClock& clock_;
  Eigen::Matrix3d head_from_imu_;
  StateInput input_;
  bool lost_ = false;
};

}  // namespace saccade
