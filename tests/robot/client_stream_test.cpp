#include "robot/client_stream.h"

#include <gtest/gtest.h>

#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/random.h"
#include "robot/bottle.h"

namespace saccade {
namespace {

std::string integer(std::int32_t value) {
  std::string bytes(sizeof(value), '\0');
  std::memcpy(bytes.data(), &value, sizeof(value));
  return bytes;
}
/// YARP's 8 bytes of a number.
std::string number(std::int32_t value) { return "YA" + integer(value) + "RP"; }

constexpr std::int32_t tcp = 7777 + 3 + 128, fast_tcp = 7777 + 3, udp = 7777;

std::string introduction(std::int32_t carrier = tcp, std::string name = "/client") {
  name += '\0';
  return number(carrier) + integer(static_cast<std::int32_t>(name.size())) + name;
}
/// A message of one block, and an empty one for the reply, as YARP sends it.
std::string message(const std::string& payload) {
  return number(10) + std::string("\x01\x01") + std::string(8, '\xff') +
         integer(static_cast<std::int32_t>(payload.size())) + integer(0) + payload;
}
std::string command(char key) { return integer(0) + "~" + key + std::string("\0\1", 2); }
std::string command(const std::string& text) {
  return integer(static_cast<std::int32_t>(text.size() + 1)) + std::string("~\0\0\1", 4) + text + '\0';
}
std::string text_value(const std::string& text) {
  return integer(bottle::tag_string) + integer(static_cast<std::int32_t>(text.size())) + text;
}
std::string list(std::int32_t count, const std::string& values) {
  return integer(bottle::tag_list) + integer(count) + values;
}

const std::string admin = message(command('a') + list(1, text_value("list")));
const std::string data = message(command("d 17 1.5") + list(1, text_value("get")));

/// What of a stream passes, in parts of some bytes; none if it is refused.
std::optional<std::string> passed(const std::string& stream, std::size_t part = 1'000'000) {
  ClientStream checked;
  std::vector<std::byte> out;
  for (std::size_t at = 0; at < stream.size(); at += part) {
    const std::string bytes = stream.substr(at, part);
    if (!checked.add(std::as_bytes(std::span(bytes)), out)) return std::nullopt;
  }
  return std::string(reinterpret_cast<const char*>(out.data()), out.size());
}

TEST(ClientStream, PassesWhatYarpsOwnClientsSendWhateverTheParts) {
  const std::string streams[] = {
      introduction() + admin + data + message(command("/reader")) + message(command('q')),
      introduction(fast_tcp) + data + data,
      introduction() + message(command('r')) + number(0) + number(0),
      "CONNECT /write\r\nd\r\nlook 3D (-0.5 0.1 \"a (b\" [set])\r\n",
      "CONNACK admin\n*\na\n[list] [out]\n",
  };
  for (const std::string& stream : streams) {
    for (const std::size_t part : {1U, 7U, 1'000'000U}) EXPECT_EQ(passed(stream, part), stream) << part;
  }
}

TEST(ClientStream, HoldsWhatIsNotWholeBack) {
  const std::string stream = introduction() + admin;
  for (std::size_t size = 0; size < stream.size(); ++size) {
    ClientStream checked;
    std::vector<std::byte> out;
    ASSERT_TRUE(checked.add(std::as_bytes(std::span(stream).first(size)), out));
    const bool introduced = size >= introduction().size();
    EXPECT_EQ(out.size(), introduced ? introduction().size() : 0U);
    EXPECT_EQ(checked.is_introduced(), introduced);
    EXPECT_EQ(checked.has_part(), size != out.size());
  }
}

TEST(ClientStream, RefusesWhatYarpWouldBelieve) {
  const std::string long_name(1'001, 'x');
  const std::string refused[] = {
      "GET / HTTP/1.1\r\n",
      std::string(64, '\xff'),
      introduction(udp),
      introduction(tcp, long_name),
      introduction(tcp, "/a ((((((((((b))))))))))"),
      number(tcp) + integer(-1),
      "CONNECT " + long_name + "\n",
      // a message of 2 GB, or of less than nothing
      introduction() + number(10) + "\x01\x01" + std::string(8, '\xff') + integer(0x7fffffff) + integer(0),
      introduction() + number(10) + "\x02\x01" + std::string(8, '\xff') + integer(30'000) + integer(-60'000) +
          integer(0),
      introduction() + number(11),
      // counts and lengths beyond the end of the message, in data and in administrative messages
      introduction() + message(command('a') + list(1, integer(bottle::tag_string) + integer(-1))),
      introduction() + message(command('a') + list(1, integer(bottle::tag_string) + integer(0x7fffffff))),
      introduction() + message(command('d') + list(1'000'000, text_value("get"))),
      introduction() + message(command('a')),
      introduction() + message("short"),
      introduction() + message(integer(0) + "xxxx"),
      introduction() + message(command('i')),
      introduction() + message(integer(0) + std::string("~\0\0\1", 4) + "no end"),
      introduction() + message(command('r')) + number(1'000'000),
      // lists that do not end make YARP read on for ever, deep ones end its stack
      "CONNECT /c\nd\n(1 2\n",
      "CONNECT /c\nd\n\"open\n",
      "CONNECT /c\nd\nnext line \\\n",
      "CONNECT /c\nd\n" + std::string(5'000, '(') + std::string(5'000, ')') + "\n",
      "CONNECT /c\nd\n" + std::string(longest_bottle + 1, 'x'),
  };
  for (const std::string& stream : refused) {
    for (const std::size_t part : {1U, 1'000'000U})
      EXPECT_EQ(passed(stream, part), std::nullopt) << stream.substr(0, 60) << " of " << stream.size();
  }
}

TEST(ClientStream, KnowsAClientByUdpFromItsWholeIntroduction) {
  const std::string whole = introduction(udp, "/client/command:o");
  for (std::size_t size = 1; size < whole.size(); ++size) {
    const UdpIntroduction found = udp_introduction(std::as_bytes(std::span(whole).first(size)));
    EXPECT_TRUE(found.may_be && !found.name) << size;
  }
  EXPECT_EQ(udp_introduction(std::as_bytes(std::span(whole))).name, "/client/command:o");
  for (const std::string& other :
       {introduction(tcp), std::string("CONNECT /c\n"), introduction(udp, "/a (((((((((")})
    EXPECT_FALSE(udp_introduction(std::as_bytes(std::span(other))).may_be) << other;
}

TEST(ClientStream, StaysClosedAfterARefusal) {
  ClientStream checked;
  std::vector<std::byte> out;
  const std::string rubbish(16, 'x');
  EXPECT_FALSE(checked.add(std::as_bytes(std::span(rubbish)), out));
  EXPECT_FALSE(checked.add(std::as_bytes(std::span(admin)), out));
  EXPECT_TRUE(out.empty());
}

// Whatever a stream is changed to: what passes are whole units of it from the first on, and memory is bounded.
TEST(ClientStream, ChangedStreamsPassABeginningOrAreRefused) {
  const RandomStream random(3, "client streams");
  const std::string whole = introduction() + admin + data + admin;
  int refused = 0;
  for (std::uint64_t i = 0; i < 20'000; ++i) {
    std::string stream = whole;
    for (std::uint64_t n = 0; n < 1 + random.bits(0, i) % 3; ++n)
      stream[random.bits(10 + n, i) % stream.size()] = static_cast<char>(random.bits(20 + n, i));
    if (random.bits(1, i) % 4 == 0) stream.resize(random.bits(2, i) % stream.size());
    const auto found = passed(stream, 1 + random.bits(3, i) % 50);
    if (!found) {
      ++refused;
      continue;
    }
    ASSERT_EQ(*found, stream.substr(0, found->size()));
  }
  EXPECT_GT(refused, 5'000);
  EXPECT_LT(refused, 20'000);
}

}  // namespace
}  // namespace saccade
