#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "evaluation/scoring/metrics.h"
#include "recording/file_lock.h"

namespace saccade {

class FormatRegistry;

/// Keeps other runs out of the folder of a run, by a lock on its file `lock`, until its end.
class RunFolderLock {
 public:
  /// Creates a missing folder. Throws InputError where a run is at work in it, RunError where the file cannot be made.
  explicit RunFolderLock(std::filesystem::path folder);
  RunFolderLock(const RunFolderLock&) = delete;
  RunFolderLock& operator=(const RunFolderLock&) = delete;
  ~RunFolderLock();

 private:
  std::filesystem::path file_;
  std::unique_ptr<FileLock> lock_;
};

/// Creates and locks the folder of a run. A folder that is not empty is rejected without `force`; with it, the files of an
/// earlier run are removed (event files of `formats`), nothing else is, and a folder without a run is rejected, and one in
/// which a run is at work. The run holds the result until its last file is written. Throws InputError, RunError.
[[nodiscard]] std::unique_ptr<RunFolderLock> prepare_run_folder(const std::filesystem::path& folder,
                                                                bool force, const FormatRegistry& formats);
/// The same, and writes the run's resolved configuration into the file `name`.
[[nodiscard]] std::unique_ptr<RunFolderLock> start_run_folder(const std::filesystem::path& folder, bool force,
                                                              const FormatRegistry& formats,
                                                              const std::string& name,
                                                              const std::string& text);
/// Throws RunError with the reasons if detectors ended before the end of the run (DetectorScore::failure).
void throw_if_a_program_ended(const Metrics& metrics);
/// Writes the report of a folder with metrics.json, prints the summary and the report's path.
void report_run_folder(const std::filesystem::path& folder, const Metrics& metrics,
                       const FormatRegistry& formats);
/// The same. Throws RunError if the run was interrupted() or a detector ended before its end; the folder is complete then.
void finish_run_folder(const std::filesystem::path& folder, const Metrics& metrics,
                       const FormatRegistry& formats);

}  // namespace saccade
