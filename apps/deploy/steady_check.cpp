#include "apps/deploy/steady_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>

namespace saccade {
namespace {

constexpr std::int64_t steady_window_us = 500'000;
constexpr std::int64_t steady_look_us = 1'000;
constexpr int steady_windows = 3;

/// The longest ages within a time, ms.
struct LongestAges {
  double packet_ms = 0.0;
  std::optional<double> reading_ms;  ///< none without a head, or where it is lost
};

LongestAges watch_ages(Robot& robot) {
  LongestAges ages;
  const std::int64_t end_us = robot.clock().now_us() + steady_window_us;
  HeadState head;
  while (robot.clock().now_us() < end_us &&
         robot.clock().wait_until(robot.clock().now_us() + steady_look_us) == PortStatus::ok) {
    const auto age_ms = [&](std::int64_t t_us) {
      return 1e-3 * static_cast<double>(robot.clock().now_us() - t_us);
    };
    ages.packet_ms = std::max(ages.packet_ms, age_ms(robot.events().heard_us()));
    if (robot.head() != nullptr && robot.head()->read(head) == PortStatus::ok)
      ages.reading_ms = std::max(ages.reading_ms.value_or(0.0), age_ms(head.t_us));
  }
  return ages;
}

StartUpCheck steady_check(std::string what, const char* thing, double longest_ms, double bound_ms,
                          const char* key) {
  const bool passed = longest_ms <= bound_ms / 2;
  std::string found = fmt::format("{} at most {:.1f} ms old", thing, longest_ms);
  if (!passed) {
    found += fmt::format(
        ", expected {:g} or less, half of deploy.watchdog.{}: sender or this machine are too slow, or set a "
        "longer time there",
        bound_ms / 2, key);
  }
  return {std::move(what), passed, std::move(found)};
}

}  // namespace

std::vector<StartUpCheck> steady_checks(Robot& robot, const WatchdogConfig& watchdog) {
  std::vector<StartUpCheck> checks;
  for (int i = 0; i < steady_windows; ++i) {
    const LongestAges ages = watch_ages(robot);
    checks = {steady_check("packets come steadily", "the newest packet was", ages.packet_ms,
                           watchdog.camera_silent_ms, "camera_silent_ms")};
    if (ages.reading_ms) {
      checks.push_back(steady_check("readings come steadily", "the newest reading was", *ages.reading_ms,
                                    watchdog.joints_stale_ms, "joints_stale_ms"));
    }
    if (std::ranges::all_of(checks, &StartUpCheck::passed)) break;
  }
  return checks;
}

StartUpCheck halts_check(bool is_virtual, const WatchdogConfig& watchdog) {
  const double stops_ms = std::min(watchdog.tick_late_ms, watchdog.hang_ms);
  const double most_ms = longest_halt_ms(watchdog);
  std::string found = fmt::format("one of more than {:g} ms stops the head", stops_ms);
  if (is_virtual && stops_ms < most_ms) {
    found += fmt::format(
        "; the host of a virtual machine halts it now and then: tick_late_ms and hang_ms of deploy.watchdog "
        "may be up to {:g} here, for deploy and guard",
        most_ms);
  }
  return {"halts of this machine", true, std::move(found)};
}

}  // namespace saccade
