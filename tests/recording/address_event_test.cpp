#include "recording/address_event.h"

#include <gtest/gtest.h>

#include "core/random.h"

namespace saccade {
namespace {

constexpr AddressCodec all[] = {AddressCodec::dvs_128, AddressCodec::atis_20, AddressCodec::atis_24,
                                AddressCodec::ev2};
const ImageSize largest[] = {{128, 128}, {512, 256}, {1024, 512}, {2048, 1024}};

TEST(AddressEvent, WordsAreThoseOfTheOriginals) {
  const Event off_right{0, 5, 7, false, 1};
  EXPECT_EQ(encode_address(off_right, AddressCodec::dvs_128), 0x0000870bU);
  EXPECT_EQ(encode_address(off_right, AddressCodec::atis_20), 0x00101c0bU);
  EXPECT_EQ(encode_address(off_right, AddressCodec::atis_24), 0x0040700bU);
  EXPECT_EQ(encode_address(off_right, AddressCodec::ev2), 0x0040700bU);
  EXPECT_EQ(encode_address({0, 10, 20, true, 0}, AddressCodec::ev2), 0x00014014U);
}

TEST(AddressEvent, EveryEventComesBackFromItsWord) {
  const RandomStream random(5, "address_event");
  for (const AddressCodec codec : all) {
    const ImageSize size = largest[static_cast<int>(codec)];
    for (std::uint64_t i = 0; i < 1000; ++i) {
      const auto bits = [&](std::uint64_t what, int range) {
        return static_cast<std::uint16_t>(random.bits(what, i) % static_cast<std::uint64_t>(range));
      };
      const Event event{0, bits(0, size.width), bits(1, size.height), bits(2, 2) != 0,
                        static_cast<std::uint8_t>(bits(3, 2))};
      ASSERT_EQ(decode_address(encode_address(event, codec), codec), event);
    }
    const Event corner{0, static_cast<std::uint16_t>(size.width - 1),
                       static_cast<std::uint16_t>(size.height - 1), true, 1};
    EXPECT_EQ(decode_address(encode_address(corner, codec), codec), corner);
  }
}

TEST(AddressEvent, AnImageFitsUpToTheBitsOfItsCodec) {
  for (const AddressCodec codec : all) {
    const ImageSize size = largest[static_cast<int>(codec)];
    EXPECT_TRUE(is_encodable(size, codec));
    EXPECT_FALSE(is_encodable({size.width + 1, size.height}, codec));
    EXPECT_FALSE(is_encodable({size.width, size.height + 1}, codec));
  }
}

TEST(AddressEvent, ATouchOfTheSkinIsNoEventAndACornerIsOne) {
  EXPECT_FALSE(decode_address(1U << 21, AddressCodec::atis_20));
  EXPECT_FALSE(decode_address(1U << 24, AddressCodec::atis_24));
  EXPECT_FALSE(decode_address(1U << 24, AddressCodec::ev2));
  EXPECT_TRUE(decode_address(0xffff0000U, AddressCodec::dvs_128)) << "this codec has no skin";
  EXPECT_EQ(decode_address(1U << 21, AddressCodec::atis_24), (Event{0, 0, 0, true, 0}));
  EXPECT_EQ(decode_address(1U << 25, AddressCodec::ev2), (Event{0, 0, 0, true, 0}));
}

TEST(AddressEvent, MicrosecondsReadBackTheSameFromTicks) {
  for (const std::int64_t ns : {80, 128}) {
    for (std::int64_t t_us = -10'000; t_us < 10'000; ++t_us) {
      ASSERT_EQ(us_from_ticks(ticks_from_us(t_us, ns), ns), t_us);
    }
    const std::int64_t late_us = 1'234'567'890'123;
    EXPECT_EQ(us_from_ticks(ticks_from_us(late_us, ns), ns), late_us);
  }
}

TEST(AddressEvent, ACodecIsSelectedByItsName) {
  for (const AddressCodec codec : all) {
    EXPECT_EQ(address_codec(address_codec_names()[static_cast<std::size_t>(codec)]), codec);
  }
  EXPECT_FALSE(address_codec("atis"));
}

}  // namespace
}  // namespace saccade
