#include "emulator/emulator_config.h"

#include <algorithm>

namespace saccade {

const std::vector<std::string>& emulator_presets() {
  static const std::vector<std::string> names = {"ideal",    "dvs128",     "noisy",      "davis346",
                                                 "atis",     "few_events", "asymmetric", "davis240",
                                                 "gen3_vga", "gen4_hd"};
  return names;
}

EmulatorConfig emulator_preset(const std::string& name) {
  EmulatorConfig config;
  config.preset = name;
  if (name == "ideal") {
    config.dark_current = 0.0;
    config.cutoff_hz = 0.0;
    config.cutoff_follows_light = false;
    config.threshold_mismatch = 0.0;
    config.refractory_us = 0;
    config.leak_rate_hz = 0.0;
    config.shot_noise_rate_hz = 0.0;
    config.latency_us = 0;
    config.readout_rate_hz = 0.0;
  } else if (name == "noisy") {
    config.threshold_mismatch = 0.05;
    config.cutoff_hz = 30.0;
    config.shot_noise_rate_hz = 5.0;
    config.hot_pixel_share = 0.001;
  } else if (name == "davis346" || name == "davis240") {
    config.threshold_mismatch = 0.035;
    config.leak_rate_hz = 0.2;
    config.latency_us = 3;
    config.readout_rate_hz = 12e6;
  } else if (name == "atis") {
    config.contrast_threshold_on = config.contrast_threshold_off = 0.13;
    config.threshold_mismatch = 0.03;
    config.latency_us = 4;
    config.readout_rate_hz = 30e6;
  } else if (name == "few_events") {
    config.contrast_threshold_on = config.contrast_threshold_off = 0.35;
    config.threshold_mismatch = 0.04;
    config.cutoff_hz = 300.0;
    config.refractory_us = 1000;
    config.leak_rate_hz = 0.02;
    config.shot_noise_rate_hz = 0.1;
  } else if (name == "asymmetric") {
    config.contrast_threshold_on = 0.14;
    config.contrast_threshold_off = 0.26;
    config.threshold_mismatch = 0.05;
    config.refractory_us = 200;
    config.leak_rate_hz = 0.5;
    config.shot_noise_rate_hz = 2.0;
    config.latency_us = 100;
    config.readout_rate_hz = 30e6;
    config.timestamp_resolution_us = 10;
  } else if (name == "gen3_vga") {
    config.threshold_mismatch = 0.03;
    config.latency_us = 40;
    config.readout_rate_hz = 66e6;
  } else if (name == "gen4_hd") {
    config.threshold_mismatch = 0.03;
    config.latency_us = 20;
    config.readout_rate_hz = 1e9;
  } else if (name != "dvs128") {
    throw InputError("emulator.preset", name, expectation_of(emulator_presets()));
  }
  return config;
}

void describe(FieldVisitor& v, EmulatorConfig& c) {
  const std::string preset = c.preset;
  v.choice("preset", c.preset, emulator_presets(), "sensor whose values are the defaults of the other keys");
  const auto& known = emulator_presets();
  if (c.preset != preset && std::find(known.begin(), known.end(), c.preset) != known.end()) {
    c = emulator_preset(c.preset);
  }
  v.real("white", c.white, {1e-6, 1e9}, "luminance of white in the images");
  v.choice("response", c.response, "conversion of light to log luminance");
  v.real("dark_current", c.dark_current, {0.0, 1e9}, "added to the luminance; 0: none");
  v.choice("interpolation", c.interpolation, "log luminance between two images");
  v.real("cutoff_hz", c.cutoff_hz, {0.0, 1e6}, "bandwidth of the photoreceptor at white; 0: no low-pass");
  v.boolean("cutoff_follows_light", c.cutoff_follows_light,
            "whether the bandwidth is proportional to light and dark current");
  v.real("contrast_threshold_on", c.contrast_threshold_on, {0.01, 5.0}, "rise of ln luminance per event");
  v.real("contrast_threshold_off", c.contrast_threshold_off, {0.01, 5.0}, "fall of ln luminance per event");
  v.real("threshold_mismatch", c.threshold_mismatch, {0.0, 0.5},
         "relative standard deviation of the thresholds over pixels; 0: none");
  v.integer("refractory_us", c.refractory_us, {0, 1e6}, "dead time of a pixel after an event; 0: none");
  v.choice("refractory_mode", c.refractory_mode,
           "pixel held in reset, or its events dropped while its reference follows");
  v.real("leak_rate_hz", c.leak_rate_hz, {0.0, 1000.0}, "ON events of a pixel in constant light; 0: none");
  v.real("leak_spread_decades", c.leak_spread_decades, {0.0, 1.0},
         "standard deviation over pixels of log10 of the leak rate");
  v.real("leak_light_hz", c.leak_light_hz, {0.0, 1000.0},
         "added to the leak rate in proportion to light, at white; 0: none");
  v.real("leak_light_spread_decades", c.leak_light_spread_decades, {0.0, 1.0},
         "standard deviation over pixels of log10 of leak_light_hz");
  v.real("leaky_pixel_share", c.leaky_pixel_share, {0.0, 1.0},
         "share of the pixels whose reference leaks faster; 0: none");
  v.real("leaky_pixel_rate_hz", c.leaky_pixel_rate_hz, {0.0, 1e4},
         "added to the leak rate of a leaky pixel, median");
  v.real("leaky_pixel_spread_decades", c.leaky_pixel_spread_decades, {0.0, 2.0},
         "standard deviation over leaky pixels of log10 of that rate");
  v.real("shot_noise_rate_hz", c.shot_noise_rate_hz, {0.0, 1000.0},
         "events of a pixel in the dark, both polarities; 0: none");
  v.real("shot_noise_spread_decades", c.shot_noise_spread_decades, {0.0, 1.0},
         "standard deviation over pixels of log10 of the shot noise");
  v.real("shot_noise_on_share", c.shot_noise_on_share, {0.0, 1.0}, "share of ON in the shot noise");
  v.real("shot_noise_light", c.shot_noise_light, {0.0, 1e9},
         "light at which the shot noise has fallen to 1/e; 0: it falls linearly to a quarter at white");
  v.real("hot_pixel_share", c.hot_pixel_share, {0.0, 1.0}, "share of the pixels that are hot; 0: none");
  v.real("hot_pixel_rate_hz", c.hot_pixel_rate_hz, {0.0, 1e5}, "rate of ON events of a hot pixel");
  v.integer("latency_us", c.latency_us, {0, 1e6}, "delay from a crossing to its event; 0: none");
  v.real("readout_rate_hz", c.readout_rate_hz, {0.0, 1e9},
         "events per second that the bus transmits; 0: no limit");
  v.integer("readout_queue_events", c.readout_queue_events, {0, 1e9},
            "length of the queue for the bus; events beyond it are dropped; 0: no limit");
  v.integer("timestamp_resolution_us", c.timestamp_resolution_us, {1, 1e6}, "tick of the time stamps");
}

}  // namespace saccade
