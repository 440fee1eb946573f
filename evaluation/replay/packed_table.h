#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace saccade {

/// Bytes as a page holds them: compressed (zlib), in base64.
[[nodiscard]] std::string packed(std::span<const unsigned char> bytes);

/// A table as a page holds it: columns one after the other, packed(). page/tables.js reads it.
///
/// | kind | a column's bytes |
/// |---|---|
/// | time | whole numbers that do not go back: the first one and then each difference, as varints (LEB128) |
/// | number | whole multiples of a step: the difference from the last one as a zigzag varint plus 1; 0 for none |
/// | byte, word | one byte each; the lower bytes of all, then the higher ones |
/// | bit | eight each, the lowest first |
class PackedTable {
 public:
  PackedTable(std::string name, std::size_t rows) : name_(std::move(name)), rows_(rows) {}

  /// Each column has as many values as the table has rows; `times` do not go back and start at 0 or later.
  void add_times(std::string_view name, std::span<const std::int64_t> times);
  /// `step` > 0: values are rounded to its multiples; NaN stands for none.
  void add_numbers(std::string_view name, double step, std::span<const double> values);
  /// `wide`: words, else all are below 256.
  void add_words(std::string_view name, bool wide, std::span<const std::uint16_t> values);
  void add_bits(std::string_view name, const std::vector<bool>& values);

  /// Name, rows and columns, for the page's script.
  [[nodiscard]] nlohmann::ordered_json description() const;
  [[nodiscard]] std::string content() const { return packed(bytes_); }
  /// The columns as they are, for a page that gets them as bytes.
  [[nodiscard]] std::span<const unsigned char> bytes() const { return bytes_; }

 private:
  struct Column {
    std::string name;
    std::string kind;
    double step;
  };

  void add_column(std::string_view name, std::string kind, std::size_t count, double step = 1.0);
  void add_varint(std::uint64_t value);

  std::string name_;
  std::size_t rows_;
  std::vector<Column> columns_;
  std::vector<unsigned char> bytes_;
};

}  // namespace saccade
