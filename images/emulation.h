#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "emulator/emulator_config.h"
#include "emulator/event_emulator.h"
#include "emulator/event_label.h"
#include "images/image_sequence.h"
#include "recording/format_registry.h"

namespace saccade {

/// Images in, a recording out.
struct EmulationConfig {
  std::filesystem::path images;        ///< folder, video or .npy file
  std::filesystem::path out;           ///< recording to write
  std::filesystem::path labels;        ///< table t_us,x,y,p,cause with a row per event; empty: none
  std::filesystem::path timestamps;    ///< times of the images (read_image_times); empty: images_per_s
  std::optional<TimeUnit> time_unit;   ///< of these times; none: their file's
  std::optional<double> images_per_s;  ///< [1e-3, 1e6]; none: a video's own times
  EmulatorConfig emulator;
  std::int64_t seed = 1;
  int threads = 2;  ///< the result does not depend on it
};

struct EmulationResult {
  ImageSequenceInfo info;
  std::int64_t images = 0;
  std::int64_t first_us = 0;  ///< of the first image
  std::int64_t last_us = 0;
  float least_luminance = 0.0F;
  float largest_luminance = 0.0F;
  EmulatorCounts counts;
};

/// What speaks for images in 0..1 where the camera expects others, and the keys for them; empty: nothing does. `largest`: of the
/// luminance of linear images.
[[nodiscard]] std::string luminance_warning(const EmulatorConfig& camera, float largest);

/// Called after each image with the number of images so far and the expected number, 0 where that is unknown. It may throw
/// to end the emulation; then nothing is written.
using EmulationProgress = std::function<void(std::int64_t images, std::int64_t expected)>;

/// Runs the event camera over a sequence of images. Output files appear when they are whole. Throws InputError for images
/// or times that cannot be used, and for fewer than two images.
EmulationResult emulate_images(const EmulationConfig& config, const FormatRegistry& formats,
                               const EmulationProgress& progress = {});

}  // namespace saccade
