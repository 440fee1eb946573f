#pragma once

#include <filesystem>

namespace saccade {

/// Locks a file for one process at a time, until its end. Child processes inherit the lock only if they do not call exec.
class FileLock {
 public:
  /// Creates a missing file; does not wait. Throws RunError if the file cannot be opened.
  explicit FileLock(const std::filesystem::path& path);
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;
  ~FileLock();

  [[nodiscard]] bool held() const { return held_; }
  [[nodiscard]] int file() const { return file_; }
  /// Whether the file that is locked still has its name: its last holder may have removed it.
  [[nodiscard]] bool has_its_name() const;

 private:
  std::filesystem::path path_;
  int file_;
  bool held_;
};

/// Whether a process has locked that file.
[[nodiscard]] bool is_locked(const std::filesystem::path& path);

}  // namespace saccade
