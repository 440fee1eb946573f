#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace saccade {

/// What lies in a sweep's folder:
///
///     sweep.sqlite            the table: SweepStore
///     report.html, figures/   what `saccade report` draws
///     worst/ID/               run folders of the worst runs
///     runs/ID/scenario.yaml   what a run is
///     runs/ID/metrics.json    its result, when it is done,
///     runs/ID/failure.txt     or why there is none
///     runs/ID/log.txt         what it said; locked while it goes on
///     lock                    locked while `saccade sweep` is at work
///     batches.txt             the engine's list
///
/// The files in runs/ are all there is to a sweep; the table is made from them.
class SweepFolder {
 public:
  explicit SweepFolder(std::filesystem::path path) : path_(std::move(path)) {}

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path table() const { return path_ / "sweep.sqlite"; }
  [[nodiscard]] std::filesystem::path run(const std::string& id) const { return path_ / "runs" / id; }
  [[nodiscard]] std::filesystem::path worst(const std::string& id) const { return path_ / "worst" / id; }

  /// Whether a run needs to be made no more.
  [[nodiscard]] bool has_result(const std::string& id) const;
  /// When it came to an end, by the file's time.
  [[nodiscard]] std::optional<std::filesystem::file_time_type> finished(const std::string& id) const;
  /// Whether some process makes it at the moment.
  [[nodiscard]] bool is_running(const std::string& id) const;

 private:
  std::filesystem::path path_;
};

/// A file that one process at a time holds; the hold ends with the process. Other processes do not inherit it, but for
/// forks that execute nothing.
class FileLock {
 public:
  /// Makes the file where it is missing; does not wait. Throws RunError when it cannot be opened.
  explicit FileLock(const std::filesystem::path& path);
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  ~FileLock();

  [[nodiscard]] bool held() const { return held_; }
  [[nodiscard]] int file() const { return file_; }

 private:
  int file_;
  bool held_;
};

/// Whether a process holds the lock of that file.
[[nodiscard]] bool is_locked(const std::filesystem::path& path);

}  // namespace saccade
