#include "robot/bottle.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstring>
#include <vector>

#include "core/random.h"

namespace saccade {
namespace {

using Bytes = std::vector<std::byte>;

void add(Bytes& bytes, std::int32_t value) {
  const auto raw = std::bit_cast<std::array<std::byte, 4>>(value);
  bytes.insert(bytes.end(), raw.begin(), raw.end());
}

void add(Bytes& bytes, std::string_view text) {
  add(bytes, 4);
  add(bytes, static_cast<std::int32_t>(text.size()));
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
}

/// ("look" 3D (-0.5 0 0.3) 7)
Bytes request() {
  Bytes bytes;
  add(bytes, 256);
  add(bytes, 4);
  add(bytes, "look");
  add(bytes, "3D");
  add(bytes, 256 + 10);
  add(bytes, 3);
  bytes.resize(bytes.size() + 3 * sizeof(double));
  add(bytes, 1);
  add(bytes, 7);
  return bytes;
}

TEST(Bottle, AWholeRequestIsAccepted) {
  EXPECT_EQ(check_bottle(request()), "");
  Bytes empty;
  add(empty, 256);
  add(empty, 0);
  EXPECT_EQ(check_bottle(empty), "");
}

TEST(Bottle, ARequestCutAtAnyByteOrWithBytesAfterItsEndIsRejected) {
  const Bytes whole = request();
  for (std::size_t length = 0; length < whole.size(); ++length)
    EXPECT_NE(check_bottle(std::span(whole).first(length)), "") << length;
  Bytes longer = whole;
  longer.push_back(std::byte{0});
  EXPECT_NE(check_bottle(longer), "");
}

TEST(Bottle, FalseCountsAndLengthsAreRejectedAtOnce) {
  // 48 bytes that claim 2^31 - 1 values.
  for (const std::int32_t type : {0, 1, 2 + 8, 32, 4, 4 + 8}) {
    for (const std::int32_t count : {std::int32_t{0x7fffffff}, std::int32_t{-1}, 100'000'000}) {
      Bytes bytes;
      add(bytes, 256 + type);
      add(bytes, count);
      bytes.resize(48);
      EXPECT_NE(check_bottle(bytes), "") << type << " x " << count;
    }
  }
}

TEST(Bottle, ListsThatAreTooDeepAreRejected) {
  for (const int depth : {4, 8, 9, 1000}) {
    Bytes bytes;
    for (int i = 0; i < depth; ++i) {
      add(bytes, 256);
      add(bytes, i + 1 < depth ? 1 : 0);
    }
    EXPECT_EQ(check_bottle(bytes).empty(), depth <= 8) << depth;
  }
}

TEST(Bottle, RandomBytesAreNeverReadBeyondTheirEnd) {
  const RandomStream random(7, "bottle");
  const Bytes whole = request();
  for (std::uint64_t trial = 0; trial < 20'000; ++trial) {
    Bytes bytes = whole;
    for (std::uint64_t i = 0; i < 4; ++i)
      bytes[random.bits(i, trial) % bytes.size()] = static_cast<std::byte>(random.bits(8 + i, trial));
    bytes.resize(1 + random.bits(16, trial) % bytes.size());
    bytes.shrink_to_fit();  // a sanitizer finds what is read beyond it
    (void)check_bottle(bytes);
  }
}

}  // namespace
}  // namespace saccade
