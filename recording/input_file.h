#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace saccade {

/// A recording as bytes, read in large blocks; memory does not depend on the file. Pipes work as well.
class InputFile {
 public:
  /// Throws InputError for a file that is missing, a directory, unreadable or empty.
  explicit InputFile(std::filesystem::path path);

  /// The bytes ahead: at least `wanted` bytes unless the file ends sooner, at most the buffer (1 MiB).
  /// Valid until the next call. Throws InputError for a read error.
  [[nodiscard]] std::string_view peek(std::size_t wanted);
  /// Goes on after the first `count` of the bytes that peek() returned.
  void skip(std::size_t count);
  /// Goes on after `count` bytes, or to the end; false where there were fewer.
  [[nodiscard]] bool discard(std::uint64_t count);

  [[nodiscard]] std::uint64_t offset() const { return offset_; }  ///< of the first byte ahead
  [[nodiscard]] std::string name() const { return path_.string(); }

  /// Throws an InputError with the byte ahead as its place.
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
  std::optional<std::uint64_t> size_;  ///< none: not seekable
};

/// Goes on after `count` bytes of a file or a part of one, by reading them; false where there were fewer.
template <class Source>
[[nodiscard]] bool skip_bytes(Source& source, std::uint64_t count) {
  while (count > 0) {
    const std::size_t ahead = source.peek(1).substr(0, count).size();
    if (ahead == 0) return false;
    source.skip(ahead);
    count -= ahead;
  }
  return true;
}

}  // namespace saccade
