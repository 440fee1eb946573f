#pragma once

#include <cstddef>
#include <memory>
#include <span>
#include <string_view>

namespace saccade {

/// Unpacks compressed frames piece by piece, in memory that does not grow with them (what a frame may ask for
/// is at most 128 MiB).
class Decompressor {
 public:
  /// What one call read and wrote; `error`: why it failed, null where it did not.
  struct Step {
    std::size_t read = 0;
    std::size_t written = 0;
    const char* error = nullptr;
  };

  virtual ~Decompressor() = default;
  /// Forgets all; the next byte begins a frame.
  virtual void begin() = 0;
  /// Takes from `in` and writes to `out` as much as it can. A frame that follows another is unpacked too.
  virtual Step run(std::string_view in, std::span<char> out) = 0;
  /// Whether a frame has begun that needs more bytes, or holds back some for want of room.
  [[nodiscard]] virtual bool unfinished() const = 0;
};

[[nodiscard]] std::unique_ptr<Decompressor> make_copier();  ///< for what is not compressed
[[nodiscard]] std::unique_ptr<Decompressor> make_bzip2_decompressor();
/// zlib: deflate without a header, as in ZIP files.
[[nodiscard]] std::unique_ptr<Decompressor> make_deflate_decompressor();
[[nodiscard]] std::unique_ptr<Decompressor> make_lz4_decompressor();
[[nodiscard]] std::unique_ptr<Decompressor> make_zstd_decompressor();

}  // namespace saccade
