#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "core/error.h"
#include "recording/event_file.h"
#include "recording/event_statistics.h"

namespace saccade {

/// Where a file stops being readable: it was cut off by a power cut or a full disk, or is broken there.
struct TornEnd {
  std::uint64_t byte = 0;   ///< of the first record that is not whole; events of it that can be read are read
  std::uint64_t bytes = 0;  ///< from there to the end of the file
  std::string cause;        ///< what was found, and what was expected
  bool is_cut = true;       ///< false: the record is whole and wrong
};

/// The content of a recording: format, image size and the statistics of its events.
struct RecordingSummary {
  std::string file;
  std::string format;
  std::string skipped;  ///< records that are no events of a camera ("12 skin events"); often empty
  std::optional<ImageSize> image;
  EventCounter counter;
  std::optional<TornEnd> torn = std::nullopt;  ///< none: the recording was read to its end

  [[nodiscard]] bool two_cameras() const {
    return counter.camera(0).count > 0 && counter.camera(1).count > 0;
  }
};

/// Where a reader of this recording threw `error`.
[[nodiscard]] TornEnd torn_end(const EventReader& reader, const std::filesystem::path& recording,
                               const InputError& error);

/// Reads a recording to its end. A gap is counted when it is longer than `gap_us`. `progress`: called with the number of
/// events so far; it may throw. A recording that breaks off is summarised up to there. Throws InputError where it cannot be
/// opened.
[[nodiscard]] RecordingSummary summarise_recording(const FormatRegistry& formats,
                                                   const std::filesystem::path& recording,
                                                   const EventReadOptions& options, std::int64_t gap_us,
                                                   const std::function<void(std::int64_t)>& progress = {});

}  // namespace saccade
