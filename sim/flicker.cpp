#include "sim/flicker.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace saccade {

void describe(FieldVisitor& v, FlickerConfig& c) {
  v.choice("kind", c.kind, "mains: a sine at twice the mains frequency; pwm: on and off");
  v.real("frequency_hz", c.frequency_hz, {1.0, 2000.0},
         "frequency of the mains (50 or 60), or of the pulses");
  v.real("depth", c.depth, {0.0, 1.0}, "the light varies between 1 - depth and 1");
  v.when(c.kind == FlickerKind::pwm, "kind: pwm", [&] {
    v.real("duty", c.duty, {0.01, 0.99}, "share of the period with the light on");
    v.real("edge_ms", c.edge_ms, {0.02, 5.0}, "time from off to on, and from on to off");
    const double period_ms = 1e3 / c.frequency_hz;
    v.require(c.edge_ms <= std::min(c.duty, 1.0 - c.duty) * period_ms, "edge_ms", text_of(c.edge_ms),
              "at most the time that the light is on, and that it is off");
  });
  v.real("phase_deg", c.phase_deg, {-360.0, 360.0}, "phase at the start");
}

Flicker::Flicker(const FlickerConfig& config)
    : config_(check_config("lab.flicker", config)),
      period_us_((config.kind == FlickerKind::mains ? 0.5e6 : 1e6) / config.frequency_hz),
      edge_share_(1e3 * config.edge_ms / period_us_) {}

double Flicker::periods(std::int64_t t_us) const {
  return static_cast<double>(t_us) / period_us_ + config_.phase_deg / 360.0;
}

double Flicker::factor(std::int64_t t_us) const {
  const double phase = periods(t_us) - std::floor(periods(t_us));
  double on = 0.0;
  if (config_.kind == FlickerKind::mains) {
    on = 0.5 + 0.5 * std::sin(2.0 * std::numbers::pi * phase);
  } else {
    on = phase < config_.duty ? std::min(1.0, phase / edge_share_)
                              : std::max(0.0, 1.0 - (phase - config_.duty) / edge_share_);
  }
  return 1.0 - config_.depth * (1.0 - on);
}

std::int64_t Flicker::next_image_us(std::int64_t t_us) const {
  const auto instant = [&](double at) {  // in periods; rounded up
    return std::max(t_us + 1,
                    static_cast<std::int64_t>(std::ceil((at - config_.phase_deg / 360.0) * period_us_)));
  };
  constexpr double tiny = 1e-9;
  if (config_.kind == FlickerKind::mains) {
    constexpr double per_period = 24.0;
    return instant((std::floor(periods(t_us) * per_period + tiny) + 1.0) / per_period);
  }
  const double begin = std::floor(periods(t_us));
  const std::array<double, 5> ends = {0.0, edge_share_, config_.duty, config_.duty + edge_share_, 1.0};
  for (const double end : ends) {
    // An instant that is rounded up lies up to 1 us after the end that it stands for.
    if (begin + end > periods(t_us) + tiny) return instant(begin + end);
  }
  return instant(begin + 1.0 + edge_share_);
}

}  // namespace saccade
