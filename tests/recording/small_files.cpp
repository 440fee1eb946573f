#include "tests/recording/small_files.h"

#include <lz4frame.h>
#include <zstd.h>

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

}  // namespace

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
        {"\x07" + little_endian_words<std::uint16_t>({319, 239}), {{3, 319, 239, true, 0}}},
        {"\xff", {}},
        {"\xfe", {}},
        {"\x02" + little_endian_words<std::uint16_t>({1, 2}), {{131, 1, 2, false, 0}}}}});
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
  return files;
}

}  // namespace saccade
