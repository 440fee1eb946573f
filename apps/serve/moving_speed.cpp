#include "apps/serve/moving_speed.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "apps/serve/image_pace.h"
#include "core/units.h"
#include "sim/sim_robot.h"

namespace saccade {
namespace {

constexpr double budget_s = 0.5;
constexpr int least_keyframes = 2;
constexpr double bearable_keyframe_ms = 6.0;  // beside a client up to three times that
constexpr std::int64_t fewest_samples = 2;
constexpr double needed_speed = 1.5;  // the client, and the ports, need processors too
constexpr double swing_rad = 10.0 * rad_per_deg, swing_hz = 1.6;

double seconds_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// The joint that turns the eyes: version, or the last one of another head.
int turning_slot(const HeadModel& head) {
  return head.is_icub ? static_cast<int>(eyes_version) : torso_slots + head.gaze_joints() - 1;
}

}  // namespace

MovingSpeed measure_speed(const MeasuredTick& tick, const std::function<double()>& now_s, double limit_s,
                          int keyframes) {
  MovingSpeed speed;
  std::vector<double> keyframe_s;
  const double begin_s = now_s();
  for (double last_s = begin_s; speed.wall_s < limit_s || (static_cast<int>(keyframe_s.size()) < keyframes &&
                                                           speed.wall_s < 4.0 * limit_s);) {
    const bool drew = tick();
    const double end_s = now_s();
    if (drew) keyframe_s.push_back(end_s - last_s);
    speed.simulated_s += 1e-6 * static_cast<double>(World::tick_us);
    speed.wall_s = end_s - begin_s;
    last_s = end_s;
  }
  if (keyframe_s.empty()) return speed;
  const auto middle = keyframe_s.begin() + static_cast<std::ptrdiff_t>(keyframe_s.size() / 2);
  std::nth_element(keyframe_s.begin(), middle, keyframe_s.end());
  speed.keyframe_ms = 1e3 * *middle;
  return speed;
}

std::int64_t bearable_samples(std::int64_t samples, double keyframe_ms) {
  if (keyframe_ms <= bearable_keyframe_ms) return samples;
  // The drawing's share that grows with the square of the samples is small: 2 to 5 took 2.5, 4.4, 6.3 and 8.6 ms.
  const double bearable = static_cast<double>(samples) * bearable_keyframe_ms / keyframe_ms;
  return std::min(samples, std::max(fewest_samples, static_cast<std::int64_t>(bearable)));
}

MovingSpeed moving_speed(const SimConfig& config, std::uint64_t seed, std::size_t threads,
                         std::int64_t held_us) {
  SimRobot robot(config, seed, threads);
  robot.hold_back_images(held_us);
  const JointLimits limits = robot.limits();
  HeadState state;
  robot.read(state);
  const HeadCommand rest_rad = state.head_position_rad();
  const int turning = turning_slot(*limits.head) - torso_slots;
  std::vector<Event> events;
  const auto keyframes = [&] {
    const KeyframeRenderer* const renderer = robot.left_eye().keyframes();
    return renderer == nullptr ? 0 : renderer->counts().room;
  };
  const MeasuredTick tick = [&] {
    const std::int64_t before = keyframes();
    const double t_s = 1e-6 * static_cast<double>(robot.now_us());
    HeadCommand reference_rad = rest_rad;
    reference_rad[turning] += swing_rad * std::sin(2.0 * std::numbers::pi * swing_hz * t_s);
    robot.command(reference_rad.cwiseMax(limits.min_rad.tail<gaze_slots>())
                      .cwiseMin(limits.max_rad.tail<gaze_slots>()));
    robot.wait_until(robot.now_us() + World::tick_us);
    events.clear();
    robot.read_until(robot.now_us(), events);
    return keyframes() > before;
  };
  return measure_speed(tick, seconds_now, budget_s, least_keyframes);
}

bool fits_usual(const MovingSpeed& usual) {
  return usual.simulated_per_s() >= needed_speed && usual.keyframe_ms <= bearable_keyframe_ms;
}

ServedWork served_work(const MovingSpeed& usual, const MovingSpeed& lowered,
                       std::int64_t configured_samples) {
  ServedWork work{usual, lowered, bearable_samples(configured_samples, usual.keyframe_ms), {}};
  work.lines.push_back(
      fmt::format("with moving eyes this machine simulates {:.2f} s per s{}", usual.simulated_per_s(),
                  usual.keyframe_ms > 0.0 ? fmt::format(", a keyframe takes {:.0f} ms", usual.keyframe_ms)
                                          : std::string()));
  if (work.keyframe_samples < configured_samples) {
    work.lines.push_back(
        fmt::format("keyframes have {} samples per pixel and direction instead of {} "
                    "(render.keyframe_samples), since no packet comes while one is drawn",
                    work.keyframe_samples, configured_samples));
  }
  if (fits_usual(usual)) return work;
  const double longest_ms = 1e-3 * static_cast<double>(ImagePace::longest_us);
  if (usual.simulated_per_s() < needed_speed) {
    work.lines.push_back(
        fmt::format("images are up to {:g} ms apart while the simulation lags behind", longest_ms));
  }
  const double speed = lowered.simulated_per_s();
  if (lowered.wall_s <= 0.0 || speed >= needed_speed) return work;
  const std::string hints =
      "set lab.clutter=bare, a smaller camera (camera.width_px and height_px, and those of the robot file), "
      "or let the "
      "client run on another machine";
  work.lines.push_back(
      speed < 1.0
          ? fmt::format("warning: this machine is too slow for real time: with images {:g} ms apart a "
                        "simulated second with moving eyes takes {:.1f} s, and simulated time slips; {}",
                        longest_ms, 1.0 / speed, hints)
          : fmt::format(
                "warning: this machine is hardly fast enough for real time: with images {:g} ms apart it "
                "simulates moving eyes at {:.2f} s per s, of which the client takes a part; {}",
                longest_ms, speed, hints));
  return work;
}

}  // namespace saccade
