#include "robot/number_list.h"

#include <cmath>
#include <cstdint>
#include <cstring>

namespace saccade {
namespace {

// Tags of YARP's binary messages.
constexpr std::int32_t list_tag = 256;
constexpr std::int32_t number_tag_int8 = 32, number_tag_int16 = 64, number_tag_int32 = 1,
                       number_tag_int64 = 1 + 16;
constexpr std::int32_t number_tag_float32 = 128, number_tag_float64 = 2 + 8;

/// Takes values off the front of a message. Little endian, as YARP sends them.
class Bytes {
 public:
  explicit Bytes(std::span<const std::byte> left) : left_(left) {}

  template <class T>
  [[nodiscard]] bool take(T& value) {
    if (left_.size() < sizeof(T)) return false;
    std::memcpy(&value, left_.data(), sizeof(T));
    left_ = left_.subspan(sizeof(T));
    return true;
  }
  template <class T>
  [[nodiscard]] bool take_as(double& value) {
    T raw{};
    if (!take(raw)) return false;
    value = static_cast<double>(raw);
    return true;
  }
  [[nodiscard]] bool number(std::int32_t tag, double& value) {
    switch (tag) {
      case number_tag_int8:
        return take_as<std::int8_t>(value);
      case number_tag_int16:
        return take_as<std::int16_t>(value);
      case number_tag_int32:
        return take_as<std::int32_t>(value);
      case number_tag_int64:
        return take_as<std::int64_t>(value);
      case number_tag_float32:
        return take_as<float>(value);
      case number_tag_float64:
        return take_as<double>(value);
      default:
        return false;
    }
  }
  [[nodiscard]] bool empty() const { return left_.empty(); }

 private:
  std::span<const std::byte> left_;
};

}  // namespace

std::string_view read_number_list(std::span<const std::byte> message, std::span<double> values, int& count) {
  Bytes bytes(message);
  std::int32_t tag = 0;
  std::int32_t length = 0;
  if (!bytes.take(tag) || !bytes.take(length)) return "shorter than its head";
  if ((tag & list_tag) == 0) return "not a list";
  const std::int32_t item_tag = tag & ~list_tag;  // of every number; 0: each has its own
  if (length < 0 || static_cast<std::size_t>(length) > message.size()) return "a wrong count of numbers";
  for (std::int32_t i = 0; i < length; ++i) {
    std::int32_t own_tag = item_tag;
    double value = 0.0;
    if (item_tag == 0 && !bytes.take(own_tag)) return "fewer numbers than it counts";
    if (!bytes.number(own_tag, value)) return "fewer numbers than it counts, or others than numbers";
    if (static_cast<std::size_t>(i) < values.size()) values[static_cast<std::size_t>(i)] = value;
  }
  if (!bytes.empty()) return "bytes after its last number";
  count = length;
  return {};
}

}  // namespace saccade
