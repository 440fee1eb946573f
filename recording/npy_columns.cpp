#include "recording/npy_columns.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "recording/byte_order.h"
#include "recording/codec.h"
#include "recording/number_text.h"

namespace saccade {
namespace {

constexpr double largest_value = 4611686018427387904.0;  ///< 2^62

template <std::integral T>
T load(const char* bytes, bool big_endian) {
  return big_endian ? load_big<T>(bytes) : load_little<T>(bytes);
}

template <std::integral T>
std::optional<std::int64_t> natural(const char* bytes, bool big_endian) {
  const T value = load<T>(bytes, big_endian);
  if (static_cast<std::uint64_t>(value) > std::uint64_t{1} << 62) return std::nullopt;
  return static_cast<std::int64_t>(value);
}

}  // namespace

NpyHeader read_npy_header(UnpackedPart& part, const InputFile& file, std::size_t& header_bytes) {
  constexpr std::size_t longest_npy_header = 1 << 15;
  constexpr std::size_t start_bytes = 12;
  const std::string_view start = part.peek(start_bytes);
  if (start.size() < start_bytes || !start.starts_with(npy_mark))
    file.fail("a member that is no array", "NumPy's arrays");
  const bool version_1 = start[6] == 1;
  if (!version_1 && start[6] != 2 && start[6] != 3)
    file.fail("an array of version " + std::to_string(start[6]), "version 1, 2 or 3");
  const std::size_t length =
      version_1 ? load_little<std::uint16_t>(start.data() + 8) : load_little<std::uint32_t>(start.data() + 8);
  const std::size_t before = version_1 ? 10 : 12;
  if (length > longest_npy_header)
    file.fail("a header of " + std::to_string(length) + " bytes", "at most 2^15");
  header_bytes = before + length;
  const std::string_view all = part.peek(header_bytes);
  if (all.size() < header_bytes) file.fail("the end of an array inside its header", "a whole array");
  const auto header = NpyHeader::parse(all.substr(before, length));
  if (!header)
    file.fail("the header " + printable(all.substr(before, length)),
              "that of an array of numbers or records");
  part.skip(header_bytes);
  return *header;
}

std::optional<std::size_t> npy_type_bytes(std::string_view type) {
  if (type.size() < 3 || std::string_view("<>|=").find(type[0]) == std::string_view::npos)
    return std::nullopt;
  if (std::string_view("biufVMm").find(type[1]) == std::string_view::npos) return std::nullopt;
  std::size_t bytes = 0;
  constexpr std::size_t most = 1 << 15;
  const std::string_view digits = type.substr(2, type.find('[') - std::min<std::size_t>(2, type.find('[')));
  if (!parse_number(digits, bytes) || bytes == 0 || bytes > most) return std::nullopt;
  return bytes;
}

std::optional<NpyNumber> NpyNumber::parse(std::string_view type) {
  const auto bytes = npy_type_bytes(type);
  if (!bytes || (*bytes != 1 && *bytes != 2 && *bytes != 4 && *bytes != 8)) return std::nullopt;
  NpyNumber number{Kind::natural, *bytes, type[0] == '>', {}};
  if (type[1] == 'i') number.kind = Kind::whole;
  if (type[1] == 'f') number.kind = Kind::real;
  if (type[1] == 'M' || type[1] == 'm') {
    number.kind = Kind::whole;
    const std::string_view ending = type.substr(std::min(type.find('['), type.size()));
    if (ending.size() > 2) number.unit = time_unit_of(ending.substr(1, ending.size() - 2));
    if (!number.unit || *bytes != 8) return std::nullopt;
  }
  if (type[1] == 'V' || (type[1] == 'b' && *bytes != 1)) return std::nullopt;
  if (number.kind == Kind::real && *bytes < 4) return std::nullopt;
  return number;
}

double NpyNumber::real(const char* at) const {
  if (bytes == 4) return static_cast<double>(std::bit_cast<float>(load<std::uint32_t>(at, big_endian)));
  return std::bit_cast<double>(load<std::uint64_t>(at, big_endian));
}

std::optional<std::int64_t> NpyNumber::value(const char* at) const {
  if (kind == Kind::real) {
    const double rounded = std::round(real(at));
    if (!(std::abs(rounded) < largest_value)) return std::nullopt;
    return static_cast<std::int64_t>(rounded);
  }
  if (kind == Kind::natural) {
    if (bytes == 1) return natural<std::uint8_t>(at, big_endian);
    if (bytes == 2) return natural<std::uint16_t>(at, big_endian);
    if (bytes == 4) return natural<std::uint32_t>(at, big_endian);
    return natural<std::uint64_t>(at, big_endian);
  }
  if (bytes == 1) return load<std::int8_t>(at, big_endian);
  if (bytes == 2) return load<std::int16_t>(at, big_endian);
  if (bytes == 4) return load<std::int32_t>(at, big_endian);
  const auto number = load<std::int64_t>(at, big_endian);
  // NumPy's "not a time"
  if (unit && number == std::numeric_limits<std::int64_t>::min()) return std::nullopt;
  return number;
}

std::optional<std::int64_t> NpyNumber::time_us(const char* at, TimeUnit in) const {
  if (kind == Kind::real) return to_us(real(at), in);
  const std::optional<std::int64_t> number = value(at);
  return number && in != TimeUnit::us ? to_us(*number, in) : number;
}

NpyRows::NpyRows(const std::filesystem::path& path, NpyArray array) : array_(std::move(array)), file_(path) {
  try {
    if (!file_.discard(array_.member.place)) file_.fail("the end of the file", "an array");
    part_.begin(array_.member.decompressor(), array_.member.stored_bytes);
    if (!part_.discard(array_.header_bytes)) file_.fail("the end of the file", "an array");
  } catch (const InputError& error) {
    failure_ = error;
  }
}

std::string_view NpyRows::ahead(std::size_t count) {
  const std::size_t most = UnpackedPart::window_bytes / array_.row_bytes;
  const std::size_t wanted = std::min(count, most) * array_.row_bytes;
  std::string_view bytes;
  try {
    bytes = part_.peek(failure_ ? 0 : wanted);
  } catch (const InputError& error) {
    failure_ = error;
    bytes = part_.peek(0);
  }
  bytes = bytes.substr(0, wanted);
  return bytes.substr(0, bytes.size() / array_.row_bytes * array_.row_bytes);
}

void NpyRows::check_end() {
  if (failure_) throw InputError(*failure_);
  if (array_.member.name.empty() || !array_.to_end) return;
  if (!part_.over()) file_.fail("bytes after the rows of " + array_.member.name, "no more than its rows");
  if (part_.crc() != array_.member.crc)
    file_.fail("another checksum of " + array_.member.name, "a sound array");
}

}  // namespace saccade
