#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "recording/event_columns.h"
#include "recording/npy_header.h"
#include "recording/unpacked_part.h"
#include "recording/zip_members.h"

namespace saccade {

/// A kind of numbers in NumPy's arrays.
struct NpyNumber {
  enum class Kind { whole, natural, real };
  Kind kind = Kind::natural;  ///< with a sign, without one (truth values too), floating-point
  std::size_t bytes = 1;
  bool big_endian = false;
  std::optional<TimeUnit> unit;  ///< of NumPy's datetime64 and timedelta64

  /// Of "<u2", "|b1" or "<M8[ns]"; none for other types.
  [[nodiscard]] static std::optional<NpyNumber> parse(std::string_view type);
  /// The number at `bytes`, rounded; none where it is not within 2^62.
  [[nodiscard]] std::optional<std::int64_t> value(const char* bytes) const;
  /// The number at `bytes` as a time.
  [[nodiscard]] std::optional<std::int64_t> time_us(const char* bytes, TimeUnit unit) const;
  /// A floating-point number at `bytes`.
  [[nodiscard]] double real(const char* bytes) const;
};

/// Reads a member's header; the part is at its first row afterwards. Throws InputError for a member that is no array.
[[nodiscard]] NpyHeader read_npy_header(UnpackedPart& part, const InputFile& file, std::size_t& header_bytes);

/// Number of bytes of an element of any type; none for objects and texts.
[[nodiscard]] std::optional<std::size_t> npy_type_bytes(std::string_view type);

/// An array, and where its columns lie in its rows.
struct NpyArray {
  ZipMember member;  ///< with an empty name: the whole file
  std::size_t header_bytes = 0;
  std::uint64_t rows = 0;
  std::size_t row_bytes = 0;
  struct Column {
    EventColumn column{};
    NpyNumber number;
    std::size_t offset = 0;        ///< in a row
    std::optional<TimeUnit> unit;  ///< of a time, where the file says it

    /// Whole numbers without a unit are us, floating-point ones s.
    [[nodiscard]] TimeUnit unit_or_default() const {
      return unit.value_or(number.kind == NpyNumber::Kind::real ? TimeUnit::s : TimeUnit::us);
    }
  };
  std::vector<Column> columns;
  bool to_end =
      true;  ///< the rows reach to the end of the member; false: other columns follow, as in Fortran order
};

/// The rows of an array, in pieces, through a file of its own.
class NpyRows {
 public:
  NpyRows(const std::filesystem::path& path, NpyArray array);

  [[nodiscard]] const NpyArray& array() const { return array_; }
  /// Up to `count` whole rows ahead, fewer where the array or the file ends; valid until the next call.
  [[nodiscard]] std::string_view ahead(std::size_t count);
  void skip(std::size_t count) { part_.skip(count * array_.row_bytes); }
  /// Throws why ahead() returned fewer rows than the array has; compares the checksum where all have been read.
  void check_end();

 private:
  NpyArray array_;
  InputFile file_;
  UnpackedPart part_{file_};
  std::optional<InputError> failure_;
};

}  // namespace saccade
