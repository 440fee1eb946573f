#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace saccade {

/// Checks files before they are written. Throws InputError for a folder, for a file that is one of `inputs` under any name
/// or link (with `force` too), and, without `force`, for a file that exists.
void check_outputs(std::span<const std::filesystem::path> outputs,
                   std::span<const std::filesystem::path> inputs, bool force);

/// No room on the disk, or in a quota or a limit on the size of files.
class DiskFull : public RunError {
 public:
  using RunError::RunError;
};

/// Writes a whole file, as OutputFile does. Throws RunError.
void write_file(const std::filesystem::path& path, std::string_view text);

/// A file that appears under its name only when it is whole: bytes go to `<path>.part`, commit() flushes, syncs and
/// renames. Without sync() or commit() the destructor removes the `.part` file; after a crash it remains under that name.
/// Every member but the destructor throws RunError with the file's name when writing fails, DiskFull where there is no
/// room.
///
/// Files longer than 64 kB are written by a thread of their own, so that write() does not wait for a disk that pauses: up
/// to 4 MB wait in memory, with more write() waits. A failure of that thread is reported by the next member that is called.
class OutputFile {
 public:
  explicit OutputFile(std::filesystem::path path);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  void write(std::span<const std::byte> bytes);
  void write(std::string_view text);
  /// Replaces bytes that were written before.
  void overwrite(std::int64_t offset, std::span<const std::byte> bytes);
  /// Puts what was written so far on the disk. From then on the `.part` file remains also without commit().
  void sync();
  void commit();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// The file that is written until commit(), for a library that writes a file by its name.
  [[nodiscard]] const std::filesystem::path& part() const { return part_; }

 private:
  class WriterThread;

  void write_buffer();
  void wait_until_written();

  std::filesystem::path path_;
  std::filesystem::path part_;
  int file_ = -1;  ///< descriptor; -1: closed
  std::vector<std::byte> buffer_;
  std::unique_ptr<WriterThread> thread_;  ///< null for a short file
  bool keeps_part_ = false;
};

}  // namespace saccade
