#pragma once

#include <cstdint>
#include <vector>

#include "core/random.h"
#include "robot/fake/fake_robot.h"

namespace saccade {

/// Limits of +-1 rad with the middle off zero, and 2 rad/s.
inline JointLimits unit_limits() {
  return {JointVector::Constant(-0.9), JointVector::Constant(1.1), JointVector::Constant(2.0)};
}

/// A world of 0.5 s from `start_us` on: 2000 events all over a 128x128 image, some at the same time.
inline FakeRobotScript scripted_world(std::int64_t start_us = 1'000'000) {
  const RandomStream random(3, "scripted_world");
  FakeRobotScript script;
  script.start_us = start_us;
  script.end_us = start_us + 500'000;
  script.limits = unit_limits();
  script.start_rad.setConstant(-0.2);
  for (std::uint64_t i = 0; i < 2000; ++i) {
    script.events.push_back({start_us + static_cast<std::int64_t>(i / 2 * 500 + random.bits(0, i / 2) % 500),
                             static_cast<std::uint16_t>(random.bits(1, i) % 128),
                             static_cast<std::uint16_t>(random.bits(2, i) % 128),
                             (random.bits(3, i) & 1) != 0, 0});
  }
  return script;
}

}  // namespace saccade
