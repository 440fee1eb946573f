#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace saccade::detail {

/// An array's header in a .npy file, `bytes` bytes long. `descr`: the type as NumPy writes it, `shape` without parentheses.
[[nodiscard]] std::string npy_header(const std::string& descr, const std::string& shape, std::size_t bytes);

/// Continues the CRC-32 of ZIP files.
[[nodiscard]] std::uint32_t crc_of(std::string_view bytes, std::uint32_t crc = 0);

/// A member of a ZIP file as its headers describe it.
struct ZipEntry {
  std::string name;
  bool deflated = false;
  std::uint32_t crc = 0;
  std::uint64_t stored = 0, unpacked = 0, place = 0;

  /// Its header in front of it. The sizes are in 64 bits, whatever they are.
  [[nodiscard]] std::string local_header() const;
  /// Its entry in the directory at the end.
  [[nodiscard]] std::string directory_entry() const;

 private:
  void append_common(std::string& bytes) const;
};

/// What follows the directory of a ZIP file.
[[nodiscard]] std::string zip_end(std::uint64_t entries, std::uint64_t directory,
                                  std::uint64_t directory_bytes);

}  // namespace saccade::detail
