#include "apps/serve/paced_robot.h"

#include <algorithm>
#include <thread>

namespace saccade::inline v0_1 {
namespace {

constexpr std::chrono::milliseconds catch_up(20);

}  // namespace

PortStatus PacedRobot::wait_until(std::int64_t t_us) {
  if (const std::int64_t now_us = robot_.clock().now_us(); t_us > now_us) idle(t_us - now_us);
  return robot_.clock().wait_until(t_us);
}

void PacedRobot::idle(std::int64_t us) {
  due_ += std::chrono::microseconds(us);
  busy_ += SteadyClock::now() - begun_;
  std::this_thread::sleep_until(due_);
  begun_ = SteadyClock::now();
  const auto late = begun_ - due_;
  latest_ = std::max(latest_, late);
  if (late > catch_up) {
    slipped_ += late - catch_up;
    due_ += late - catch_up;
  }
}

void PacedRobot::restart() {
  due_ = begun_ = SteadyClock::now();
  busy_ = slipped_ = latest_ = {};
}

}  // namespace saccade::inline v0_1
