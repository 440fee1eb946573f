#include "tests/recording/small_files.h"

#include <SQLiteCpp/SQLiteCpp.h>
#include <lz4frame.h>
#include <sqlite3.h>
#include <zstd.h>

#include <bit>

namespace saccade {
namespace {

std::string aedat1_record(std::uint16_t address, std::uint32_t stamp) {
  return big_endian(address) + big_endian(stamp);
}
std::string aedat2_record(std::uint32_t address, std::int32_t stamp) {
  return big_endian(address) + big_endian(stamp);
}

/// The header of a packet of AEDAT 3.1.
std::string aedat3_head(std::int16_t type, std::int16_t source, std::int32_t size, std::int32_t wraps,
                        std::int32_t events) {
  return little_endian(type) + little_endian(source) +
         little_endian_words<std::int32_t>({size, 4, wraps, events, events, events});
}

std::string text(std::string_view bytes) { return std::string(bytes); }

/// AEDAT 4's numbers of what packets are compressed with.
enum Compression { none = 0, lz4 = 1, zstd = 3 };

/// A packet of AEDAT 4: stream, size, and a size-prefixed table of events that begins at byte 32.
std::string aedat4_packet(int compression, const std::vector<Event>& events) {
  std::string table = little_endian<std::uint32_t>(16) + "EVTS" + std::string(2, '\0') +
                      little_endian_words<std::uint16_t>({6, 8, 4}) +
                      little_endian_words<std::uint32_t>({6, 4, static_cast<std::uint32_t>(events.size())});
  for (const Event& event : events) {
    table += little_endian(event.t_us) + little_endian(event.x) + little_endian(event.y);
    table += std::string(1, event.on ? '\1' : '\0') + std::string(3, '\0');
  }
  table = little_endian(static_cast<std::uint32_t>(table.size())) + table;
  std::string packed = table;
  if (compression == lz4) {
    packed.resize(LZ4F_compressFrameBound(table.size(), nullptr));
    packed.resize(LZ4F_compressFrame(packed.data(), packed.size(), table.data(), table.size(), nullptr));
  } else if (compression == zstd) {
    packed.resize(ZSTD_compressBound(table.size()));
    packed.resize(ZSTD_compress(packed.data(), packed.size(), table.data(), table.size(), 1));
  }
  return little_endian(0) + little_endian(static_cast<std::int32_t>(packed.size())) + packed;
}

std::string aedat4_header(int compression, std::int64_t table_place) {
  const std::string xml =
      "<dv version=\"2.0\"><node name=\"outInfo\" path=\"/outInfo/\"><node name=\"0\" path=\"/outInfo/0/\">"
      "<attr key=\"typeIdentifier\" type=\"string\">EVTS</attr><node name=\"info\" path=\"/outInfo/0/info/\">"
      "<attr key=\"sizeX\" type=\"int\">20</attr><attr key=\"sizeY\" type=\"int\">10</attr></node></node>"
      "</node></dv>";
  const std::string table = little_endian<std::uint32_t>(24) + "IOHE" + std::string(6, '\0') +
                            little_endian_words<std::uint16_t>({10, 20, 4, 12, 8}) + little_endian(10) +
                            little_endian(compression) + little_endian(12) + little_endian(table_place) +
                            little_endian(static_cast<std::uint32_t>(xml.size())) + xml + '\0';
  return "#!AER-DAT4.0\r\n" + little_endian(static_cast<std::uint32_t>(table.size())) + table;
}

SmallFile aedat4(const std::string& name, Compression compression, bool with_table) {
  const std::vector<Event> one = {{1605537493718345, 3, 4, true, 0}, {1605537493718350, 19, 0, false, 0}};
  const std::vector<Event> two = {{1605537493718360, 0, 9, true, 0}};
  const std::string imu = little_endian(2) + little_endian(3) + "imu";
  std::vector<SmallFile::Piece> pieces = {{aedat4_header(compression, -1), {}, !with_table},
                                          {aedat4_packet(compression, one), one, !with_table},
                                          {imu, {}, !with_table},
                                          {aedat4_packet(compression, two), two, true}};
  if (with_table) {
    std::size_t end = 0;
    for (const auto& piece : pieces) end += piece.bytes.size();
    pieces[0].bytes = aedat4_header(compression, static_cast<std::int64_t>(end));
  }
  return {name, pieces};
}

/// CRC-32 as in ZIP and MCAP, bit by bit.
std::uint32_t crc_of(std::string_view bytes) {
  std::uint32_t crc = 0xffffffff;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1) != 0 ? 0xedb88320 : 0);
  }
  return ~crc;
}

/// An array of NumPy's format, version 1.
std::string npy(const std::string& descr, const std::string& shape, const std::string& data) {
  const std::string header = "{'descr': " + descr + ", 'fortran_order': False, 'shape': " + shape + ", }\n";
  return "\x93NUMPY" + std::string("\1\0", 2) + little_endian(static_cast<std::uint16_t>(header.size())) +
         header + data;
}

/// A ZIP file whose members are stored, in the pieces that its members are. The last one has the events.
SmallFile npz(const std::string& name, const std::vector<std::pair<std::string, std::string>>& members,
              const std::vector<Event>& events) {
  SmallFile file{name, {}};
  std::string directory;
  std::size_t place = 0;
  for (const auto& [member, data] : members) {
    const std::string sizes = little_endian(crc_of(data)) +
                              little_endian(static_cast<std::uint32_t>(data.size())) +
                              little_endian(static_cast<std::uint32_t>(data.size())) +
                              little_endian(static_cast<std::uint16_t>(member.size())) + std::string(2, '\0');
    const std::string common = little_endian_words<std::uint16_t>({20, 0, 0, 0, 33}) + sizes;
    file.pieces.push_back({"PK\3\4" + common + member + data, {}, false});
    directory += "PK\1\2" + little_endian<std::uint16_t>(20) + common + std::string(10, '\0') +
                 little_endian(static_cast<std::uint32_t>(place)) + member;
    place += file.pieces.back().bytes.size();
  }
  const auto count = static_cast<std::uint16_t>(members.size());
  file.pieces.back().events = events;
  file.pieces.push_back({directory + "PK\5\6" + little_endian_words<std::uint16_t>({0, 0, count, count}) +
                             little_endian(static_cast<std::uint32_t>(directory.size())) +
                             little_endian(static_cast<std::uint32_t>(place)) + std::string(2, '\0'),
                         {},
                         false});
  return file;
}

std::string with_length(std::string_view text) {
  return little_endian(static_cast<std::uint32_t>(text.size())) + std::string(text);
}

/// A record of a bag of ROS 1.
std::string bag_record(const std::vector<std::string>& fields, const std::string& data) {
  std::string header;
  for (const std::string& field : fields) header += with_length(field);
  return with_length(header) + with_length(data);
}

std::string bag_op(char op) { return std::string("op=") + op; }
std::string bag_conn(std::uint32_t conn) { return "conn=" + little_endian(conn); }

/// A dvs_msgs/EventArray in ROS 1's serialisation.
std::string event_array(const std::vector<Event>& events) {
  std::string bytes =
      little_endian_words<std::uint32_t>({7, 1, 2}) + with_length("") +
      little_endian_words<std::uint32_t>({240, 304, static_cast<std::uint32_t>(events.size())});
  for (const Event& event : events) {
    bytes += little_endian(event.x) + little_endian(event.y);
    bytes += little_endian(static_cast<std::uint32_t>(event.t_us / 1'000'000));
    bytes += little_endian(static_cast<std::uint32_t>(event.t_us % 1'000'000 * 1000));
    bytes += event.on ? '\1' : '\0';
  }
  return bytes;
}

/// A bag whose recorder was killed, without an index: a chunk of a connection and messages on it.
SmallFile bag() {
  const std::vector<Event> one = {{1'500'000'000'000'123, 3, 4, true, 0},
                                  {1'500'000'000'000'125, 303, 0, false, 0}};
  const std::vector<Event> two = {{1'500'000'000'000'130, 0, 239, true, 1}};
  const auto connection = [](std::uint32_t conn, const std::string& topic, const std::string& type) {
    return bag_record({bag_op(7), bag_conn(conn), "topic=" + topic},
                      with_length("topic=" + topic) + with_length("type=" + type) + with_length("md5sum=*"));
  };
  const auto message = [](std::uint32_t conn, const std::string& data) {
    return bag_record(
        {bag_op(2), bag_conn(conn), "time=" + little_endian_words<std::uint32_t>({1500000000, 200000})},
        data);
  };
  const auto chunk = [](const std::string& records) {
    return bag_record(
        {bag_op(5), "compression=none", "size=" + little_endian(static_cast<std::uint32_t>(records.size()))},
        records);
  };
  return {
      "events.bag",
      {{"#ROSBAG V2.0\n", {}},
       {bag_record({bag_op(3), "index_pos=" + little_endian<std::uint64_t>(0),
                    "conn_count=" + little_endian(0), "chunk_count=" + little_endian(0)},
                   std::string(20, ' ')),
        {}},
       {chunk(connection(0, "/left/events", "dvs_msgs/EventArray") +
              connection(1, "/imu", "sensor_msgs/Imu") + message(1, "imu") + message(0, event_array(one))),
        one},
       {bag_record({bag_op(4), "ver=" + little_endian(1), bag_conn(0), "count=" + little_endian(0)}, ""), {}},
       {chunk(connection(2, "/right/events", "dvs_msgs/EventArray") + message(2, event_array(two))), two}}};
}

std::string mcap_record(char op, const std::string& bytes) {
  return std::string(1, op) + little_endian(static_cast<std::uint64_t>(bytes.size())) + bytes;
}

/// An event_camera_msgs/EventPacket in CDR; `frame` is chosen so that all members lie at multiples of their sizes.
std::string event_packet(std::uint64_t time_base_ns, const std::string& encoding, const std::string& events) {
  // In front: serialisation, stamp, frame of 3 letters and NUL. Then height, width, seq, time_base.
  std::string bytes = std::string("\0\1\0\0", 4) + little_endian_words<std::uint32_t>({1, 2, 4}) +
                      std::string("cam\0", 4) + little_endian_words<std::uint32_t>({240, 304}) +
                      little_endian<std::uint64_t>(9) + little_endian(time_base_ns);
  bytes += with_length(encoding + '\0') + '\0';
  while ((bytes.size() - 4) % 4 != 0) bytes += '\0';
  return bytes + with_length(events);
}

/// A bag of ROS 2 in SQLite; cut off it cannot be read at all.
SmallFile ros2_bag() {
  const std::vector<Event> events = {{1'500'000'000'000'123, 3, 4, true, 0},
                                     {1'500'000'000'000'125, 303, 0, false, 0}};
  std::string mono;
  for (const Event& e : events)
    mono += little_endian(static_cast<std::uint64_t>(e.on) << 63 | static_cast<std::uint64_t>(e.y) << 48 |
                          static_cast<std::uint64_t>(e.x) << 32 |
                          static_cast<std::uint64_t>(e.t_us - events[0].t_us) * 1000);
  const std::string message = event_packet(1'500'000'000'000'123'000, "mono", mono);
  SQLite::Database database(":memory:", SQLite::OPEN_READWRITE | SQLite::OPEN_CREATE);
  database.exec("PRAGMA page_size = 512");
  database.exec(
      "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT)");
  database.exec(
      "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB)");
  database.exec("INSERT INTO topics VALUES(1, '/imu', 'sensor_msgs/msg/Imu', 'cdr')");
  database.exec("INSERT INTO topics VALUES(2, '/events', 'event_camera_msgs/msg/EventPacket', 'cdr')");
  database.exec("INSERT INTO messages VALUES(1, 1, 1500000000000200000, x'00')");
  SQLite::Statement insert(database, "INSERT INTO messages VALUES(2, 2, 1500000000000200000, ?)");
  insert.bind(1, message.data(), static_cast<int>(message.size()));
  insert.exec();
  sqlite3_int64 size = 0;
  unsigned char* const bytes = sqlite3_serialize(database.getHandle(), "main", &size, 0);
  SmallFile file{
      "events.db3",
      {{std::string(reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(size)), events}}};
  sqlite3_free(bytes);
  return file;
}

SmallFile mcap() {
  const auto mono = [](std::uint32_t after_ns, const Event& event) {
    return little_endian(static_cast<std::uint64_t>(event.on) << 63 |
                         static_cast<std::uint64_t>(event.y) << 48 |
                         static_cast<std::uint64_t>(event.x) << 32 | after_ns);
  };
  const std::vector<Event> one = {{1'500'000'000'000'123, 3, 4, true, 0},
                                  {1'500'000'000'000'125, 303, 0, false, 0}};
  const std::vector<Event> two = {{1'500'000'000'000'130, 0, 239, true, 0},
                                  {1'500'000'000'000'129, 7, 8, false, 0}};
  const std::vector<Event> three = {{(0xb2d << 12) + 1, 100, 200, true, 0}};
  const std::string schema =
      mcap_record(3, little_endian<std::uint16_t>(1) + with_length("event_camera_msgs/msg/EventPacket") +
                         with_length("ros2msg") + with_length(""));
  const std::string channel =
      mcap_record(4, little_endian_words<std::uint16_t>({5, 1}) + with_length("/events") +
                         with_length("cdr") + with_length(""));
  const auto message = [](const std::string& data) {
    return mcap_record(5, little_endian<std::uint16_t>(5) + little_endian(0) +
                              little_endian_words<std::uint64_t>({1'500'000'000'000'200'000, 0}) + data);
  };
  const auto chunk = [](const std::string& records) {
    std::string packed(ZSTD_compressBound(records.size()), '\0');
    packed.resize(ZSTD_compress(packed.data(), packed.size(), records.data(), records.size(), 1));
    return mcap_record(6, little_endian_words<std::uint64_t>({0, 0, records.size()}) +
                              little_endian(crc_of(records)) + with_length("zstd") +
                              little_endian(static_cast<std::uint64_t>(packed.size())) + packed);
  };
  const std::string evt3 =
      little_endian_words<std::uint16_t>({0x8b2d, 0x9abc, 0x6001, 200, 0x2000 | 0x800 | 100});
  return {
      "events.mcap",
      {{text("\x89MCAP0\r\n"), {}, false},
       {mcap_record(1, with_length("ros2") + with_length("test")), {}, false},
       {schema + channel, {}, false},
       {message(event_packet(1'500'000'000'000'123'000, "mono", mono(0, one[0]) + mono(2000, one[1]))), one,
        false},
       {chunk(message(event_packet(1'500'000'000'000'129'000, "mono", mono(1000, two[0]) + mono(0, two[1])))),
        two, false},
       {message(event_packet(0, "evt3", evt3)), three, false},
       {mcap_record(15, little_endian(0)), {}, false},
       {mcap_record(2, std::string(20, '\0')), {}, false},
       {text("\x89MCAP0\r\n"), {}, true}}};
}

}  // namespace

std::string stored_zip(const std::vector<std::pair<std::string, std::string>>& members) {
  return npz("", members, {}).bytes();
}

std::vector<SmallFile> small_files() {
  std::vector<SmallFile> files;
  files.push_back({"dvs128_1.aedat",
                   {{"#!AER-DAT1.0\r\n", {}},
                    {"# jAER\r\n", {}},
                    {aedat1_record(51 << 8 | 46 << 1, 5), {{5, 81, 76, true, 0}}},
                    {aedat1_record(0x8001, 6), {}},
                    {aedat1_record(0x7fff, 0xffffffff), {{4294967295, 0, 0, false, 0}}}}});
  files.push_back({"dvs128_2.aedat",
                   {{"#!AER-DAT2.0\r\n", {}},
                    {"# AEChip: DVS128\r\n", {}},
                    {aedat2_record(51 << 8 | 46 << 1, -7), {{-7, 81, 76, true, 0}}},
                    {aedat2_record(0x8001, 6), {}},
                    {aedat2_record(0x7fff, 8), {{8, 0, 0, false, 0}}}}});
  files.push_back({"davis.aedat",
                   {{"#!AER-DAT2.0\r\n", {}},
                    {"# AEChip: DAVIS 304x240\r\n", {}},
                    {aedat2_record(239u << 22 | 303u << 12 | 1u << 11, 8), {{8, 0, 0, true, 0}}},
                    {aedat2_record(1u << 31, 8), {}},
                    {aedat2_record(0, 9), {{9, 303, 239, false, 0}}}}});
  files.push_back({"dvs640.aedat",
                   {{"#!AER-DAT2.0\r\n", {}},
                    {"# AEChip: DVS640\r\n", {}},
                    {aedat2_record(479u << 11 | 639u << 1 | 1u, 8), {{8, 0, 0, true, 0}}},
                    {aedat2_record(1u << 31, 8), {}},
                    {aedat2_record(0, 9), {{9, 639, 479, false, 0}}}}});
  files.push_back(
      {"cer.aedat",
       {{"#!AER-DAT3.1\r\n#Format: RAW\r\n#Source 1: DAVIS346\r\n#!END-HEADER\r\n", {}},
        {aedat3_head(1, 1, 8, 0, 2), {}, false},
        {little_endian_words<std::uint32_t>({345u << 17 | 259u << 2 | 3u, 7}),
         {{7, 345, 259, true, 0}},
         false},
        {little_endian_words<std::uint32_t>({1u << 17 | 2u << 2 | 1u, 0x7fffffff}),
         {{0x7fffffff, 1, 2, false, 0}}},
        {aedat3_head(3, 1, 5, 0, 2) + "inertial..", {}},
        {aedat3_head(1, 1, 8, 1, 1), {}, false},
        {little_endian_words<std::uint32_t>({1u, 2}), {{(std::int64_t{1} << 31) + 2, 0, 0, false, 0}}}}});
  files.push_back(aedat4("none.aedat4", none, false));
  files.push_back(aedat4("lz4.aedat4", lz4, false));
  files.push_back(aedat4("zstd.aedat4", zstd, true));
  files.push_back({"evt2.raw",
                   {{"% evt 2.0\n", {}},
                    {"% geometry 640x480\n", {}},
                    {"% end\n", {}},
                    {little_endian<std::uint32_t>(8u << 28 | 20592), {}},
                    {little_endian<std::uint32_t>(1u << 28 | 5u << 22 | 237u << 11 | 121u),
                     {{20592 * 64 + 5, 237, 121, true, 0}}},
                    {little_endian<std::uint32_t>(0xau << 28), {}},
                    {little_endian<std::uint32_t>(63u << 22 | 639u << 11 | 479u),
                     {{20592 * 64 + 63, 639, 479, false, 0}}}}});
  const std::uint64_t evt21_time = std::uint64_t{8} << 60 | std::uint64_t{15} << 32;
  const std::uint64_t evt21_pixels = std::uint64_t{1} << 60 | std::uint64_t{40} << 54 |
                                     std::uint64_t{64} << 43 | std::uint64_t{7} << 32 | 1u << 31 | 1u;
  files.push_back({"evt21.raw",
                   {{"% evt 2.1\n", {}},
                    {"% format EVT21;endianness=little;height=480;width=640\n", {}},
                    {"% end\n", {}},
                    {little_endian(evt21_time), {}},
                    {little_endian(std::uint64_t{7} << 60), {}},
                    {little_endian(evt21_pixels), {{1000, 64, 7, true, 0}, {1000, 95, 7, true, 0}}}}});
  const std::int64_t t = 0xb2d << 12;
  files.push_back(
      {"evt3.raw",
       {{"% evt 3.0\n", {}},
        {"% format EVT3;height=720;width=1280\n", {}},
        {"% end\n", {}},
        {little_endian<std::uint16_t>(0x8b2d), {}},
        {little_endian<std::uint16_t>(0x6001), {}},
        {little_endian<std::uint16_t>(200), {}},
        {little_endian<std::uint16_t>(0x2000 | 874), {{t + 1, 874, 200, false, 0}}},
        {little_endian<std::uint16_t>(0x9abc), {}},
        {little_endian<std::uint16_t>(0x3800 | 10), {}},
        {little_endian<std::uint16_t>(0x4803),
         {{t + 1, 10, 200, true, 0}, {t + 1, 11, 200, true, 0}, {t + 1, 21, 200, true, 0}}},
        {little_endian<std::uint16_t>(0x5f81), {{t + 1, 22, 200, true, 0}, {t + 1, 29, 200, true, 0}}}}});
  files.push_back(
      {"atis.dat",
       {{"% Data file containing CD events.\n% Version 2\n% Width 304\n% Height 240\n", {}, false},
        {text("\x0c\x08"), {}},
        {little_endian_words<std::uint32_t>({66, 35u << 14 | 42u}), {{66, 42, 35, false, 0}}},
        {little_endian_words<std::uint32_t>({67, 1u << 28 | 239u << 14 | 303u}),
         {{67, 303, 239, true, 0}}}}});
  files.push_back(
      {"dvs.es",
       {{"Event Stream" + std::string({2, 0, 0, 1}) + little_endian_words<std::uint16_t>({320, 240}), {}},
        {"\x07" + little_endian_words<std::uint16_t>({319, 239}), {{3, 319, 0, true, 0}}},
        {"\xff", {}},
        {"\xfe", {}},
        {"\x02" + little_endian_words<std::uint16_t>({1, 2}), {{131, 1, 237, false, 0}}}}});
  files.push_back({"digit.bin",
                   {{"\x03\x04" + text("\x80\x03\xe8"), {{1000, 3, 4, true, 0}}},
                    {std::string({0, '\xf0', 0, 4, 0}), {}},
                    {std::string({33, 2, 0, 5, '\xdc'}), {{8192 + 1500, 33, 2, false, 0}}}}});
  files.push_back({"events.txt",
                   {{"10 3 4 1", {{10, 3, 4, true, 0}}},
                    {"\n", {}},
                    {"-12,65535,0,0", {{-12, 65535, 0, false, 0}}},
                    {"\n", {}}}});
  // Two words of event-driven, 1 x 2 off on the right and 303 x 239 on on the left.
  const std::uint32_t off = 1u << 22 | 2u << 12 | 1u << 1 | 1u;
  const std::uint32_t on = 239u << 12 | 303u << 1;
  files.push_back({"lists.log",
                   {{"1 1.5 AE (100 " + std::to_string(on), {}, false},
                    {" 125 " + std::to_string(off), {{8, 303, 239, true, 0}}, false},
                    {")", {{10, 1, 2, false, 1}}},
                    {"\n", {}},
                    {"2 1.6 FLOW (7 8 9)", {}},
                    {"\n", {}}}});
  // A stamp that is no address shows that the words have stamps.
  const std::int64_t ticks = 0x7f030201;
  const auto packet = [&](std::uint32_t more) {
    std::string bytes;
    for (const char c :
         little_endian_words<std::uint32_t>({0x7f030201 + more, on, 0x7f030201 + more + 25, off}))
      bytes += c == '\0' ? std::string("\\0") : c == '\n' ? std::string("\\n") : std::string(1, c);
    return "AE 2 \"" + bytes + "\"";
  };
  const auto us = [](std::int64_t count) { return (count * 80 + 500) / 1000; };
  files.push_back(
      {"packets.log",
       {{"0 170.5 " + packet(0), {{us(ticks), 303, 239, true, 0}, {us(ticks + 25), 1, 2, false, 1}}},
        {"\n", {}},
        {"1 170.6 " + packet(50), {{us(ticks + 50), 303, 239, true, 0}, {us(ticks + 75), 1, 2, false, 1}}},
        {"\n", {}}}});
  files.push_back({"binaryevents.log",
                   {{little_endian_words<std::uint32_t>({100, on}), {{8, 303, 239, true, 0}}},
                    {little_endian_words<std::uint32_t>({125, off}), {{10, 1, 2, false, 1}}}}});
  const std::vector<Event> of_records = {{5, 3, 4, true, 0}, {-6, 303, 239, false, 0}};
  std::string records;
  for (const Event& event : of_records) {
    records += little_endian(event.t_us) + little_endian(event.x) + little_endian(event.y);
    records += event.on ? '\1' : '\0';
  }
  const std::string record_array =
      npy("[('t', '<i8'), ('x', '<u2'), ('y', '<i2'), ('p', '|b1')]", "(2,)", records);
  files.push_back({"records.npy", {{record_array, of_records}}});
  files.push_back(
      npz("records.npz",
          {{"sensor_size.npy", npy("'<i4'", "(3,)", little_endian_words<std::int32_t>({304, 240, 2}))},
           {"events.npy", record_array}},
          of_records));
  // Times in s, polarities -1 and 1.
  files.push_back(
      npz("columns.npz",
          {{"x.npy", npy("'>u2'", "(2,)", big_endian<std::uint16_t>(9) + big_endian<std::uint16_t>(258))},
           {"t.npy", npy("'<f8'", "(2,)",
                         little_endian(std::bit_cast<std::uint64_t>(0.25)) +
                             little_endian(std::bit_cast<std::uint64_t>(-1.0000001)))},
           {"p.npy", npy("'|i1'", "(2,)", "\xff\x01")},
           {"y.npy", npy("'<f4'", "(2,)",
                         little_endian(std::bit_cast<std::uint32_t>(7.0F)) +
                             little_endian(std::bit_cast<std::uint32_t>(8.0F)))}},
          {{250'000, 9, 7, false, 0}, {-1'000'000, 258, 8, true, 0}}));
  files.push_back(bag());
  files.push_back(mcap());
  files.push_back(ros2_bag());
  files.push_back(npz("text.zip", {{"events.txt", "x y p t\n3 4 1 10\n65535 0 0 -12\n"}},
                      {{10, 3, 4, true, 0}, {-12, 65535, 0, false, 0}}));
  // A field with a title, and nanoseconds.
  std::string titled;
  for (const Event& event : of_records)
    titled +=
        big_endian(event.t_us * 1000) + big_endian(event.x) + big_endian(event.y) + (event.on ? '\1' : '\0');
  files.push_back(
      {"titled.npy",
       {{npy("[('t_ns', '>i8'), ('x', '>u2'), ('y', '>u2'), (('p', 'on'), '|b1')]", "(2,)", titled),
         of_records}}});
  return files;
}

}  // namespace saccade
