#include "recording/zip_members.h"

#include <string_view>

#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/unpacked_part.h"

namespace saccade {
namespace {

// Marks and sizes as in PKWARE's APPNOTE.
constexpr std::uint32_t local_header = 0x04034b50;
constexpr std::uint32_t directory_entry = 0x02014b50;
constexpr std::uint32_t directory_end = 0x06054b50;
constexpr std::uint32_t directory_end_64 = 0x06064b50;
constexpr std::uint32_t locator_64 = 0x07064b50;
constexpr std::size_t local_header_bytes = 30;
constexpr std::size_t directory_entry_bytes = 46;
constexpr std::size_t directory_end_bytes = 22;
constexpr std::size_t directory_end_64_bytes = 12;  ///< before the bytes that it counts
constexpr std::size_t locator_64_bytes = 20;
constexpr std::uint16_t extra_64 = 1;
constexpr std::uint32_t in_extra = 0xffffffff;

std::string_view head_of(InputFile& file, std::size_t bytes) {
  const std::string_view head = file.peek(bytes);
  if (head.size() < bytes) file.fail("the end of the file", "the rest of a ZIP file");
  return head.substr(0, bytes);
}

void skip_record(InputFile& file, std::uint64_t bytes) {
  if (!file.discard(bytes)) file.fail("the end of the file", "the rest of a ZIP file");
}

/// The stored size in the 64-bit block of a local header's extra bytes; none where there is no such block.
std::optional<std::uint64_t> stored_bytes_64(std::string_view extra) {
  while (extra.size() >= 4) {
    const auto id = load_little<std::uint16_t>(extra.data());
    const auto length = load_little<std::uint16_t>(extra.data() + 2);
    extra.remove_prefix(4);
    if (extra.size() < length) return std::nullopt;
    if (id == extra_64 && length >= 16) return load_little<std::uint64_t>(extra.data() + 8);
    extra.remove_prefix(length);
  }
  return std::nullopt;
}

ZipMember read_local_header(InputFile& file) {
  const std::string_view head = head_of(file, local_header_bytes);
  const auto flags = load_little<std::uint16_t>(head.data() + 6);
  const auto method = load_little<std::uint16_t>(head.data() + 8);
  ZipMember member;
  member.crc = load_little<std::uint32_t>(head.data() + 14);
  member.stored_bytes = load_little<std::uint32_t>(head.data() + 18);
  const auto name_bytes = load_little<std::uint16_t>(head.data() + 26);
  const auto extra_bytes = load_little<std::uint16_t>(head.data() + 28);
  if ((flags & 1) != 0) file.fail("an encrypted member", "one that is not encrypted");
  if ((flags & 8) != 0)
    file.fail("a member whose size follows it",
              "sizes in front, as numpy.savez and zip write them into a file");
  if (method != 0 && method != 8)
    file.fail("a member compressed by ZIP's method " + std::to_string(method), "deflate or none");
  member.deflated = method == 8;
  file.skip(local_header_bytes);
  std::string text;
  if (!read_bytes(file, name_bytes, member.name) || !read_bytes(file, extra_bytes, text))
    file.fail("the end of the file", "the rest of a ZIP file");
  if (member.stored_bytes == in_extra) {
    const auto stored = stored_bytes_64(text);
    if (!stored) file.fail("a member without its size of 64 bits", "a size");
    member.stored_bytes = *stored;
  }
  member.place = file.offset();
  return member;
}

}  // namespace

void for_each_zip_member(InputFile& file, const std::function<void(const ZipMember&)>& use) {
  while (true) {
    const auto mark = load_little<std::uint32_t>(head_of(file, 4).data());
    if (mark == local_header) {
      use(read_local_header(file));
    } else if (mark == directory_entry) {
      const std::string_view head = head_of(file, directory_entry_bytes);
      std::uint64_t bytes = directory_entry_bytes;
      for (const std::size_t place : {28, 30, 32}) bytes += load_little<std::uint16_t>(head.data() + place);
      skip_record(file, bytes);
    } else if (mark == directory_end_64) {
      const auto more = load_little<std::uint64_t>(head_of(file, directory_end_64_bytes).data() + 4);
      if (more > std::uint64_t{1} << 32) file.fail("a directory's end of 2^32 bytes or more", "a ZIP file");
      skip_record(file, directory_end_64_bytes + more);
    } else if (mark == locator_64) {
      skip_record(file, locator_64_bytes);
    } else if (mark == directory_end) {
      const std::string_view head = head_of(file, directory_end_bytes);
      skip_record(file, directory_end_bytes + load_little<std::uint16_t>(head.data() + 20));
      return;
    } else {
      file.fail("bytes that belong to no member and no directory", "a ZIP file");
    }
  }
}

}  // namespace saccade
