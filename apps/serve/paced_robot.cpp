#include "apps/serve/paced_robot.h"

#include <algorithm>
#include <thread>

namespace saccade {
namespace {

constexpr std::chrono::milliseconds catch_up(20);

}  // namespace

PortStatus PacedRobot::wait_until(std::int64_t t_us) {
  if (const std::int64_t now_us = robot_.clock().now_us(); t_us > now_us) {
    idle(t_us - now_us);
    if (step_begins_) step_begins_(std::chrono::duration_cast<std::chrono::microseconds>(late_).count());
  }
  return robot_.clock().wait_until(t_us);
}

void PacedRobot::idle(std::int64_t us) {
  due_ += std::chrono::microseconds(us);
  const auto took = SteadyClock::now() - begun_;
  busy_ += took;
  longest_ = std::max(longest_, took);
  std::this_thread::sleep_until(due_);
  begun_ = SteadyClock::now();
  late_ = begun_ - due_;
  latest_ = std::max(latest_, late_);
  if (late_ > catch_up) {
    slipped_ += late_ - catch_up;
    due_ += late_ - catch_up;
  }
}

void PacedRobot::restart() {
  due_ = begun_ = SteadyClock::now();
  busy_ = slipped_ = latest_ = longest_ = late_ = {};
}

}  // namespace saccade
