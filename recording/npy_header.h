#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace saccade {

inline constexpr std::string_view npy_mark = "\x93NUMPY";

/// The header of an array in NumPy's format (numpy.org/doc/stable/reference/generated/numpy.lib.format.html): after the mark
/// two bytes of version, the length in 2 bytes (version 1) or 4, and a Python dictionary.
struct NpyHeader {
  struct Field {
    std::string name;   ///< empty: bytes between fields
    std::string title;  ///< NumPy's second name of a field; mostly empty
    std::string type;   ///< "<u2"
  };
  std::string type;  ///< "<f4"; empty where the elements are records
  std::vector<Field>
      fields;  ///< of a record, in their order without gaps; empty where the elements are numbers
  bool fortran_order = false;
  std::vector<std::int64_t> shape;

  /// None where the text is no such dictionary, and for records within records.
  [[nodiscard]] static std::optional<NpyHeader> parse(std::string_view text);
};

}  // namespace saccade
