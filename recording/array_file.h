#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace saccade {

enum class ArrayType { u8, i64, f32, f64 };

/// Bytes of a number.
[[nodiscard]] constexpr std::size_t size_of(ArrayType type) {
  switch (type) {
    case ArrayType::u8:
      return 1;
    case ArrayType::f32:
      return 4;
    case ArrayType::i64:
    case ArrayType::f64:
      break;
  }
  return 8;
}

/// A file of named arrays: HDF5, or NumPy's .npz without compression, so that its arrays can be mapped into memory. Like all
/// outputs it appears under its name only when it is whole. Every member throws RunError where writing fails.
class ArrayFile {
 public:
  virtual ~ArrayFile() = default;

  /// A new array that grows by rows of this shape (empty: numbers); returns its number. A name may have groups: left/depth_m.
  virtual std::size_t add(const std::string& name, ArrayType type,
                          const std::vector<std::size_t>& row_shape) = 0;
  /// One row or several, in the computer's byte order.
  virtual void append(std::size_t array, std::span<const std::byte> rows) = 0;
  template <class T>
  void append(std::size_t array,
              std::span<const T> values) requires(!std::is_same_v<std::remove_const_t<T>, std::byte>) {
    append(array, std::as_bytes(values));
  }
  /// Texts, as an array of bytes of the longest one's length.
  virtual void put(const std::string& name, const std::vector<std::string>& texts) = 0;
  virtual void commit() = 0;
};

namespace detail {

inline std::size_t row_bytes(ArrayType type, const std::vector<std::size_t>& shape) {
  std::size_t bytes = size_of(type);
  for (const std::size_t length : shape) bytes *= length;
  return bytes;
}

inline std::size_t longest(const std::vector<std::string>& texts) {
  std::size_t length = 1;
  for (const std::string& text : texts) length = std::max(length, text.size());
  return length;
}

/// The texts one after the other, filled up with zeros.
inline std::string padded(const std::vector<std::string>& texts) {
  std::string bytes;
  for (const std::string& text : texts) bytes += text + std::string(longest(texts) - text.size(), '\0');
  return bytes;
}

}  // namespace detail

/// By the extension .h5 or .npz.
[[nodiscard]] std::unique_ptr<ArrayFile> create_array_file(const std::filesystem::path& path);

}  // namespace saccade
