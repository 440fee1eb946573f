#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "recording/npy_header.h"
#include "recording/unpacked_part.h"
#include "recording/zip_members.h"

namespace saccade::inline v0_1 {

/// A kind of numbers in NumPy's arrays.
struct NpyNumber {
  enum class Kind { whole, natural, real };
  Kind kind = Kind::natural;  ///< with a sign, without one (truth values too), floating-point
  std::size_t bytes = 1;
  bool big_endian = false;

  /// Of "<u2" or "|b1"; none for other types.
  [[nodiscard]] static std::optional<NpyNumber> parse(std::string_view type);
  /// The value of the number at `bytes`. `scale`: factor of a floating-point number, which is rounded then; none where the
  /// result is not within 2^62.
  [[nodiscard]] std::optional<std::int64_t> value(const char* bytes, double scale) const;
};

/// Number of bytes of an element of any type; none for objects and texts.
[[nodiscard]] std::optional<std::size_t> npy_type_bytes(std::string_view type);

/// Which member of an event a column is.
enum class EventColumn { t, x, y, p, camera };
inline constexpr std::size_t event_columns = 5;

/// The column that a field or an array of that name is; none for other names.
[[nodiscard]] std::optional<EventColumn> event_column(std::string_view name);

/// An array, and where its columns lie in its rows.
struct NpyArray {
  ZipMember member;  ///< with an empty name: the whole file
  std::size_t header_bytes = 0;
  std::uint64_t rows = 0;
  std::size_t row_bytes = 0;
  struct Column {
    EventColumn column{};
    NpyNumber number;
    std::size_t offset = 0;  ///< in a row
  };
  std::vector<Column> columns;
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

}  // namespace saccade::inline v0_1
