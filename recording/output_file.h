#pragma once

#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <span>
#include <string_view>

#include "core/error.h"

namespace saccade {

/// The disk, a quota or a limit on files' size leaves no room.
class DiskFull : public RunError {
 public:
  using RunError::RunError;
};

/// A file that appears under its name only when it is whole: bytes go to `<path>.part`, commit() flushes,
/// syncs and renames. Without commit() the `.part` file is removed by the destructor (and left behind,
/// under that name, by a crash).
/// Every member but the destructor throws RunError naming the file when the disk does not take the bytes, DiskFull
/// where there is no room for them.
class OutputFile {
 public:
  explicit OutputFile(std::filesystem::path path);
  OutputFile(const OutputFile&) = delete;
  OutputFile& operator=(const OutputFile&) = delete;
  ~OutputFile();

  void write(std::span<const std::byte> bytes);
  void write(std::string_view text);
  /// Bytes in place of ones that were written before.
  void overwrite(std::int64_t offset, std::span<const std::byte> bytes);
  void commit();

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  /// Where the bytes are until then, for a library that writes a file by its name.
  [[nodiscard]] const std::filesystem::path& part() const { return part_; }

 private:
  std::filesystem::path path_;
  std::filesystem::path part_;
  std::FILE* file_ = nullptr;
};

}  // namespace saccade
