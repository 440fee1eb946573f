#pragma once

#include <cstdint>

#include "core/config.h"

namespace saccade {

/// How the light of lamps varies with time.
enum class FlickerKind {
  mains,  ///< as a sine at twice the mains frequency
  pwm,    ///< on and off
};
constexpr auto words_of(FlickerKind) {
  return std::to_array<Word<FlickerKind>>({{FlickerKind::mains, "mains"}, {FlickerKind::pwm, "pwm"}});
}

struct FlickerConfig {
  FlickerKind kind = FlickerKind::mains;
  double frequency_hz = 50.0;  ///< of the mains, or of the pulses
  double depth = 0.2;          ///< the light varies between 1 - depth and 1
  double duty = 0.5;           ///< pwm: share of the period with the light on
  double edge_ms = 0.1;        ///< pwm: time from off to on, and from on to off
  double phase_deg = 0.0;
};

/// Keys: kind, frequency_hz, depth, duty, edge_ms, phase_deg.
void describe(FieldVisitor& v, FlickerConfig& config);

/// The light as a function of time. All lamps flicker together.
class Flicker {
 public:
  explicit Flicker(const FlickerConfig& config);

  /// Factor of every luminance, [1 - depth, 1].
  [[nodiscard]] double factor(std::int64_t t_us) const;
  /// The next instant after t_us at which an image is needed so that straight lines between images follow the light: 24
  /// per period of a sine, the ends of the edges of pulses.
  [[nodiscard]] std::int64_t next_image_us(std::int64_t t_us) const;

 private:
  /// Periods since the light was last at phase 0 before time 0; the part after the point is the phase.
  [[nodiscard]] double periods(std::int64_t t_us) const;

  FlickerConfig config_;
  double period_us_;
  double edge_share_;  ///< of the period
};

}  // namespace saccade
