#include "sim/ground_truth_config.h"

#include <cmath>

namespace saccade {

std::int64_t GroundTruthConfig::period_us() const { return 1000 * std::llround(1000.0 / rate_hz); }

void describe(FieldVisitor& v, FramesConfig& config) {
  v.integer("exposure_ms", config.exposure_ms, {1, 100},
            "exposure, which ends at the instant of the ground truth");
  v.real("shot_noise", config.shot_noise, {0.0, 100.0},
         "standard deviation of a white pixel, grey levels; it grows with the root of luminance");
  v.real("read_noise", config.read_noise, {0.0, 100.0}, "standard deviation of a black pixel, grey levels");
}

void describe(FieldVisitor& v, GroundTruthConfig& config) {
  v.real("rate_hz", config.rate_hz, {0.1, 1000.0},
         "instants per second; a whole number of milliseconds apart");
  const double period_ms = 1000.0 / config.rate_hz;
  v.require(std::abs(period_ms - std::round(period_ms)) < 1e-6, "rate_hz", text_of(config.rate_hz),
            "1000 divided by a whole number");
  v.boolean("images", config.images, "luminance of each pixel, drawn at the instant");
  v.optional_section("frames", config.frames,
                     "8-bit images of a conventional camera with exposure and noise");
  if (config.frames)
    v.require(static_cast<double>(config.frames->exposure_ms) <= period_ms + 1e-6, "frames.exposure_ms",
              std::to_string(config.frames->exposure_ms),
              "at most the time between instants, " + text_of(period_ms) + " ms");
  v.boolean("depth", config.depth, "distance along the optical axis of what each pixel shows");
  v.boolean("flow", config.flow, "motion of what each pixel shows in the image, and the camera's part of it");
  v.boolean("segmentation", config.segmentation, "number of the object in each pixel, with a table of names");
  v.boolean("poses", config.poses, "poses of cameras and bodies, the target's position and the joints");
  v.boolean("imu", config.imu, "readings of the inertial measurement unit (`imu`), every millisecond");
  v.boolean("camera", config.camera, "camera matrix and lens");
  v.choice("format", config.format, "ground_truth.h5 or ground_truth.npz");
}

}  // namespace saccade
