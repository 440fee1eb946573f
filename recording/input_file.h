#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace saccade {

/// A recording as bytes, read in large blocks; memory does not depend on the file. Pipes work as well.
class InputFile {
 public:
  /// Throws InputError for a file that is missing, a directory, unreadable or empty.
  explicit InputFile(std::filesystem::path path);

  /// What lies ahead: at least `wanted` bytes unless the file ends sooner, at most the buffer (1 MiB).
  /// Valid until the next call. Throws InputError where the disk gives an error.
  [[nodiscard]] std::string_view peek(std::size_t wanted);
  /// Leaves behind the first `count` of the bytes that peek() showed.
  void skip(std::size_t count);
  /// Leaves behind `count` bytes, or all that there are; whether there were so many.
  [[nodiscard]] bool discard(std::uint64_t count);

  [[nodiscard]] std::uint64_t offset() const { return offset_; }  ///< bytes left behind so far
  [[nodiscard]] std::string name() const { return path_.string(); }

  /// Throws the InputError of what is wrong at the byte ahead.
  [[noreturn]] void fail(std::string value, std::string expectation) const;

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };

  std::filesystem::path path_;
  std::unique_ptr<std::FILE, Close> file_;
  std::unique_ptr<char[]> buffer_;
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::uint64_t offset_ = 0;
};

}  // namespace saccade
