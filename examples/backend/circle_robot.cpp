#include "circle_robot.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace example {

void describe(saccade::FieldVisitor& v, CircleRobotConfig& config) {
  v.real("radius_px", config.radius_px, {2.0, 200.0}, "radius of the disc");
  v.real("turns_per_s", config.turns_per_s, {0.0, 10.0}, "of the disc around the centre of the image");
  v.integer("events_per_ms", config.events_per_ms, {1, 1000}, "events on the outline of the disc");
}

CircleRobot::CircleRobot(const CircleRobotConfig& config, const saccade::RobotContext& context)
    : config_(saccade::check_config("circle", config)), size_(context.image_size), limits_(context.limits) {}

saccade::PortStatus CircleRobot::wait_until(std::int64_t t_us) {
  now_us_ = std::max(now_us_, t_us);
  return saccade::PortStatus::ok;
}

saccade::Event CircleRobot::event_at(std::int64_t number) const {
  constexpr double turn_rad = 2.0 * std::numbers::pi;
  constexpr double golden_turns = 0.618033988749895;  // spreads successive events over the outline
  const std::int64_t t_us = number * 1000 / config_.events_per_ms;
  const double path_rad = turn_rad * config_.turns_per_s * static_cast<double>(t_us) * 1e-6;
  const double outline_rad = turn_rad * std::fmod(golden_turns * static_cast<double>(number), 1.0);
  const double path_px = 0.2 * std::min(size_.width, size_.height);
  const double x_px =
      0.5 * size_.width + path_px * std::cos(path_rad) + config_.radius_px * std::cos(outline_rad);
  const double y_px =
      0.5 * size_.height + path_px * std::sin(path_rad) + config_.radius_px * std::sin(outline_rad);
  const bool on = std::sin(outline_rad - path_rad) > 0.0;  // the side towards which the disc moves
  return {t_us, static_cast<std::uint16_t>(std::clamp<long>(std::lround(x_px), 0, size_.width - 1)),
          static_cast<std::uint16_t>(std::clamp<long>(std::lround(y_px), 0, size_.height - 1)), on, 0};
}

saccade::PortStatus CircleRobot::read_until(std::int64_t t_us, std::vector<saccade::Event>& events) {
  for (saccade::Event event = event_at(next_event_); event.t_us <= t_us; event = event_at(++next_event_))
    events.push_back(event);
  return saccade::PortStatus::ok;
}

saccade::PortStatus CircleRobot::read(saccade::HeadState& state) {
  state.t_us = now_us_;
  state.position_rad = position_rad_;
  state.velocity_rad_s.setZero();
  return saccade::PortStatus::ok;
}

saccade::HeadPort::CommandResult CircleRobot::command(const saccade::HeadCommand& reference_rad) {
  if (!saccade::is_allowed(reference_rad, limits_)) return {saccade::PortStatus::ok, true};
  position_rad_.tail<saccade::gaze_slots>() = reference_rad;
  return {};
}

}  // namespace example
