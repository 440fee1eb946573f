#include <lz4frame.h>
#include <zstd.h>

#include <cstring>

#include "core/random.h"
#include "tests/recording/read_events.h"
#include "tests/recording/small_files.h"

namespace saccade {
namespace {

enum Compression { none = 0, lz4 = 1, zstd = 3 };

const std::string mark = "#!AER-DAT4.0\r\n";

/// What a table has in front of it: its own size, the table's size and where the fields are in that.
std::string field_places(std::initializer_list<std::uint16_t> places) {
  std::string bytes;
  for (const std::uint16_t place : places) bytes += little_endian(place);
  return bytes;
}

std::string stream_node(int number, const std::string& type, const std::string& info) {
  const std::string name = std::to_string(number);
  return "<node name=\"" + name + "\" path=\"/mainloop/Recorder/outInfo/" + name + "/\">\n" +
         "<attr key=\"compression\" type=\"string\">LZ4</attr>" +
         "<attr key=\"typeIdentifier\" type=\"string\">" + type + "</attr>" +
         "<node name=\"info\" path=\"\">" + info + "</node></node>";
}

std::string xml_of(const std::string& streams) {
  return "<dv version=\"2.0\"><node name=\"outInfo\" path=\"/mainloop/Recorder/outInfo/\">" + streams +
         "</node></dv>";
}

std::string size_info(int width, int height) {
  return "<attr key=\"sizeX\" type=\"int\">" + std::to_string(width) +
         "</attr><attr key=\"sizeY\" type=\"int\">" + std::to_string(height) + "</attr>";
}

const std::string usual_xml =
    xml_of(stream_node(0, "EVTS", size_info(320, 240)) + stream_node(2, "IMUS", ""));

/// The header table; `table_place` is where the table of packets begins, -1 for none.
std::string header_table(int compression, std::int64_t table_place, const std::string& xml) {
  std::string bytes = little_endian<std::uint32_t>(24) + "IOHE" + std::string(6, '\0');
  bytes += field_places({10, 20, 4, 12, 8});
  bytes += little_endian(10) + little_endian(compression) + little_endian(12) + little_endian(table_place);
  return bytes + little_endian(static_cast<std::uint32_t>(xml.size())) + xml + '\0';
}

/// A file of these packets, with or without the table with their end.
std::string file_of(int compression, const std::string& packets, bool with_table = true,
                    const std::string& xml = usual_xml) {
  const std::size_t size = header_table(compression, 0, xml).size();
  const std::size_t end = mark.size() + 4 + size + packets.size();
  const std::int64_t place = with_table ? static_cast<std::int64_t>(end) : -1;
  return mark + little_endian(static_cast<std::uint32_t>(size)) + header_table(compression, place, xml) +
         packets + (with_table ? "the table of packets" : "");
}

/// The bytes of a packet's table before they are compressed.
std::string event_table(const std::vector<Event>& events) {
  std::string bytes = little_endian<std::uint32_t>(16) + "EVTS" + std::string(2, '\0');
  bytes += field_places({6, 8, 4});
  bytes += little_endian(6) + little_endian(4) + little_endian(static_cast<std::uint32_t>(events.size()));
  for (const Event& event : events) {
    bytes += little_endian(event.t_us) + little_endian(event.x) + little_endian(event.y);
    bytes += std::string(1, event.on ? '\1' : '\0') + std::string(3, '\0');
  }
  return little_endian(static_cast<std::uint32_t>(bytes.size())) + bytes;
}

std::string compress(int compression, const std::string& bytes) {
  if (compression == none) return bytes;
  const bool is_lz4 = compression == lz4;
  std::string packed(
      is_lz4 ? LZ4F_compressFrameBound(bytes.size(), nullptr) : ZSTD_compressBound(bytes.size()), '\0');
  packed.resize(is_lz4 ? LZ4F_compressFrame(packed.data(), packed.size(), bytes.data(), bytes.size(), nullptr)
                       : ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), 1));
  return packed;
}

std::string packet(int stream, const std::string& bytes) {
  return little_endian(stream) + little_endian(static_cast<std::int32_t>(bytes.size())) + bytes;
}

std::string event_packet(int compression, const std::vector<Event>& events) {
  return packet(0, compress(compression, event_table(events)));
}

std::vector<Event> some_events(std::size_t count) {
  const RandomStream random(5, "aedat4_test");
  std::vector<Event> events(count);
  for (std::size_t i = 0; i < count; ++i) {
    events[i] = {1605537493718345 + static_cast<std::int64_t>(3 * i),
                 static_cast<std::uint16_t>(random.bits(0, i) % 320),
                 static_cast<std::uint16_t>(random.bits(1, i) % 240), (random.bits(2, i) & 1) != 0, 0};
  }
  return events;
}

class Aedat4 : public testing::TestWithParam<Compression> {};

TEST_P(Aedat4, GivesTheEventsOfPacketsOfAnySizeAmongThoseOfOtherStreams) {
  // Packets of none, of one, and of 1.6 MB, more than any buffer holds.
  const auto events = some_events(100'011);
  std::string packets = packet(2, std::string(3'000'000, 'x'));
  std::size_t first = 0;
  for (const std::size_t count : {1, 0, 10, 100'000}) {
    packets += event_packet(GetParam(), {events.begin() + static_cast<std::ptrdiff_t>(first),
                                         events.begin() + static_cast<std::ptrdiff_t>(first + count)});
    packets += packet(2, "inertial") + packet(7, "");
    first += count;
  }
  for (const bool with_table : {true, false}) {
    const TempFolder folder;
    const auto path = folder.write("a.aedat4", file_of(GetParam(), packets, with_table));
    for (const std::size_t block : {std::size_t{1}, std::size_t{4096}, std::size_t{1'000'000}}) {
      const auto reader = open_event_file(path);
      EXPECT_EQ(reader->image_size(), (ImageSize{320, 240}));
      EXPECT_THAT(reader->format(), testing::StartsWith("AEDAT 4.0"));
      EXPECT_EQ(read_all(*reader, block), events) << block;
    }
  }
}

TEST_P(Aedat4, CutAtAnyByteGivesTheEventsBeforeTheCutAndThenAnError) {
  const auto events = some_events(30);
  std::string packets;
  for (std::ptrdiff_t i = 0; i < 30; i += 10) {
    packets += event_packet(GetParam(), {events.begin() + i, events.begin() + i + 10}) + packet(2, "imu");
  }
  // The header contains the end of the packets, so no cut before it looks like the end.
  const std::string with_table = file_of(GetParam(), packets);
  const std::size_t table_bytes = std::strlen("the table of packets");
  EXPECT_EQ(count_errors_of_cut_files(with_table, events), with_table.size() - table_bytes);
  // Without it a file may end behind its header and behind each of its six packets but the last.
  const std::string without = file_of(GetParam(), packets, false);
  EXPECT_EQ(count_errors_of_cut_files(without, events), without.size() - 6);
}

TEST_P(Aedat4, WithAnyByteChangedGivesEventsOrAnError) {
  const std::string whole = file_of(GetParam(), event_packet(GetParam(), some_events(5)) + packet(2, "imu"));
  const TempFolder folder;
  std::size_t errors = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    for (const char change : {'\x01', '\x80', '\xff'}) {
      std::string broken = whole;
      broken[i] = static_cast<char>(broken[i] ^ change);
      try {
        EXPECT_LE(read_file(folder.write("a", broken)).size(), 5u);
      } catch (const InputError&) {
        ++errors;
      }
    }
  }
  EXPECT_GT(errors, 0u);
}

INSTANTIATE_TEST_SUITE_P(Recording, Aedat4, testing::Values(none, lz4, zstd), [](const auto& tested) {
  return tested.param == none ? "None" : tested.param == lz4 ? "Lz4" : "Zstd";
});

struct BrokenPacket {
  std::string name;
  Compression compression;
  std::string bytes;
  std::string message;
  bool gives_three_events = false;  ///< those of some_events(3), before the place that is broken
};

class BrokenAedat4 : public testing::TestWithParam<BrokenPacket> {};

TEST_P(BrokenAedat4, GivesTheEventsBeforeItAndThenAnErrorWithItsPlace) {
  const TempFolder folder;
  const Compression compression = GetParam().compression;
  auto events = some_events(20);
  const std::string good = event_packet(compression, events);
  const auto path = folder.write("a.aedat4", file_of(compression, good + GetParam().bytes + good));
  if (GetParam().gives_three_events) events.insert(events.end(), events.begin(), events.begin() + 3);
  expect_events_then_error(path, events, GetParam().message);
}

std::string replaced(std::string bytes, std::size_t place, const std::string& by) {
  return bytes.replace(place, by.size(), by);
}

const std::string plain_table = event_table(some_events(3));
const std::string lz4_frame = compress(lz4, plain_table);

INSTANTIATE_TEST_SUITE_P(
    Recording, BrokenAedat4,
    testing::Values(
        BrokenPacket{"NegativeSize", none, little_endian(0) + little_endian(-5), "a packet of -5 bytes"},
        BrokenPacket{"HugeSize", none, little_endian(0) + little_endian(0x7fffffff),
                     "one that ends before the table of packets"},
        BrokenPacket{"HugeSizeOfAnotherStream", none, little_endian(9) + little_endian(0x7fffffff),
                     "one that ends before the table of packets"},
        BrokenPacket{"NoBytes", lz4, packet(0, ""), "a packet without its end"},
        BrokenPacket{"FrameCut", lz4, packet(0, lz4_frame.substr(0, lz4_frame.size() - 8)),
                     "a packet without its end"},
        BrokenPacket{"BytesBehindTheFrame", lz4, packet(0, lz4_frame + "1234567"), "ERROR_frameType_unknown",
                     true},
        BrokenPacket{"NoLz4", lz4, packet(0, plain_table), "ERROR_frameType_unknown"},
        BrokenPacket{"NoZstd", zstd, packet(0, lz4_frame), "a packet that can be unpacked"},
        BrokenPacket{"NotEvents", none, packet(0, replaced(plain_table, 8, "IMUS")), "found a packet IMUS"},
        BrokenPacket{"MoreEventsThanBytes", none,
                     packet(0, replaced(plain_table, 28, little_endian(0x0fffffff))),
                     "found 268435455 events in a packet of 76 bytes"},
        BrokenPacket{
            "FewerEventsThanPromised", none,
            packet(0, replaced(replaced(plain_table, 28, little_endian(30)), 0, little_endian(28 + 30 * 16))),
            "a packet that ends 27 events early", true},
        BrokenPacket{"RootOutside", none, packet(0, replaced(plain_table, 4, little_endian(0x7ffffff0))),
                     "an offset that leads outside the packet"},
        BrokenPacket{"FieldsOutside", none, packet(0, replaced(plain_table, 20, little_endian(0x7ffffff0))),
                     "an offset that leads outside the packet"},
        BrokenPacket{"VectorOutside", none, packet(0, replaced(plain_table, 24, little_endian(-1))),
                     "an offset that leads outside the packet"},
        BrokenPacket{"TooShort", none, packet(0, "abc"), "an offset that leads outside the packet"}),
    [](const auto& broken) { return broken.param.name; });

TEST(Aedat4File, WhoseHeaderIsBrokenIsNotOpened) {
  const TempFolder folder;
  const auto message = [&](const std::string& content) -> std::string {
    try {
      (void)open_event_file(folder.write("a.aedat4", content));
    } catch (const InputError& error) {
      return error.what();
    }
    return "opened";
  };
  using testing::HasSubstr;
  const std::string whole = file_of(none, event_packet(none, some_events(1)));
  EXPECT_EQ(message(whole), "opened");
  EXPECT_THAT(message(mark + little_endian(0xffffffffu)), HasSubstr("a header of 4294967295 bytes"));
  EXPECT_THAT(message(mark + little_endian(500u) + "abc"), HasSubstr("the rest of the header"));
  EXPECT_THAT(message(mark + little_endian(0u)), HasSubstr("an offset that leads outside the header"));
  EXPECT_THAT(message(replaced(whole, mark.size() + 8, "XXXX")), HasSubstr("a header table IOHE"));
  EXPECT_THAT(message(file_of(9, "")), HasSubstr("the compression 9"));
  EXPECT_THAT(message(file_of(none, "", true, xml_of(stream_node(0, "FRME", size_info(8, 8))))),
              HasSubstr("no stream of events"));
  EXPECT_THAT(message(file_of(none, "", true, "")), HasSubstr("no stream of events"));
  const std::size_t place_of_end = mark.size() + 4 + 36;
  EXPECT_THAT(message(replaced(whole, place_of_end, little_endian(std::int64_t{20}))),
              HasSubstr("one after the header"));
}

TEST(Aedat4File, GivesTheFirstStreamOfEventsWithItsOwnSize) {
  const TempFolder folder;
  const std::string xml =
      xml_of(stream_node(1, "FRME", size_info(8, 8)) + stream_node(10, "EVTS", size_info(640, 480)) +
             stream_node(3, "EVTS", size_info(346, 260)));
  const auto events = some_events(4);
  const std::string packets = packet(10, event_table(some_events(7))) + packet(3, event_table(events));
  const auto reader = open_event_file(folder.write("a.aedat4", file_of(none, packets, true, xml)));
  EXPECT_EQ(reader->image_size(), (ImageSize{346, 260}));
  EXPECT_EQ(read_all(*reader), events);
}

TEST(Aedat4File, TakesTheImageSizeFromTheOptionOnlyWhereTheHeaderHasNone) {
  const TempFolder folder;
  EventReadOptions options;
  options.image_size = ImageSize{100, 90};
  const auto size_of = [&](const std::string& info, const EventReadOptions& given) {
    const std::string file = file_of(none, "", true, xml_of(stream_node(0, "EVTS", info)));
    return open_event_file(folder.write("a.aedat4", file), given)->image_size();
  };
  EXPECT_EQ(size_of(size_info(320, 240), options), (ImageSize{320, 240}));
  EXPECT_EQ(size_of("", options), (ImageSize{100, 90}));
  EXPECT_EQ(size_of(size_info(-2147483647 - 1, 240), options), (ImageSize{100, 90}));
  EXPECT_EQ(size_of("", {}), std::nullopt);
}

TEST_F(RealRecording, CutInTheMiddleGivesABeginningOfTheWhole) {
  const auto whole = read_real("hand_wave_dvs128_lz4.aedat4");
  const std::string bytes = bytes_of(path_of("hand_wave_dvs128_lz4.aedat4"));
  const TempFolder folder;
  const auto path = folder.write("cut.aedat4", std::string_view(bytes).substr(0, bytes.size() / 2));
  const auto reader = open_event_file(path);
  std::vector<Event> events;
  const auto read_on = [&] {
    while (reader->read(events, 1000) > 0) {
    }
  };
  EXPECT_THROW(read_on(), InputError);
  // Half of the bytes are about half of the events: a packet is 0.2 % of the file.
  EXPECT_NEAR(static_cast<double>(events.size()), 0.5 * static_cast<double>(whole.size()),
              0.05 * static_cast<double>(whole.size()));
  EXPECT_TRUE(std::equal(events.begin(), events.end(), whole.begin()));
}

}  // namespace
}  // namespace saccade
