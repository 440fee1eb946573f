#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "recording/decompressor.h"
#include "recording/input_file.h"

namespace saccade {

/// A part of a file, such as a chunk of a bag, as unpacked bytes; memory does not grow with it. Has the reading members of
/// InputFile.
class UnpackedPart {
 public:
  static constexpr std::size_t window_bytes = 1 << 16;

  /// `file` must outlive this object.
  explicit UnpackedPart(InputFile& file) : file_(file), window_(window_bytes) {}

  /// The part is the next `stored_bytes` bytes of the file.
  void begin(std::unique_ptr<Decompressor> decompressor, std::uint64_t stored_bytes);
  /// Whether all bytes of the part have been read.
  [[nodiscard]] bool over() { return peek(1).empty(); }
  /// The bytes ahead: at least `wanted` (at most window_bytes) unless the part ends sooner. Valid until the next call.
  /// Throws InputError where the file ends inside the part or the part cannot be unpacked.
  [[nodiscard]] std::string_view peek(std::size_t wanted);
  void skip(std::size_t count);
  /// Goes on after `count` bytes, or to the end; false where there were fewer.
  [[nodiscard]] bool discard(std::uint64_t count);
  /// Goes to the end of the part in the file without unpacking it; false where the file ends sooner.
  [[nodiscard]] bool discard_rest();
  /// CRC-32 of the unpacked bytes that have been skipped since begin().
  [[nodiscard]] std::uint32_t crc() const { return crc_; }
  [[noreturn]] void fail(std::string value, std::string expectation) const;

 private:
  void unpack();

  InputFile& file_;
  std::unique_ptr<Decompressor> decompressor_;
  std::uint64_t stored_left_ = 0;
  std::vector<char> window_;  ///< unpacked bytes, those in [begin_, end_) not read yet
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::uint32_t crc_ = 0;
};

/// Reads `count` bytes of a file or a part into `bytes`; false where it ends sooner. `bytes` grows as they arrive.
template <class Source>
[[nodiscard]] bool read_bytes(Source& source, std::uint64_t count, std::string& bytes) {
  bytes.clear();
  while (count > 0) {
    const std::string_view ahead = source.peek(1).substr(0, count);
    if (ahead.empty()) return false;
    bytes += ahead;
    count -= ahead.size();
    source.skip(ahead.size());
  }
  return true;
}

}  // namespace saccade
