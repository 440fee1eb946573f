#pragma once

#include <cstdint>
#include <filesystem>

namespace saccade {

class FormatRegistry;

/// What write_foxglove() wrote.
struct FoxgloveSummary {
  std::int64_t messages = 0;
  std::int64_t events = 0;       ///< in the images
  std::int64_t late_events = 0;  ///< that came too late for their image, and are in none
};

inline constexpr double foxglove_images_hz = 30.0;

/// Writes an MCAP file of a run folder for Foxglove (docs/replay.md): JSON messages of Foxglove's schemas and plain ones, by
/// the time of the run. What the folder does not have is left out. `images_hz`: images of the events, in (0, 1000]; their times
/// are whole ms. `formats`: of the event file.
/// Throws InputError for a folder without a readable metrics.json or without events, or with a broken file, RunError where
/// the file cannot be written.
FoxgloveSummary write_foxglove(const std::filesystem::path& run_folder, const FormatRegistry& formats,
                               double images_hz, const std::filesystem::path& file);

}  // namespace saccade
