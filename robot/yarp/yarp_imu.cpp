#include "robot/yarp/yarp_imu.h"

#include <algorithm>
#include <chrono>
#include <limits>
#include <thread>

#include "robot/imu_message.h"

namespace saccade {
namespace {

constexpr std::int64_t oldest_imu_us = 40'000;
constexpr std::int64_t first_imu_us = 1'000'000;

static_assert(imu_message_numbers <= StateInput::most_values);

std::span<const double> numbers_of(const StateInput::State& state) {
  return std::span(state.value)
      .first(static_cast<std::size_t>(std::clamp(state.count, 0, StateInput::most_values)));
}

}  // namespace

YarpImu::YarpImu(const YarpConfig& config, const Eigen::Matrix3d& head_from_imu, const SteadyClock& clock)
    : clock_(clock),
      head_from_imu_(head_from_imu),
      input_(config.local + "/imu:i", config.imu.port, config.imu.carrier, config.timeout_s, clock) {}

PortStatus YarpImu::read_imu(ImuReading& reading) {
  lost_ = lost_ || input_.lost();
  if (lost_) return PortStatus::lost;
  const StateInput::State state = input_.state();
  const auto found = imu_reading_of(numbers_of(state), state.t_us, head_from_imu_);
  if (found && found->t_us > reading.t_us) reading = *found;
  if (!found || clock_.now_us() - state.t_us > oldest_imu_us)
    reading.angular_velocity_rad_s.setConstant(std::numeric_limits<double>::quiet_NaN());
  return PortStatus::ok;
}

StartUpCheck YarpImu::check() const {
  const std::int64_t until_us = clock_.now_us() + first_imu_us;
  while (input_.state().count == 0 && !input_.lost() && clock_.now_us() < until_us)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  const StateInput::State state = input_.state();
  const bool readable = imu_reading_of(numbers_of(state), state.t_us, head_from_imu_).has_value();
  const bool fresh = clock_.now_us() - state.t_us <= fresh_us;
  std::string found = std::to_string(state.count) + " numbers, 12 expected";
  if (readable) found = fresh ? "readings arrive" : "no reading for 0.2 s";
  if (state.count == 0) found = "connected, but no reading within 1 s";
  if (input_.lost()) found = "not connected";
  return {"inertial sensor " + input_.remote(), readable && fresh && !input_.lost(), found};
}

}  // namespace saccade
