#include "robot/number_list.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstring>
#include <vector>

#include "core/random.h"

namespace saccade {
namespace {

/// A message, made by appending values as they go over the wire.
class Message {
 public:
  template <class T>
  Message& add(T value) {
    const auto bytes = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
    bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
    return *this;
  }
  Message& add(std::int32_t value) { return add<std::int32_t>(value); }
  operator std::span<const std::byte>() const { return bytes_; }  // NOLINT

 private:
  std::vector<std::byte> bytes_;
};

TEST(NumberList, ReadsAVectorAndABottleOfNumbersOfAnyKind) {
  std::array<double, 4> values{};
  int count = 0;
  const Message vector = Message().add(256 + 10).add(2).add(1.5).add(-2.5);
  EXPECT_EQ(read_number_list(vector, values, count), "");
  EXPECT_EQ(count, 2);
  EXPECT_EQ(values[1], -2.5);
  const Message bottle = Message().add(256).add(3).add(1).add(7).add(10).add(0.25).add(128).add<float>(0.5F);
  EXPECT_EQ(read_number_list(bottle, values, count), "");
  EXPECT_EQ(count, 3);
  EXPECT_EQ(values, (std::array<double, 4>{7.0, 0.25, 0.5, 0.0}));
}

TEST(NumberList, FalseCountsAreNotBelieved) {
  std::array<double, 4> values{};
  int count = 0;
  for (const std::int32_t claimed : {3, 1'000'000, 2'000'000'000, -1}) {
    const Message message = Message().add(256 + 10).add(claimed).add(1.5).add(-2.5);
    EXPECT_NE(read_number_list(message, values, count), "") << claimed;
  }
  EXPECT_NE(read_number_list(Message().add(256 + 10).add(1).add(1.5).add(2.5), values, count), "");
  EXPECT_NE(read_number_list(Message().add(256).add(1).add(4).add(3), values, count), "") << "a string";
  EXPECT_NE(read_number_list(Message().add(256), values, count), "");
  EXPECT_NE(read_number_list({}, values, count), "");
}

TEST(NumberList, MoreNumbersThanFitAreCountedAndDiscarded) {
  std::array<double, 2> values{};
  int count = 0;
  EXPECT_EQ(read_number_list(Message().add(256 + 1).add(3).add(1).add(2).add(3), values, count), "");
  EXPECT_EQ(count, 3);
  EXPECT_EQ(values, (std::array<double, 2>{1.0, 2.0}));
}

TEST(NumberList, RandomBytesNeverReadBeyondTheMessage) {
  const RandomStream random(7, "number list");
  std::array<double, 12> values{};
  for (std::uint64_t trial = 0; trial < 20'000; ++trial) {
    std::vector<std::byte> bytes(random.bits(0, trial) % 64);
    for (std::size_t i = 0; i < bytes.size(); ++i)
      bytes[i] = static_cast<std::byte>(random.bits(1 + i, trial) % (i % 4 == 1 ? 2 : 16));
    int count = 0;
    if (read_number_list(bytes, values, count).empty()) {
      EXPECT_LE(count, 64);
    }
  }
}

}  // namespace
}  // namespace saccade
