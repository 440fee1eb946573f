#include "recording/npy_columns.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "recording/byte_order.h"
#include "recording/number_text.h"

namespace saccade::inline v0_1 {
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

std::optional<std::size_t> npy_type_bytes(std::string_view type) {
  if (type.size() < 3 || std::string_view("<>|=").find(type[0]) == std::string_view::npos)
    return std::nullopt;
  if (std::string_view("biufV").find(type[1]) == std::string_view::npos) return std::nullopt;
  std::size_t bytes = 0;
  constexpr std::size_t most = 1 << 15;
  if (!parse_number(type.substr(2), bytes) || bytes == 0 || bytes > most) return std::nullopt;
  return bytes;
}

std::optional<NpyNumber> NpyNumber::parse(std::string_view type) {
  const auto bytes = npy_type_bytes(type);
  if (!bytes || (*bytes != 1 && *bytes != 2 && *bytes != 4 && *bytes != 8)) return std::nullopt;
  NpyNumber number{Kind::natural, *bytes, type[0] == '>'};
  if (type[1] == 'i') number.kind = Kind::whole;
  if (type[1] == 'f') number.kind = Kind::real;
  if (type[1] == 'V' || (type[1] == 'b' && *bytes != 1)) return std::nullopt;
  if (number.kind == Kind::real && *bytes < 4) return std::nullopt;
  return number;
}

std::optional<std::int64_t> NpyNumber::value(const char* at, double scale) const {
  if (kind == Kind::real) {
    const double real = bytes == 4
                            ? static_cast<double>(std::bit_cast<float>(load<std::uint32_t>(at, big_endian)))
                            : std::bit_cast<double>(load<std::uint64_t>(at, big_endian));
    const double scaled = std::round(scale * real);
    if (!(std::abs(scaled) < largest_value)) return std::nullopt;
    return static_cast<std::int64_t>(scaled);
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
  return load<std::int64_t>(at, big_endian);
}

std::optional<EventColumn> event_column(std::string_view name) {
  using enum EventColumn;
  constexpr std::array<std::pair<std::string_view, EventColumn>, 12> names = {{{"t", t},
                                                                               {"ts", t},
                                                                               {"timestamp", t},
                                                                               {"timestamps", t},
                                                                               {"time", t},
                                                                               {"x", x},
                                                                               {"y", y},
                                                                               {"p", p},
                                                                               {"pol", p},
                                                                               {"polarity", p},
                                                                               {"polarities", p},
                                                                               {"camera", camera}}};
  for (const auto& [known, column] : names) {
    if (name == known) return column;
  }
  return std::nullopt;
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
  if (array_.member.name.empty()) return;
  if (!part_.over()) file_.fail("bytes after the rows of " + array_.member.name, "no more than its rows");
  if (part_.crc() != array_.member.crc)
    file_.fail("another checksum of " + array_.member.name, "a sound array");
}

}  // namespace saccade::inline v0_1
