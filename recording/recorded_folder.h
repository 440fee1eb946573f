#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "recording/event_file.h"
#include "recording/format_registry.h"
#include "recording/recording_summary.h"

namespace saccade {

/// A file of events or a table in the folder of a run, as far as it can be read.
struct RecordedFile {
  std::filesystem::path path;
  bool has_events = false;  ///< false: a table
  int number = 1;           ///< of events_2.aedat4: 2
  bool unfinished = false;  ///< it still has the ending .part: its program was ended, or still writes it
  std::int64_t rows = 0;    ///< events, or lines of the table without the first one
  std::optional<std::int64_t> first_us, last_us;  ///< smallest and largest time of them
  std::optional<TornEnd> torn;
  std::string unreadable;  ///< why nothing can be read; empty: something can
  /// From the last event of the recording with the number before to the first one of this, us; negative: times began anew.
  std::optional<std::int64_t> after_gap_us;

  [[nodiscard]] bool is_whole() const { return !unfinished && !torn && unreadable.empty(); }
};

/// Whether the folder holds recordings that follow each other (events.EXT, events_2.EXT), or unfinished files.
[[nodiscard]] bool has_parts(const FormatRegistry& formats, const std::filesystem::path& folder);

/// A file, or the event files and tables of a folder and of its folder `blackbox`: events by number, then tables by name.
/// Everything is read. `progress`: called with the number of events of a file so far; it may throw. Throws InputError for
/// a folder that cannot be read.
[[nodiscard]] std::vector<RecordedFile> inspect_recorded(
    const FormatRegistry& formats, const std::filesystem::path& path, const EventReadOptions& options,
    const std::function<void(std::int64_t)>& progress = {});

/// Writes the whole part of a file beside it: under its name without .part, or NAME_whole.EXT where such a file exists.
/// The file itself is not changed. Returns the new file. Throws InputError for a file of which nothing can be read, and
/// RunError.
std::filesystem::path write_whole_part(const FormatRegistry& formats, const RecordedFile& file,
                                       const EventReadOptions& options);

}  // namespace saccade
