#include "recording/model_file.h"

#include <bit>
#include <cstring>
#include <vector>

#include "core/error.h"
#include "recording/npy_columns.h"
#include "recording/npy_header.h"
#include "recording/unpacked_part.h"
#include "recording/zip_members.h"

namespace saccade {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::uint64_t most_bytes = 1ULL << 30;  // of an array

std::vector<float> read_array(InputFile& file, const ZipMember& member) {
  UnpackedPart part(file);
  part.begin(member.decompressor(), member.stored_bytes);
  const auto refuse = [&](std::string value, std::string expectation) {
    throw InputError(file.name() + ", " + member.name, std::move(value), std::move(expectation));
  };
  std::string bytes;
  if (!read_bytes(part, 8, bytes) || !bytes.starts_with(npy_mark) || (bytes[6] != 1 && bytes[6] != 2))
    refuse("other bytes", "an array in NumPy's format 1 or 2");
  const std::size_t length_bytes = bytes[6] == 1 ? 2 : 4;
  std::string length;
  std::uint32_t header_bytes = 0;
  if (!read_bytes(part, length_bytes, length)) refuse("its end", "a header");
  std::memcpy(&header_bytes, length.data(), length_bytes);
  std::string text;
  if (header_bytes > UnpackedPart::window_bytes || !read_bytes(part, header_bytes, text))
    refuse("a header of " + std::to_string(header_bytes) + " bytes", "a whole header");
  const std::optional<NpyHeader> header = NpyHeader::parse(text);
  if (!header || header->type != "<f4" || header->fortran_order)
    refuse(header ? "numbers of type " + header->type : "another header", "float32 ('<f4') in C order");
  std::uint64_t count = 1;
  for (const std::int64_t size : header->shape) {
    if (size < 1 || static_cast<std::uint64_t>(size) > most_bytes / 4 / count)
      refuse("an array of another size", "at least one number and at most 1 GiB");
    count *= static_cast<std::uint64_t>(size);
  }
  if (!read_bytes(part, 4 * count, bytes)) refuse("its end", std::to_string(count) + " numbers");
  if (!part.over()) refuse("more bytes", std::to_string(count) + " numbers");
  if (part.crc() != member.crc) refuse("a checksum that does not fit its bytes", "an undamaged file");
  std::vector<float> values(count);
  std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

}  // namespace

ModelArrays read_model(const std::filesystem::path& path) {
  InputFile file(path);
  if (!file.peek(zip_mark.size()).starts_with(zip_mark)) file.fail("other bytes", "an NPZ file");
  ModelArrays arrays;
  for_each_zip_member(file, [&](const ZipMember& member) {
    std::string name = member.name;
    if (!name.ends_with(".npy"))
      throw InputError(file.name(), "a member " + name, "members that end in .npy");
    name.resize(name.size() - 4);
    arrays.add(name, read_array(file, member));
  });
  return arrays;
}

}  // namespace saccade
