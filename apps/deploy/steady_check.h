#pragma once

#include <vector>

#include "loop/watchdog.h"
#include "robot/robot.h"

namespace saccade {

/// Whether packets and readings come as steadily as the watchdog will demand: the longest age of the newest packet and, with
/// a head, of the newest reading within half a second is at most half of camera_silent_ms and of joints_stale_ms. A delay at
/// the start may pass: the best of three such times counts. `robot` has a clock that waits by itself.
[[nodiscard]] std::vector<StartUpCheck> steady_checks(Robot& robot, const WatchdogConfig& watchdog);

/// What a halt of this machine does to an active head. The host of a virtual machine may halt it for tens of milliseconds, at
/// any time, so it says which longer bounds safe_within_ms permits. It always passes.
[[nodiscard]] StartUpCheck halts_check(bool is_virtual, const WatchdogConfig& watchdog);

}  // namespace saccade
