#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/config.h"

namespace saccade {

/// Conversion of luminance to the logarithm that a pixel responds to.
enum class LightResponse {
  log,      ///< ln(I + dark_current)
  lin_log,  ///< linear below 20/255 of white, logarithmic above
};
constexpr auto words_of(LightResponse) {
  return std::to_array<Word<LightResponse>>(
      {{LightResponse::log, "log"}, {LightResponse::lin_log, "lin_log"}});
}

/// Log luminance between two images.
enum class Interpolation {
  linear,  ///< a straight line in time
  held,    ///< constant until the next image
};
constexpr auto words_of(Interpolation) {
  return std::to_array<Word<Interpolation>>(
      {{Interpolation::linear, "linear"}, {Interpolation::held, "held"}});
}

/// Behaviour of a pixel in its refractory period.
enum class RefractoryMode {
  reset,  ///< the pixel is held in reset: the reference is the level at the end of the period
  drop,   ///< the reference follows the level; events of the period are dropped
};
constexpr auto words_of(RefractoryMode) {
  return std::to_array<Word<RefractoryMode>>(
      {{RefractoryMode::reset, "reset"}, {RefractoryMode::drop, "drop"}});
}

/// The parameters of a dynamic vision sensor's pixels and readout, in the order in which light passes the stages. Each
/// stage has a value that switches it off. docs/emulator.md has the formulas and their sources.
struct EmulatorConfig {
  std::string preset = "dvs128";  ///< sensor whose values are the defaults of the keys below

  // Light to log luminance L. `white` is the unit of what follows.
  double white = 255.0;  ///< luminance of white in the images
  LightResponse response = LightResponse::log;
  double dark_current = 10.0;  ///< added to the luminance, in its unit; 0: none

  // Between two images
  Interpolation interpolation = Interpolation::linear;

  // Photoreceptor: tau dv/dt = L - v, tau = 1 / (2 pi f)
  double cutoff_hz = 3000.0;         ///< f at white; 0: v = L
  bool cutoff_follows_light = true;  ///< f = cutoff_hz (I + dark_current) / (white + dark_current)

  // Comparators
  double contrast_threshold_on = 0.2;   ///< rise of v per ON event
  double contrast_threshold_off = 0.2;  ///< fall of v per OFF event
  double threshold_mismatch = 0.021;    ///< relative standard deviation over pixels, fixed per pixel; 0: none
  std::int64_t refractory_us = 500;     ///< dead time of a pixel after an event; 0: none
  RefractoryMode refractory_mode = RefractoryMode::reset;

  // Noise
  double leak_rate_hz = 0.1;         ///< ON events of a pixel in constant light; 0: none
  double leak_spread_decades = 0.1;  ///< standard deviation over pixels of log10 of the rate
  double leak_light_hz = 0.0;  ///< what light adds to the leak rate, at white; proportional to light; 0: none
  double leak_light_spread_decades = 0.0;   ///< standard deviation over pixels of log10 of leak_light_hz
  double leaky_pixel_share = 0.0;           ///< share of the pixels whose reference leaks faster
  double leaky_pixel_rate_hz = 1.0;         ///< what that adds to their leak rate, median
  double leaky_pixel_spread_decades = 0.5;  ///< standard deviation over leaky pixels of log10 of it
  double shot_noise_rate_hz = 0.4;          ///< events of a pixel in the dark, both polarities; 0: none
  double shot_noise_spread_decades = 0.0;   ///< standard deviation over pixels of log10 of the rate
  double shot_noise_on_share = 0.5;         ///< share of ON in it
  double shot_noise_light =
      0.0;  ///< light at which it has fallen to 1/e; 0: it falls linearly to a quarter at white
  double hot_pixel_share = 0.0;      ///< share of the pixels that are hot
  double hot_pixel_rate_hz = 100.0;  ///< rate of ON events of a hot pixel

  // From the comparator to the time stamp
  std::int64_t latency_us = 15;  ///< delay of every event
  double readout_rate_hz = 1e6;  ///< events per second that the bus transmits; 0: no limit
  std::int64_t readout_queue_events =
      16384;  ///< length of the queue for the bus; events beyond it are dropped; 0: no limit
  std::int64_t timestamp_resolution_us = 1;  ///< tick of the time stamps
};

/// Names of presets: ideal, dvs128, noisy, davis346, atis, few_events, asymmetric, davis240, gen3_vga, gen4_hd.
[[nodiscard]] const std::vector<std::string>& emulator_presets();
/// The configuration of a preset. Throws InputError for an unknown name.
[[nodiscard]] EmulatorConfig emulator_preset(const std::string& name);
/// Keys: the members' names.
void describe(FieldVisitor& v, EmulatorConfig& config);

}  // namespace saccade
