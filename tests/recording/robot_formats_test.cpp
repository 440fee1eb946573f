// Files of other tools that hold arrays or messages: NumPy, bags of ROS 1, MCAP.
#include <bzlib.h>
#include <lz4frame.h>
#include <sys/resource.h>

#include <bit>
#include <csignal>
#include <limits>

#include "recording/event_message.h"
#include "recording/format_registry.h"
#include "recording/output_file.h"
#include "tests/core/streams.h"
#include "tests/recording/made_events.h"
#include "tests/recording/read_events.h"
#include "tests/recording/small_files.h"

namespace saccade {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

constexpr ImageSize image{304, 240};
constexpr std::array written_names = {"a.npz", "a.npy", "a.bag", "a.packets.bag", "a.mcap", "a.db3"};

void write_events(const std::filesystem::path& path, const std::vector<Event>& events, int cameras = 1) {
  const auto writer = create_event_file(path, image, cameras);
  writer->write(events);
  writer->commit();
}

/// The file `name` of small_files().
SmallFile small_file(const std::string& name) {
  for (const SmallFile& file : small_files()) {
    if (file.name == name) return file;
  }
  return {};
}

std::string replaced(std::string text, std::string_view what, std::string_view by) {
  const std::size_t place = text.find(what);
  EXPECT_NE(place, std::string::npos);
  return text.replace(place, what.size(), by);
}

TEST(RobotFormats, RoundTripsKeepEveryEventAndGiveTheSameBytesAgain) {
  const TempFolder folder;
  for (const char* name : written_names) {
    // Several messages and chunks; a silence of 100 s, and times that go back.
    std::vector<Event> events = streams::random(image, 150'000, 3);
    std::vector<Event> later = streams::shifted(streams::random(image, 9'000, 4), 100'000'000);
    std::swap(later[100], later[200]);
    events.insert(events.end(), later.begin(), later.end());
    write_events(folder / name, events);
    const auto reader = open_event_file(folder / name);
    // A single array has no room for the size.
    if (std::string_view(name) != "a.npy") {
      EXPECT_EQ(reader->image_size(), image) << name;
    }
    EXPECT_TRUE(read_all(*reader) == events) << name;
    EXPECT_EQ(reader->skipped(), "") << name;
    const std::string again = std::string("again_") + name;
    write_events(folder / again, events);
    EXPECT_TRUE(bytes_of(folder / name) == bytes_of(folder / again)) << name;
  }
}

TEST(RobotFormats, AFileWithoutEventsIsWrittenAndRead) {
  const TempFolder folder;
  for (const char* name : written_names) {
    write_events(folder / name, {});
    EXPECT_TRUE(read_file(folder / name).empty()) << name;
  }
}

TEST(RobotFormats, AWrittenFileThatIsCutGivesItsFirstEventsAndThenAnError) {
  const std::vector<Event> events = streams::random({128, 128}, 40, 5);
  for (const char* name : written_names) {
    if (std::string_view(name) == "a.db3") continue;  // truncation_test.cpp cuts one with smaller pages
    const TempFolder folder;
    write_events(folder / name, events);
    const std::string whole = bytes_of(folder / name);
    // A bag is whole for its first two records too: one of a recorder that was killed has no more.
    const std::size_t errors = count_errors_of_cut_files(whole, events);
    EXPECT_GE(errors + 3, whole.size()) << name;
  }
}

TEST(RobotFormats, HeadersOfAnyBytesAreNeverMoreThanAnError) {
  for (const SmallFile& file : small_files()) {
    const bool is_one = file.name.ends_with(".npz") || file.name.ends_with(".npy") ||
                        file.name.ends_with(".bag") || file.name.ends_with(".mcap");
    if (!is_one) continue;
    const TempFolder folder;
    const std::string whole = file.bytes();
    for (std::size_t place = 0; place < whole.size(); ++place) {
      for (const char value : {'\x00', '\x7f', '\xff'}) {
        std::string broken = whole;
        broken[place] = value;
        try {
          (void)read_file(folder.write(file.name, broken));
        } catch (const InputError& error) {
          EXPECT_FALSE(error.problems().empty());
        }
      }
    }
  }
}

TEST(RobotFormats, WritersRejectTimesThatTheirMessagesCannotHold) {
  const TempFolder folder;
  for (const char* name : {"a.bag", "a.mcap"}) {
    for (const std::int64_t t_us : {std::int64_t{-1}, std::int64_t{1} << 53}) {
      EXPECT_THAT(
          [&] {
            write_events(folder / name, {{t_us, 1, 2, true, 0}});
          },
          ThrowsMessage<InputError>(AllOf(HasSubstr(name), HasSubstr("--zero-time"))));
    }
  }
  EXPECT_THAT(
      [&] {
        (void)create_event_file(folder / "a.mcap", {304, 40'000});
      },
      ThrowsMessage<InputError>(HasSubstr("at most 32768 rows")));
  write_events(folder / "a.npz", {{std::numeric_limits<std::int64_t>::min(), 1, 2, true, 0}});
  EventReadOptions options;
  options.time_unit = TimeUnit::us;  // which is not stated in the file
  EXPECT_EQ(read_file(folder / "a.npz", options).front().t_us, std::numeric_limits<std::int64_t>::min());
}

// ---- NumPy ---------------------------------------------------------------------------------------

TEST(Numpy, KeepsTheEventsOfTwoCameras) {
  const TempFolder folder;
  const std::vector<Event> events = {{5, 3, 4, true, 0}, {6, 1, 2, false, 1}, {6, 3, 4, true, 0}};
  for (const char* name : {"a.npz", "a.npy"}) {
    write_events(folder / name, events, 2);
    EXPECT_EQ(read_file(folder / name), events) << name;
  }
}

TEST(Numpy, AnArrayOfRowsIsReadByTheOrderOfTheColumns) {
  const TempFolder folder;
  const std::string header = "{'descr': '<i8', 'fortran_order': False, 'shape': (2, 4), }\n";
  const std::string file = "\x93NUMPY" + std::string("\1\0", 2) +
                           little_endian(static_cast<std::uint16_t>(header.size())) + header +
                           little_endian_words<std::int64_t>({3, 4, 100, 1, 5, 6, 200, 0});
  EventReadOptions options;
  options.columns = "xytp";
  EXPECT_THAT(read_file(folder.write("a.npy", file), options),
              testing::ElementsAre(Event{100, 3, 4, true, 0}, Event{200, 5, 6, false, 0}));
}

TEST(Numpy, ArraysThatAreNoEventsAreListedInTheError) {
  const TempFolder folder;
  const std::string records = small_file("records.npz").bytes();
  EXPECT_THAT([&] { (void)read_file(folder.write("a.npz", replaced(records, "('x',", "('u',"))); },
              ThrowsMessage<InputError>(
                  AllOf(HasSubstr("sensor_size (3 x <i4), events (2 x t u y p)"), HasSubstr("--columns"))));
}

TEST(Numpy, AValueThatNoEventHasIsAnErrorWithItsRowAfterTheRowsBefore) {
  const TempFolder folder;
  const std::string records = small_file("records.npy").bytes();
  const std::string row = little_endian(std::int64_t{-6}) + little_endian<std::uint16_t>(303);
  const std::string bad = row + little_endian<std::int16_t>(-239);
  expect_events_then_error(
      folder.write("a.npy", replaced(records, row + little_endian<std::uint16_t>(239), bad)),
      {{5, 3, 4, true, 0}}, "row 1: found y = -239");
}

TEST(Numpy, AnArrayWithAnotherChecksumIsAnErrorAfterItsEvents) {
  const TempFolder folder;
  const SmallFile file = small_file("records.npz");
  const std::string x = little_endian<std::uint16_t>(303);
  std::vector<Event> events = file.events();
  events[1].x = 302;
  expect_events_then_error(
      folder.write("a.npz", replaced(file.bytes(), x, little_endian<std::uint16_t>(302))), events,
      "checksum of events.npy");
}

// ---- bags and MCAP -------------------------------------------------------------------------------

/// The chunk of a bag that is compressed.
std::string packed_bag(const std::string& word, const std::string& records, const std::string& packed) {
  const auto field = [](const std::string& text) {
    return little_endian(static_cast<std::uint32_t>(text.size())) + text;
  };
  const std::string header = field("op=\5") + field("compression=" + word) +
                             field("size=" + little_endian(static_cast<std::uint32_t>(records.size())));
  return "#ROSBAG V2.0\n" + field(header) + field(packed);
}

TEST(RosBag, ChunksOfLz4AndBzip2AreUnpacked) {
  const SmallFile file = small_file("events.bag");
  const std::string& chunk = file.pieces[2].bytes;
  // Behind the chunk's header and the length of its data.
  const std::size_t header = 4 + static_cast<unsigned char>(chunk[0]);
  const std::string records = chunk.substr(header + 4);
  std::string lz4(LZ4F_compressFrameBound(records.size(), nullptr), '\0');
  lz4.resize(LZ4F_compressFrame(lz4.data(), lz4.size(), records.data(), records.size(), nullptr));
  std::string bz2(records.size() + 1000, '\0');
  auto bz2_size = static_cast<unsigned>(bz2.size());
  ASSERT_EQ(BZ2_bzBuffToBuffCompress(bz2.data(), &bz2_size, const_cast<char*>(records.data()),
                                     static_cast<unsigned>(records.size()), 1, 0, 0),
            BZ_OK);
  bz2.resize(bz2_size);
  const TempFolder folder;
  for (const auto& [word, packed] : {std::pair{"lz4", lz4}, {"bz2", bz2}, {"none", records}}) {
    const auto path = folder.write("a.bag", packed_bag(word, records, packed));
    EXPECT_EQ(read_file(path), file.pieces[2].events) << word;
  }
  EXPECT_THAT([&] { (void)read_file(folder.write("a.bag", packed_bag("xz", records, records))); },
              ThrowsMessage<InputError>(HasSubstr("found the compression xz")));
}

TEST(RosBag, OtherMessagesAreCountedAndTheTopicsNameTheCamera) {
  const TempFolder folder;
  const auto reader = open_event_file(folder.write("a.bag", small_file("events.bag").bytes()));
  EXPECT_EQ(reader->format(), "ROS bag 2.0 dvs_msgs/EventArray");
  EXPECT_EQ(reader->image_size(), image);
  const std::vector<Event> events = read_all(*reader);
  EXPECT_EQ(events.back().camera, 1) << "of /right/events";
  EXPECT_EQ(reader->skipped(), "1 messages of /imu (sensor_msgs/Imu)");
  EXPECT_EQ(reader->host_ahead_us(), 70) << "recorded 70 us after the newest event";
}

TEST(RosBag, AnOlderVersionIsAnErrorThatNamesTheVersionThatIsRead) {
  const TempFolder folder;
  EXPECT_THAT([&] { (void)read_file(folder.write("a.bag", "#ROSBAG V1.2\n")); },
              ThrowsMessage<InputError>(HasSubstr("a bag of version 2.0")));
}

TEST(Mcap, AChunkWithAnotherChecksumIsAnErrorAfterItsEvents) {
  const SmallFile file = small_file("events.mcap");
  std::string bytes = file.bytes();
  const std::size_t chunk = bytes.find("zstd") - 8;  // the checksum is in front of the word
  bytes[chunk] = static_cast<char>(bytes[chunk] + 1);
  std::vector<Event> events = file.pieces[3].events;
  events.insert(events.end(), file.pieces[4].events.begin(), file.pieces[4].events.end());
  const TempFolder folder;
  expect_events_then_error(folder.write("a.mcap", bytes), events, "a chunk with another checksum");
}

TEST(RosBag, TwoCamerasAreMergedByTimeThoughTheirMessagesAreNot) {
  // 20 ms of the left camera, then 20 ms of the right one within them: each in messages of 10 ms.
  const TempFolder folder;
  std::vector<Event> events;
  for (std::int64_t t_us = 0; t_us < 20'000; t_us += 100) {
    events.push_back({t_us, 1, 2, true, 0});
    events.push_back({t_us, 3, 4, false, 1});
  }
  for (const char* name : {"a.bag", "a.packets.bag", "a.mcap"}) {
    write_events(folder / name, events, 2);
    EXPECT_EQ(read_file(folder / name), events) << name;
  }
}

TEST(RosBag, ASilentCameraDoesNotKeepTheOtherOneInMemory) {
  // More events than are read ahead, and one of the right camera at the end.
  const TempFolder folder;
  std::vector<Event> events;
  constexpr std::int64_t count = 300'000;
  for (std::int64_t i = 0; i < count; ++i) events.push_back({i, 1, 2, true, 0});
  events.push_back({count, 3, 4, false, 1});
  for (const char* name : {"a.bag", "a.mcap"}) {
    write_events(folder / name, events, 2);
    EXPECT_EQ(read_file(folder / name), events) << name;
  }
}

/// An EventPacket of 304x240 in ROS 1's serialisation with the time base 1000000.4 us.
std::string packet(const std::string& encoding, const std::string& events) {
  const auto text = [](const std::string& t) {
    return little_endian(static_cast<std::uint32_t>(t.size())) + t;
  };
  return little_endian_words<std::uint32_t>({0, 0, 0}) + text("") +
         little_endian_words<std::uint32_t>({240, 304}) +
         little_endian_words<std::uint64_t>({0, 1'000'000'400}) + text(encoding) + std::string(1, '\0') +
         text(events);
}

TEST(EventMessage, PacketsOfLibcaerContinueTheirTimeOverAWrapAndTriggersAreNoEvents) {
  EventMessageDecoder decoder(EventMessageType::event_packet, Serialisation::ros1);
  const auto polarity = [](std::uint32_t x, std::uint32_t y, std::uint32_t on, std::uint32_t t) {
    return little_endian_words<std::uint32_t>({x << 17 | y << 2 | on << 1 | 1, t});
  };
  std::vector<Event> events;
  EXPECT_FALSE(
      decoder.decode(packet("libcaer", polarity(5, 6, 1, 0x7fffffff) + polarity(7, 8, 0, 2)), events));
  EXPECT_THAT(events, testing::ElementsAre(Event{1'000'000 + std::int64_t{0x7fffffff}, 5, 6, true, 0},
                                           Event{1'000'000 + (std::int64_t{1} << 31) + 2, 7, 8, false, 0}));
  EXPECT_FALSE(decoder.decode(packet("trigger", "12345678"), events));
  EXPECT_EQ(events.size(), 2u);
  const auto broken = decoder.decode(packet("libcaer_zip", "12345678"), events);
  ASSERT_TRUE(broken);
  EXPECT_EQ(broken->found, "a packet in the encoding libcaer_zip");
}

TEST(EventMessage, PacketsOfLibcaerCmpHoldTimesAddressesAndVectorsOfRows) {
  EventMessageDecoder decoder(EventMessageType::event_packet, Serialisation::ros1);
  const std::string words = little_endian_words<std::uint16_t>({
      0x0001, 0x1003,        // 1 * 4096 + 3 us
      0x2000 | 300,          // x
      0x3000 | 0x800 | 200,  // ON at y
      0x3000 | 201,          // OFF
      0x1004, 0x2000 | 7,    // 1 us later, at another x
      0x4000 | 0x800 | 100,  // ON from row 100 on
      0x5000 | 0x81,         // rows 100 and 107
      0x5000 | 0x02,         // row 109
  });
  const std::int64_t base_us = 1'000'000 + 4096;
  std::vector<Event> events;
  EXPECT_FALSE(decoder.decode(packet("libcaer_cmp", words), events));
  const std::vector<Event> expected = {{base_us + 3, 300, 200, true, 0},
                                       {base_us + 3, 300, 201, false, 0},
                                       {base_us + 4, 7, 100, true, 0},
                                       {base_us + 4, 7, 107, true, 0},
                                       {base_us + 4, 7, 109, true, 0}};
  EXPECT_EQ(events, expected);
  events.clear();
  // A packet starts at its own time base again.
  EXPECT_FALSE(
      decoder.decode(packet("libcaer_cmp", little_endian_words<std::uint16_t>({0x2001, 0x3002})), events));
  EXPECT_THAT(events, testing::ElementsAre(Event{1'000'000, 1, 2, false, 0}));
  EXPECT_FALSE(decoder.decode(
      packet("libcaer_cmp", little_endian_words<std::uint16_t>({0x3002, 0x6001, 0x3003})), events));
  EXPECT_EQ(events.size(), 3u) << "those behind a word of an undefined type are there";
  EXPECT_EQ(decoder.packets().counts().undefined[6], 1);
}

TEST(EventMessage, PacketsOfEvt2ContinueTheSensorsCounterFromPacketToPacket) {
  EventMessageDecoder decoder(EventMessageType::event_packet, Serialisation::ros1);
  std::vector<Event> events;
  const auto words = [](std::initializer_list<std::uint32_t> list) {
    return little_endian_words<std::uint32_t>(list);
  };
  EXPECT_FALSE(decoder.decode(
      packet("evt2", words({1u << 28, 0x80000002, 1u << 28 | 5u << 22 | 300u << 11 | 200, 0xa0000000})),
      events));
  EXPECT_FALSE(decoder.decode(packet("evt2", words({6u << 22 | 7u << 11 | 8})), events));
  EXPECT_THAT(events,
              testing::ElementsAre(Event{2 * 64 + 5, 300, 200, true, 0}, Event{2 * 64 + 6, 7, 8, false, 0}));
  EXPECT_EQ(decoder.packets().counts().events_without_time, 1);
  EXPECT_EQ(decoder.packets().counts().triggers, 1);
  EXPECT_EQ(decoder.encoding(), "evt2");
  EXPECT_FALSE(decoder.decode(packet("evt2", words({0x30000000, 7u << 22 | 7u << 11 | 8})), events));
  EXPECT_EQ(events.size(), 3u) << "that behind a word of an undefined type is there";
  EXPECT_FALSE(decoder.decode(
      packet("evt3", little_endian_words<std::uint16_t>({0x8000, 1, 0x2001, 0x9abc, 0x2002, 0x1000, 0xb000})),
      events));
  EXPECT_EQ(events.size(), 5u);
  for (const std::size_t type : {1, 3, 9, 11})
    EXPECT_EQ(decoder.packets().counts().undefined[type], 1) << type;
  EXPECT_TRUE(decoder.decode(packet("evt2", "123"), events)) << "part of a word";
}

// ---- what arrays are called, and the unit of their times -----------------------------------------

/// An array of NumPy's format, version 1.
std::string array_bytes(const std::string& descr, bool fortran, const std::string& shape,
                        const std::string& data) {
  const std::string header = "{'descr': " + descr + ", 'fortran_order': " + (fortran ? "True" : "False") +
                             ", 'shape': " + shape + ", }\n";
  return "\x93NUMPY" + std::string("\1\0", 2) + little_endian(static_cast<std::uint16_t>(header.size())) +
         header + data;
}

std::string doubles(std::initializer_list<double> values) {
  std::string bytes;
  for (const double value : values) bytes += little_endian(std::bit_cast<std::uint64_t>(value));
  return bytes;
}

const std::vector<Event> two_rows = {{1'500'000, 3, 4, true, 0}, {1'500'125, 303, 239, false, 0}};

TEST(NumpyArrays, InFortranOrderAreReadLikeThoseInCOrder) {
  const TempFolder folder;
  const auto path = folder.write(
      "a.npy", array_bytes("'<f8'", true, "(2, 4)", doubles({1.5, 1.500125, 3, 303, 4, 239, 1, -1})));
  EXPECT_EQ(read_file(path), two_rows);
  EXPECT_EQ(read_all(*open_event_file(path), 1), two_rows);
  EXPECT_EQ(read_file(folder.write("a.npy", array_bytes("'<f8'", false, "(2, 4)",
                                                        doubles({1.5, 3, 4, 1, 1.500125, 303, 239, -1})))),
            two_rows);
}

TEST(NumpyArrays, MayCallThePolarityOnAndNameTheUnitOfTheTime) {
  const TempFolder folder;
  std::string bytes;
  for (const Event& e : two_rows)
    bytes += little_endian(e.t_us * 1000) + little_endian(e.x) + little_endian(e.y) + (e.on ? '\1' : '\0');
  const auto read = [&](const std::string& time, const EventReadOptions& options = {}) {
    return read_file(
        folder.write("a.npy", array_bytes("[" + time + ", ('x', '<u2'), ('y', '<u2'), ('on', '|b1')]", false,
                                          "(2,)", bytes)),
        options);
  };
  EXPECT_EQ(read("('t_ns', '<i8')"), two_rows);
  EXPECT_EQ(read("('t', '<M8[ns]')"), two_rows);
  EXPECT_EQ(read("('t', '<m8[ns]')"), two_rows);
  EventReadOptions options;
  options.time_unit = TimeUnit::ns;
  EXPECT_EQ(read("('t', '<u8')", options), two_rows);
  EXPECT_EQ(read("('t', '<u8')")[0].t_us, 1'500'000'000);
}

TEST(NumpyArrays, WhoseTimesCanHardlyBeInUsOrSAreRefusedWithTheOption) {
  const TempFolder folder;
  const auto message = [&](const std::string& descr, const std::string& data) -> std::string {
    const std::string zip = stored_zip({{"t.npy", array_bytes(descr, false, "(1,)", data)},
                                        {"x.npy", array_bytes("'|u1'", false, "(1,)", "\1")},
                                        {"y.npy", array_bytes("'|u1'", false, "(1,)", "\1")},
                                        {"p.npy", array_bytes("'|u1'", false, "(1,)", "\1")}});
    try {
      return "read " + std::to_string(read_file(folder.write("a.npz", zip)).at(0).t_us);
    } catch (const InputError& error) {
      return error.what();
    }
  };
  EXPECT_EQ(message("'<i8'", little_endian<std::int64_t>(1'600'000'000'000'000)), "read 1600000000000000");
  EXPECT_THAT(message("'<i8'", little_endian<std::int64_t>(1'600'000'000'000'000'000)),
              AllOf(HasSubstr("row 0: found t = 1600000000000000000"), HasSubstr("--time-unit")));
  EXPECT_EQ(message("'<f8'", doubles({1.5})), "read 1500000");
  EXPECT_THAT(message("'<f8'", doubles({18164.0})), HasSubstr("--time-unit"));
  EXPECT_THAT(message("'<f8'", doubles({1.6e15})), HasSubstr("--time-unit"));
  EXPECT_THAT(message("'<f8'", doubles({std::numeric_limits<double>::quiet_NaN()})),
              HasSubstr("found t = no number"));
}

// ---- ROS 2's bags --------------------------------------------------------------------------------

TEST(Ros2Bag, IsAFolderWithMetadataAndOneFile) {
  const TempFolder folder;
  const SmallFile mcap = small_file("events.mcap"), sqlite = small_file("events.db3");
  folder.write("metadata.yaml", "rosbag2_bagfile_information:\n  version: 5\n");
  EXPECT_THAT([&] { (void)open_event_file(folder / ""); },
              ThrowsMessage<InputError>(AllOf(HasSubstr("a folder of metadata.yaml"), HasSubstr(".db3"))));
  for (const SmallFile& file : {mcap, sqlite}) {
    folder.write(file.name, file.bytes());
    EXPECT_EQ(read_file(folder / ""), file.events()) << file.name;
    std::filesystem::remove(folder / file.name);
  }
  folder.write("a_0.db3", sqlite.bytes());
  folder.write("a_1.db3", sqlite.bytes());
  EXPECT_THAT([&] { (void)open_event_file(folder / ""); },
              ThrowsMessage<InputError>(HasSubstr("a bag of a_0.db3, a_1.db3, expected one")));
}

TEST(Ros2Bag, SaysItsTypeSkipsOtherTopicsAndLeavesNothingBesideIt) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "bag #1?%41");
  const auto path = folder.write("bag #1?%41/events.db3", small_file("events.db3").bytes());
  const auto reader = open_event_file(path);
  EXPECT_EQ(read_all(*reader), small_file("events.db3").events());
  EXPECT_EQ(reader->format(), "ROS 2 bag event_camera_msgs/msg/EventPacket (mono)");
  EXPECT_EQ(reader->skipped(), "1 messages of /imu (sensor_msgs/msg/Imu)");
  EXPECT_EQ(reader->image_size(), image);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(path.parent_path()), {}), 1);
}

TEST(Ros2Bag, WrittenAsTheFirstFileOfAFolderOfItsNameMakesTheFolderABag) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "it's");
  const auto path = folder / "it's/it's_0.db3";
  write_events(path, {{1'500'000, 3, 4, true, 0}, {1'520'000, 5, 6, false, 1}, {1'530'001, 7, 8, true, 1}},
               2);
  EXPECT_EQ(bytes_of(folder / "it's/metadata.yaml"),
            "rosbag2_bagfile_information:\n"
            "  version: 5\n"
            "  storage_identifier: sqlite3\n"
            "  duration:\n"
            "    nanoseconds: 30001000\n"
            "  starting_time:\n"
            "    nanoseconds_since_epoch: 1500000000\n"
            "  message_count: 3\n"
            "  topics_with_message_count:\n"
            "    - topic_metadata:\n"
            "        name: /event_camera/left/events\n"
            "        type: event_camera_msgs/msg/EventPacket\n"
            "        serialization_format: cdr\n"
            "        offered_qos_profiles: \"\"\n"
            "      message_count: 1\n"
            "    - topic_metadata:\n"
            "        name: /event_camera/right/events\n"
            "        type: event_camera_msgs/msg/EventPacket\n"
            "        serialization_format: cdr\n"
            "        offered_qos_profiles: \"\"\n"
            "      message_count: 2\n"
            "  compression_format: \"\"\n"
            "  compression_mode: \"\"\n"
            "  relative_file_paths:\n"
            "    - 'it''s_0.db3'\n"
            "  files:\n"
            "    - path: 'it''s_0.db3'\n"
            "      duration:\n"
            "        nanoseconds: 30001000\n"
            "      starting_time:\n"
            "        nanoseconds_since_epoch: 1500000000\n"
            "      message_count: 3\n");
  EXPECT_EQ(read_file(folder / "it's"), read_file(path));
  EXPECT_EQ(read_file(path).size(), 3u);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(path.parent_path()), {}), 2);
}

TEST(Ros2Bag, HasItsNameOnlyWhenItIsWhole) {
  const TempFolder folder;
  std::filesystem::create_directory(folder / "bag");
  const std::vector<Event> events = scattered_events(image, 1000, 20'000, 40);
  {
    const auto writer = create_event_file(folder / "bag/bag_0.db3", image);
    writer->write(events);
    EXPECT_FALSE(std::filesystem::exists(folder / "bag/bag_0.db3"));
    EXPECT_FALSE(std::filesystem::exists(folder / "bag/metadata.yaml"));
    EXPECT_THROW(writer->write(std::vector<Event>{{-1, 0, 0, true, 0}}), InputError);
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder / "bag"));
  {
    const auto writer = create_event_file(folder / "events.db3", image);
    writer->write(events);
    writer->sync();
    EXPECT_EQ(read_file(folder / "events.db3.part"), events);
    writer->write(events);
  }
  EXPECT_EQ(read_file(folder / "events.db3.part"), events);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder / ""), {}), 2);
}

TEST(Ros2Bag, OnAFullDiskSaysSo) {
  const TempFolder folder;
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit full{50'000, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &full);
  EXPECT_THROW(write_events(folder / "a.db3", scattered_events(image, 0, 100'000, 5)), DiskFull);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_TRUE(std::filesystem::is_empty(folder / ""));
}

TEST(Ros2Bag, ThatIsAnotherSqliteFileIsRefused) {
  const TempFolder folder;
  const std::string bytes =
      replaced(small_file("events.db3").bytes(), "CREATE TABLE topics", "CREATE TABLE topicz");
  EXPECT_THROW((void)open_event_file(folder.write("a.db3", bytes)), InputError);
}

}  // namespace
}  // namespace saccade
