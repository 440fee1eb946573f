#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/config.h"

namespace saccade {

/// The pixel of a dynamic vision sensor and its readout, stage by stage, in the order light passes them. Each
/// stage has a value that switches it off. docs/emulator.md has the formulas and where they come from.
struct EmulatorConfig {
  std::string preset = "dvs128";  ///< where the values below start from

  // Light to log luminance L. `white` is the unit of what follows.
  double white = 255.0;          ///< luminance of white in the images
  std::string response = "log";  ///< log: L = ln(I + dark_current); lin_log: linear below 20/255 of white
  double dark_current = 10.0;    ///< unit of the luminance; 0: none

  // Between two images
  std::string interpolation = "linear";  ///< L is a straight line in time, or `held` until the next image

  // Photoreceptor: tau dv/dt = L - v, tau = 1 / (2 pi f)
  double cutoff_hz = 3000.0;         ///< f at white; 0: v = L
  bool cutoff_follows_light = true;  ///< f = cutoff_hz (I + dark_current) / (white + dark_current)

  // Comparators
  double contrast_threshold_on = 0.2;   ///< rise of v per ON event
  double contrast_threshold_off = 0.2;  ///< fall of v per OFF event
  double threshold_mismatch = 0.021;    ///< relative standard deviation over pixels, fixed per pixel; 0: none
  std::int64_t refractory_us = 500;     ///< after an event; 0: none
  std::string refractory_mode = "reset";  ///< pixel held in reset; or `drop`: it goes on, its events are lost

  // Noise
  double leak_rate_hz = 0.1;         ///< ON events of a pixel in still light; 0: none
  double leak_spread_decades = 0.1;  ///< standard deviation over pixels of log10 of the rate
  double shot_noise_rate_hz = 0.4;   ///< events of a pixel in the dark, both polarities; 0: none
  double hot_pixel_share = 0.0;      ///< of the pixels that are hot
  double hot_pixel_rate_hz = 100.0;  ///< ON events of a hot pixel

  // From the comparator to the time stamp
  std::int64_t latency_us = 15;               ///< of every event
  double readout_rate_hz = 1e6;               ///< events per second that the bus takes; 0: any number
  std::int64_t readout_queue_events = 16384;  ///< that wait for the bus before some are lost; 0: any number
  std::int64_t timestamp_resolution_us = 1;
};

/// Names that `preset` may take: ideal, dvs128, noisy, davis346, atis.
[[nodiscard]] const std::vector<std::string>& emulator_presets();
/// The configuration of a preset. Throws InputError for an unknown name.
[[nodiscard]] EmulatorConfig emulator_preset(const std::string& name);
/// Keys: the members' names.
void describe(FieldVisitor& v, EmulatorConfig& config);

}  // namespace saccade
