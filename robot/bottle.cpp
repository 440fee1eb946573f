#include "robot/bottle.h"

#include <bit>
#include <cstring>

namespace saccade {
namespace bottle {

static_assert(std::endian::native == std::endian::little, "the wire is little-endian");

namespace {

constexpr std::int32_t tag_vocab = 1 + 8, tag_float32 = 128;
constexpr std::int32_t tag_int8 = 32, tag_int16 = 64, tag_int64 = 1 + 16, tag_float64 = 2 + 8;
constexpr std::int32_t tag_blob = 4 + 8;
constexpr int deepest_list = 8;

}  // namespace

bool Reader::integer(std::int32_t& value) {
  std::span<const std::byte> bytes;
  if (!block(sizeof(value), bytes)) return false;
  std::memcpy(&value, bytes.data(), sizeof(value));
  return true;
}

bool Reader::block(std::size_t size, std::span<const std::byte>& bytes) {
  if (left_.size() < size) return false;
  bytes = left_.first(size);
  left_ = left_.subspan(size);
  return true;
}

bool Reader::sized_block(std::span<const std::byte>& bytes) {
  std::int32_t size = 0;
  return integer(size) && size >= 0 && block(static_cast<std::size_t>(size), bytes);
}

bool Reader::is(std::int32_t expected) {
  std::int32_t value = 0;
  return integer(value) && value == expected;
}

bool Reader::skip(std::int32_t code, int depth) {
  std::span<const std::byte> bytes;
  if ((code & tag_list) != 0) return depth < deepest_list && skip_list(code & ~tag_list, depth);
  switch (code) {
    case tag_int32:
    case tag_vocab:
    case tag_float32:
      return block(4, bytes);
    case tag_int8:
      return block(1, bytes);
    case tag_int16:
      return block(2, bytes);
    case tag_int64:
    case tag_float64:
      return block(8, bytes);
    case tag_string:
    case tag_blob:
      return sized_block(bytes);
    default:
      return false;
  }
}

bool Reader::skip_list(std::int32_t element, int depth) {
  std::int32_t count = 0;
  if (!integer(count) || count < 0) return false;
  for (std::int32_t i = 0; i < count; ++i) {
    std::int32_t code = element;
    if (element == 0 && !integer(code)) return false;
    if (!skip(code, depth + 1)) return false;
  }
  return true;
}

}  // namespace bottle

std::string_view check_bottle(std::span<const std::byte> message) {
  bottle::Reader reader(message);
  std::int32_t code = 0;
  if (!reader.integer(code) || (code & bottle::tag_list) == 0) return "not a list";
  if (!reader.skip(code))
    return "counts or lengths beyond its end, lists too deep, or values of unknown types";
  return reader.size() == 0 ? std::string_view() : "something comes after the end";
}

}  // namespace saccade
