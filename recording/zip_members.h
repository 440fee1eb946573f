#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "recording/decompressor.h"
#include "recording/input_file.h"

namespace saccade {

inline constexpr std::string_view zip_mark = "PK\x03\x04";  ///< of the first member

/// A file in a ZIP file.
struct ZipMember {
  std::string name;
  std::uint64_t place = 0;  ///< of its stored bytes in the ZIP file
  std::uint64_t stored_bytes = 0;
  std::uint32_t crc = 0;  ///< of the unpacked bytes
  bool deflated = false;

  [[nodiscard]] std::unique_ptr<Decompressor> decompressor() const {
    return deflated ? make_deflate_decompressor() : make_copier();
  }
};

/// Reads a ZIP file from its beginning and calls `use` for each member, with the file at its stored bytes; `use` reads all
/// of them. Throws InputError where the file ends before its directory does, and for members that are encrypted, compressed
/// by another method than deflate, or whose size follows their bytes.
void for_each_zip_member(InputFile& file, const std::function<void(const ZipMember&)>& use);

}  // namespace saccade
