#include "robot/event_packet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <initializer_list>
#include <string>

#include "core/random.h"

namespace saccade {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr PacketFormat all[] = {PacketFormat::packet, PacketFormat::stamped_packet, PacketFormat::vbottle};

std::vector<std::byte> bytes(const std::string& text) {
  std::vector<std::byte> message(text.size());
  std::memcpy(message.data(), text.data(), text.size());
  return message;
}

/// Integers as the wire has them; text is taken as it is.
struct Part {
  Part(std::int32_t value) : text(reinterpret_cast<const char*>(&value), 4) {}
  Part(const char* literal) : text(literal) {}
  std::string text;
};
std::vector<std::byte> message(std::initializer_list<Part> parts) {
  std::string text;
  for (const Part& part : parts) text += part.text;
  return bytes(text);
}

EventPacket some_packet(PacketFormat format) {
  const RandomStream random(7, "event_packet");
  EventPacket packet;
  if (format != PacketFormat::vbottle) packet.duration_us = 1234;
  for (std::uint64_t i = 0; i < 20; ++i) {
    const auto bits = [&](std::uint64_t what) { return static_cast<std::uint32_t>(random.bits(what, i)); };
    packet.events.push_back({has_stamps(format) ? bits(0) >> 1 : 0, bits(1)});
  }
  return packet;
}

TEST(EventPacket, AMessageHasTheBytesOfTheOriginalSoftware) {
  std::vector<std::byte> written;
  write_packet({1000, {{0, 0x00014014}}}, PacketFormat::packet, written);
  EXPECT_EQ(written, message({256, 3, 4, 2, "AE", 1, 1000, 4, 4, 0x00014014}));
  EXPECT_EQ(std::vector<std::byte>(written.end() - 4, written.end()), bytes({"\x14\x40\x01\x00", 4}));
  write_packet({1000, {{123, 0x0040700b}}}, PacketFormat::stamped_packet, written);
  EXPECT_EQ(written, message({256, 3, 4, 2, "AE", 1, 1000, 4, 8, 123, 0x0040700b}));
  write_packet({0, {{123, 0x0040700b}}}, PacketFormat::vbottle, written);
  EXPECT_EQ(written, message({256, 2, 4, 2, "AE", 257, 2, 123, 0x0040700b}));
}

TEST(EventPacket, ReadsWhatItHasWritten) {
  std::vector<std::byte> written;
  EventPacket read;
  for (const PacketFormat format : all) {
    const EventPacket packet = some_packet(format);
    write_packet(packet, format, written);
    EXPECT_EQ(read_packet(written, format, read), "");
    EXPECT_EQ(read.events, packet.events);
    EXPECT_EQ(read.duration_us, packet.duration_us);
    write_packet({packet.duration_us, {}}, format, written);
    EXPECT_EQ(read_packet(written, format, read), "") << "a packet without events";
    EXPECT_THAT(read.events, IsEmpty());
  }
}

TEST(EventPacket, AnEmptyListIsAPacketWithoutEvents) {
  EventPacket read;
  for (const PacketFormat format : all) EXPECT_EQ(read_packet(message({256, 0}), format, read), "");
}

TEST(EventPacket, AVBottleCanContainOtherListsAndIntegersWithTypes) {
  EventPacket read;
  EXPECT_EQ(read_packet(message({256, 8,                                                   //
                                 4,   3, "IMU", 257, 2, 5,  6,                             //
                                 4,   2, "AE",  256, 2, 1,  10, 1,   20,                   //
                                 4,   3, "GAE", 256, 3, 4,  1,  "x", 10, 0, 0, 257, 1, 7,  //
                                 4,   2, "AE",  257, 2, 30, 40}),
                        PacketFormat::vbottle, read),
            "");
  EXPECT_THAT(read.events, ElementsAre(WireEvent{10, 20}, WireEvent{30, 40}));
}

TEST(EventPacket, AMessageOfAnotherFormatIsRejected) {
  std::vector<std::byte> written;
  EventPacket read;
  write_packet(some_packet(PacketFormat::vbottle), PacketFormat::vbottle, written);
  EXPECT_THAT(std::string(read_packet(written, PacketFormat::packet, read)), HasSubstr("not an ev::packet"));
  write_packet(some_packet(PacketFormat::packet), PacketFormat::packet, written);
  EXPECT_THAT(std::string(read_packet(written, PacketFormat::vbottle, read)), HasSubstr("not a vBottle"));
  EXPECT_THAT(read.events, IsEmpty());
  EXPECT_THAT(
      std::string(read_packet(message({256, 3, 4, 3, "IMU", 1, 10, 4, 0}), PacketFormat::packet, read)),
      HasSubstr("other things than AE"));
  EXPECT_THAT(std::string(read_packet(message({256, 3, 4, 2, "AE", 1, 10, 4, 4, 1}),
                                      PacketFormat::stamped_packet, read)),
              HasSubstr("inside an event"));
}

TEST(EventPacket, TruncatedAndCorruptMessagesAreNotReadBeyondTheirEnd) {
  std::vector<std::byte> written;
  EventPacket read;
  for (const PacketFormat format : all) {
    write_packet(some_packet(format), format, written);
    for (std::size_t size = 0; size < written.size(); ++size) {
      const std::vector<std::byte> cut(written.begin(), written.begin() + static_cast<std::ptrdiff_t>(size));
      EXPECT_NE(read_packet(cut, format, read), "") << size;
      EXPECT_THAT(read.events, IsEmpty());
    }
    for (std::size_t i = 0; i < written.size(); ++i) {
      for (const int value : {0, 0x7f, 0x80, 0xff}) {
        std::vector<std::byte> broken = written;
        broken[i] = static_cast<std::byte>(value);
        for (const PacketFormat reader : all) (void)read_packet(broken, reader, read);
      }
    }
    written.push_back(std::byte{0});
    EXPECT_NE(read_packet(written, format, read), "") << "a byte too many";
  }
}

TEST(EventPacket, ListsWithoutEndAreRejected) {
  EventPacket read;
  EXPECT_NE(read_packet(message({256, 2, 4, 2, "AE", 257, 0x7ffffffe}), PacketFormat::vbottle, read), "");
  EXPECT_NE(read_packet(message({256, 2, 4, 2, "AE", 257, -2}), PacketFormat::vbottle, read), "");
  EXPECT_NE(read_packet(message({256, 2, 4, 0x7fffffff, "AE"}), PacketFormat::vbottle, read), "");
  std::string nested;
  for (int i = 0; i < 100'000; ++i) nested += Part(256).text + Part(1).text;
  EXPECT_NE(read_packet(bytes(Part(256).text + Part(2).text + Part(4).text + Part(1).text + "x" + nested),
                        PacketFormat::vbottle, read),
            "");
}

}  // namespace
}  // namespace saccade
