#include "evaluation/replay/packed_table.h"

#include <zlib.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/error.h"
#include "evaluation/report/html.h"

namespace saccade {
namespace {

constexpr double largest = 9.0e15;  // whole numbers that a double holds exactly

std::vector<unsigned char> compressed(std::span<const unsigned char> bytes, int strategy) {
  constexpr int level = 6;
  constexpr int window_bits = 15;
  constexpr int memory = 9;
  z_stream stream{};
  SACCADE_CHECK(deflateInit2(&stream, level, Z_DEFLATED, window_bits, memory, strategy) == Z_OK);
  std::vector<unsigned char> out(deflateBound(&stream, bytes.size()));
  stream.next_in = const_cast<unsigned char*>(bytes.data());  // zlib does not write there
  stream.avail_in = static_cast<uInt>(bytes.size());
  stream.next_out = out.data();
  stream.avail_out = static_cast<uInt>(out.size());
  SACCADE_CHECK(deflate(&stream, Z_FINISH) == Z_STREAM_END);
  out.resize(stream.total_out);
  deflateEnd(&stream);
  return out;
}

}  // namespace

std::string packed(std::span<const unsigned char> bytes) {
  // Addresses and times of events repeat nothing: matches that zlib finds there cost more than they save.
  const std::vector<unsigned char> matched = compressed(bytes, Z_DEFAULT_STRATEGY);
  const std::vector<unsigned char> huffman = compressed(bytes, Z_HUFFMAN_ONLY);
  return base64(huffman.size() < matched.size() ? huffman : matched);
}

void PackedTable::add_column(std::string_view name, std::string kind, std::size_t count, double step) {
  SACCADE_CHECK(count == rows_);
  columns_.push_back({std::string(name), std::move(kind), step});
}

void PackedTable::add_varint(std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) bytes_.push_back(static_cast<unsigned char>(value | 0x80));
  bytes_.push_back(static_cast<unsigned char>(value));
}

void PackedTable::add_times(std::string_view name, std::span<const std::int64_t> times) {
  add_column(name, "time", times.size());
  std::int64_t last = 0;
  for (const std::int64_t time : times) {
    SACCADE_CHECK(time >= last);
    add_varint(static_cast<std::uint64_t>(time - last));
    last = time;
  }
}

void PackedTable::add_numbers(std::string_view name, double step, std::span<const double> values) {
  add_column(name, "number", values.size(), step);
  std::int64_t last = 0;
  for (const double value : values) {
    const double multiple = std::round(value / step);
    if (!(std::abs(multiple) < largest)) {
      add_varint(0);
      continue;
    }
    const std::int64_t difference = static_cast<std::int64_t>(multiple) - last;
    last += difference;
    const auto zigzag =
        static_cast<std::uint64_t>(difference) << 1 ^ static_cast<std::uint64_t>(difference >> 63);
    add_varint(zigzag + 1);
  }
}

void PackedTable::add_words(std::string_view name, bool wide, std::span<const std::uint16_t> values) {
  add_column(name, wide ? "word" : "byte", values.size());
  for (const std::uint16_t value : values) bytes_.push_back(static_cast<unsigned char>(value & 0xff));
  if (!wide) return;
  for (const std::uint16_t value : values) bytes_.push_back(static_cast<unsigned char>(value >> 8));
}

void PackedTable::add_bits(std::string_view name, const std::vector<bool>& values) {
  add_column(name, "bit", values.size());
  for (std::size_t i = 0; i < values.size(); i += 8) {
    unsigned byte = 0;
    for (std::size_t k = 0; k < 8 && i + k < values.size(); ++k) byte |= values[i + k] ? 1U << k : 0U;
    bytes_.push_back(static_cast<unsigned char>(byte));
  }
}

nlohmann::ordered_json PackedTable::description() const {
  nlohmann::ordered_json columns = nlohmann::ordered_json::array();
  for (const Column& column : columns_) {
    nlohmann::ordered_json entry = {{"name", column.name}, {"kind", column.kind}};
    if (column.kind == "number") entry["step"] = column.step;
    columns.push_back(std::move(entry));
  }
  return {{"name", name_}, {"rows", rows_}, {"columns", std::move(columns)}};
}

}  // namespace saccade
