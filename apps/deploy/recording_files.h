#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "recording/event_file.h"
#include "recording/format_registry.h"
#include "recording/run_files.h"

namespace saccade {

/// When a recording goes on in a new file, and when it ends.
struct RecordingFilesConfig {
  std::string format = "aedat4";      ///< of FormatRegistry
  std::int64_t rotate_bytes = 0;      ///< size of the event file from which on the next one follows
  std::int64_t rotate_us = 0;         ///< duration of a file
  std::int64_t least_free_bytes = 0;  ///< with less room on the disk the recording ends
  std::shared_ptr<const HeadModel> head = default_head();  ///< whose joints the tables have
};

/// Room on the disk of a folder; the largest number where the file system does not say.
[[nodiscard]] std::int64_t free_bytes(const std::filesystem::path& folder);

/// The events and joints of `deploy --record`, in pairs of files that follow each other: `events.EXT` and `joints.csv`,
/// then `events_2.EXT` and `joints_2.csv` and so on. Files that are there are not touched: numbers go on after the largest
/// one in the folder. Each pair is a recording of its own, whole as soon as it has its final name: then it is synced to the
/// disk. The pair that is written has the ending `.part`; every second what came so far is put on the disk in whole records, so
/// that a power cut loses the last second (not in NumPy's format, which cannot be read before it is finished). `saccade
/// repair` makes a recording of such a pair. Where a file cannot be written, as on a full disk, the recording ends and the
/// pair keeps the ending `.part`.
class RecordingFiles {
 public:
  /// Throws RunError for a disk without room, InputError for the format.
  RecordingFiles(std::filesystem::path folder, const FormatRegistry& formats, ImageSize image,
                 const RecordingFilesConfig& config);

  /// At time t_us, which does not decrease: events that came, and a reading of the joints. Throws InputError for an event
  /// that the format cannot hold.
  void write(std::int64_t t_us, std::span<const Event> events, const std::optional<JointsRow>& joints);
  /// Closes the newest pair.
  void commit();

  /// Name of the first event file.
  [[nodiscard]] const std::string& first_file() const { return first_file_; }
  /// Pairs of files so far.
  [[nodiscard]] int count() const { return count_; }
  /// Why the recording ended before the run; empty if it did not.
  [[nodiscard]] const std::string& ended() const { return ended_; }

 private:
  void open(std::int64_t t_us);
  void check(std::int64_t t_us);
  [[nodiscard]] std::filesystem::path path(const char* name, const std::string& ending) const;

  std::filesystem::path folder_;
  FormatRegistry formats_;
  ImageSize image_;
  RecordingFilesConfig config_;
  int number_;
  int count_ = 0;
  std::string first_file_;
  std::unique_ptr<EventWriter> events_;
  std::optional<TableWriter<JointsRow>> joints_;
  std::int64_t opened_us_ = 0;
  std::int64_t checked_us_ = 0;
  std::string ended_;
};

}  // namespace saccade
