#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "core/config.h"

namespace saccade {

/// Images of a conventional camera in the place of the event camera, as an active pixel sensor beside its events has them: the
/// mean luminance of the exposure, with noise, in 8 bits.
struct FramesConfig {
  std::int64_t exposure_ms = 10;  ///< ends at the instant of the ground truth
  double shot_noise =
      2.0;  ///< standard deviation at luminance 255, grey levels; it grows with the root of luminance
  double read_noise = 1.0;  ///< standard deviation, grey levels
};

/// Keys: exposure_ms, shot_noise, read_noise.
void describe(FieldVisitor& v, FramesConfig& config);

enum class ArrayFormat { hdf5, npz };
constexpr auto words_of(ArrayFormat) {
  return std::to_array<Word<ArrayFormat>>({{ArrayFormat::hdf5, "hdf5"}, {ArrayFormat::npz, "npz"}});
}

/// The ground truth of every pixel that a run writes (docs/ground_truth.md). Nothing is drawn for what is off.
struct GroundTruthConfig {
  double rate_hz = 50.0;  ///< instants per second, whole milliseconds apart
  bool images = false;
  std::optional<FramesConfig> frames;
  bool depth = false;
  bool flow = false;
  bool segmentation = false;
  bool poses = false;
  bool imu = false;
  bool camera = false;
  ArrayFormat format = ArrayFormat::hdf5;

  /// Time between instants, us.
  [[nodiscard]] std::int64_t period_us() const;
};

/// Keys: rate_hz, images, frames, depth, flow, segmentation, poses, imu, camera, format.
void describe(FieldVisitor& v, GroundTruthConfig& config);

}  // namespace saccade
