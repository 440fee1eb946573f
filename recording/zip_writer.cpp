#include "recording/zip_writer.h"

#include <zlib.h>

#include "core/error.h"
#include "recording/byte_order.h"
#include "recording/npy_header.h"

namespace saccade::detail {

std::string npy_header(const std::string& descr, const std::string& shape, std::size_t bytes) {
  constexpr std::size_t before = 10;
  std::string text = "{'descr': " + descr + ", 'fortran_order': False, 'shape': (" + shape + "), }";
  SACCADE_CHECK(before + text.size() < bytes);
  text.resize(bytes - before - 1, ' ');
  std::string header = std::string(npy_mark) + std::string{'\1', '\0'};
  append_little(header, static_cast<std::uint16_t>(text.size() + 1));
  return header + text + "\n";
}

std::uint32_t crc_of(std::string_view bytes, std::uint32_t crc) {
  return static_cast<std::uint32_t>(
      crc32(crc, reinterpret_cast<const Bytef*>(bytes.data()), static_cast<uInt>(bytes.size())));
}

std::string ZipEntry::local_header() const {
  std::string bytes = "PK\x03\x04";
  append_common(bytes);
  append_little(bytes, std::uint16_t{20});
  bytes += name;
  append_little(bytes, std::uint16_t{1});
  append_little(bytes, std::uint16_t{16});
  append_little(bytes, unpacked);
  append_little(bytes, stored);
  return bytes;
}

std::string ZipEntry::directory_entry() const {
  std::string bytes = "PK\x01\x02";
  append_little(bytes, std::uint16_t{45});
  append_common(bytes);
  append_little(bytes, std::uint16_t{28});
  bytes += std::string(10, '\0');  // comment, disk, attributes
  append_little(bytes, std::uint32_t{0xffffffff});
  bytes += name;
  append_little(bytes, std::uint16_t{1});
  append_little(bytes, std::uint16_t{24});
  append_little(bytes, unpacked);
  append_little(bytes, stored);
  append_little(bytes, place);
  return bytes;
}

void ZipEntry::append_common(std::string& bytes) const {
  append_little(bytes, std::uint16_t{45});  // version needed
  append_little(bytes, std::uint16_t{0});   // flags
  append_little(bytes, static_cast<std::uint16_t>(deflated ? 8 : 0));
  append_little(bytes, std::uint16_t{0});   // time
  append_little(bytes, std::uint16_t{33});  // 1980-01-01
  append_little(bytes, crc);
  append_little(bytes, std::uint32_t{0xffffffff});  // in the extra bytes
  append_little(bytes, std::uint32_t{0xffffffff});
  append_little(bytes, static_cast<std::uint16_t>(name.size()));
}

std::string zip_end(std::uint64_t entries, std::uint64_t directory, std::uint64_t directory_bytes) {
  std::string end = "PK\x06\x06";
  append_little(end, std::uint64_t{44});
  append_little(end, std::uint16_t{45});
  append_little(end, std::uint16_t{45});
  append_little(end, std::uint64_t{0});  // disks
  append_little(end, entries);
  append_little(end, entries);
  append_little(end, directory_bytes);
  append_little(end, directory);
  end += "PK\x06\x07";
  append_little(end, std::uint32_t{0});
  append_little(end, directory + directory_bytes);
  append_little(end, std::uint32_t{1});
  end += "PK\x05\x06";
  append_little(end, std::uint32_t{0});
  append_little(end, static_cast<std::uint16_t>(entries));
  append_little(end, static_cast<std::uint16_t>(entries));
  append_little(end, std::uint32_t{0xffffffff});
  append_little(end, std::uint32_t{0xffffffff});
  append_little(end, std::uint16_t{0});
  return end;
}

}  // namespace saccade::detail
