#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

namespace saccade {

/// Whole requests of robots have at most this many bytes, which is checked before a message is read.
inline constexpr std::size_t longest_bottle = std::size_t{1} << 16;

/// Checks that `message` is one whole Bottle of YARP in binary: a list of numbers, texts, blobs and lists. The counts and
/// lengths in it are only believed as far as its bytes go, so that who reads a checked message needs memory in proportion
/// to its bytes. Returns what is wrong, empty if nothing.
[[nodiscard]] std::string_view check_bottle(std::span<const std::byte> message);

/// The binary form of a Bottle: 32-bit little-endian integers, each value preceded by a code of its type. Source: the
/// codes are those of YARP's own messages (BottleImpl.h).
namespace bottle {

inline constexpr std::int32_t tag_int32 = 1;
inline constexpr std::int32_t tag_string = 4;
inline constexpr std::int32_t tag_list = 256;  ///< plus the code of all its values, where they have the same

/// What is left of a message. The first read beyond its end, and everything after it, fails.
class Reader {
 public:
  explicit Reader(std::span<const std::byte> bytes) : left_(bytes) {}

  [[nodiscard]] bool integer(std::int32_t& value);
  [[nodiscard]] bool block(std::size_t size, std::span<const std::byte>& bytes);
  /// A block behind its length.
  [[nodiscard]] bool sized_block(std::span<const std::byte>& bytes);
  [[nodiscard]] bool is(std::int32_t expected);
  /// Passes over a value of the type `code`.
  [[nodiscard]] bool skip(std::int32_t code, int depth = 0);
  [[nodiscard]] std::size_t size() const { return left_.size(); }

 private:
  [[nodiscard]] bool skip_list(std::int32_t element, int depth);

  std::span<const std::byte> left_;
};

}  // namespace bottle
}  // namespace saccade
