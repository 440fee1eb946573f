#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "recording/event_file.h"
#include "recording/event_statistics.h"

namespace saccade {

/// The content of a recording: format, image size and the statistics of its events.
struct RecordingSummary {
  std::string file;
  std::string format;
  std::string skipped;  ///< records that are no events of a camera ("12 skin events"); often empty
  std::optional<ImageSize> image;
  EventCounter counter;

  [[nodiscard]] bool two_cameras() const {
    return counter.camera(0).count > 0 && counter.camera(1).count > 0;
  }
};

/// Reads a recording to its end. A gap is counted when it is longer than `gap_us`. `progress`: called with the number of
/// events so far; it may throw. Throws InputError.
[[nodiscard]] RecordingSummary summarise_recording(const FormatRegistry& formats,
                                                   const std::filesystem::path& recording,
                                                   const EventReadOptions& options, std::int64_t gap_us,
                                                   const std::function<void(std::int64_t)>& progress = {});

}  // namespace saccade
