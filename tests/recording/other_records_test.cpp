// What recordings hold besides events: frames, inertial readings and triggers, from files written by hand.
#include "recording/other_records.h"

#include <cstring>

#include "core/error.h"
#include "recording/conversion.h"
#include "recording/davis_samples.h"
#include "recording/evt_counts.h"
#include "recording/format_registry.h"
#include "recording/message_cursor.h"
#include "recording/sensor_message.h"
#include "tests/recording/read_events.h"
#include "tests/recording/small_files.h"

namespace saccade {
namespace {

using testing::HasSubstr;

/// Keeps everything that it wants.
class Kept final : public OtherRecords {
 public:
  struct Frame {
    RecordedFrame record;
    std::string bytes, source;
    /// Channel 0 of a pixel of 16 or 8 bits.
    [[nodiscard]] int at(int x, int y) const {
      const std::size_t pixel = static_cast<std::size_t>(y * record.width + x) *
                                static_cast<std::size_t>(record.channels * record.bits / 8);
      std::uint16_t value = 0;
      std::memcpy(&value, bytes.data() + pixel, static_cast<std::size_t>(record.bits / 8));
      return value;
    }
  };

  bool wants_frames() const override { return wants; }
  bool wants_inertial() const override { return wants; }
  bool wants_triggers() const override { return wants; }
  void add(const RecordedFrame& frame) override {
    frames.push_back({frame,
                      std::string(reinterpret_cast<const char*>(frame.pixels.data()), frame.pixels.size()) +
                          std::string(frame.encoded),
                      std::string(frame.source)});
  }
  void add(const InertialReading& reading) override { readings.push_back(reading); }
  void add(const RecordedTrigger& trigger) override {
    triggers.push_back(std::to_string(trigger.t_us) + " " + std::to_string(trigger.channel) + " " +
                       std::string(text_of(trigger.kind)) + " " + std::string(trigger.source));
  }

  bool wants = true;
  std::vector<Frame> frames;
  std::vector<InertialReading> readings;
  std::vector<std::string> triggers;
};

/// Reads a file; returns what its reader skipped.
std::string read_with(const std::filesystem::path& path, Kept& kept) {
  EventReadOptions options;
  options.others = &kept;
  const auto reader = open_event_file(path, options);
  read_all(*reader);
  return reader->skipped();
}

// AEDAT 2.0 of a DAVIS240.

std::string record(std::uint32_t address, std::uint32_t stamp) {
  return big_endian(address) + big_endian(stamp);
}
std::uint32_t frame_sample(std::uint32_t x, std::uint32_t y, std::uint32_t cycle, std::uint32_t value) {
  return 1u << 31 | y << 22 | x << 12 | cycle << 10 | value;
}
/// The converted values: brighter to the right and to the bottom of the image.
std::uint32_t brightness(std::uint32_t x, std::uint32_t y_from_bottom) {
  return x + 2 * (179 - y_from_bottom);
}
std::string davis_frame(std::uint32_t stamp) {
  std::string bytes;
  for (std::uint32_t cycle = 0; cycle < 2; ++cycle)
    for (std::uint32_t x = 0; x < 240; ++x)
      for (std::uint32_t y = 0; y < 180; ++y)
        bytes += record(frame_sample(x, y, cycle, cycle == 0 ? 900 : 900 - brightness(x, y)), stamp + cycle);
  return bytes;
}
const std::string davis_header = "#!AER-DAT2.0\r\n# AEChip: eu.seebetter.ini.chips.davis.DAVIS240C\r\n";

TEST(OtherRecords, AFrameOfADavisIsResetLessSignalFromTheTopLeft) {
  const TempFolder folder;
  std::string content = davis_header + record(1u << 11, 5);
  for (std::uint32_t x = 0; x < 9; ++x) content += record(frame_sample(x, 0, 0, 3), 7);  // breaks off
  const auto path = folder.write("a.aedat", content + davis_frame(100) + davis_frame(200));
  Kept kept;
  EXPECT_EQ(read_with(path, kept), "1 incomplete frames");
  ASSERT_EQ(kept.frames.size(), 2u);
  const Kept::Frame& frame = kept.frames[1];
  EXPECT_EQ(frame.record.t_us, 200);
  EXPECT_EQ(frame.record.begin_us, 200);
  EXPECT_EQ(frame.record.end_us, 201);
  EXPECT_EQ(frame.record.width, 240);
  EXPECT_EQ(frame.record.height, 180);
  EXPECT_EQ(frame.record.bits, 16);
  for (const auto& [x, y] : {std::pair{0, 0}, std::pair{239, 0}, std::pair{3, 179}, std::pair{100, 50}})
    EXPECT_EQ(frame.at(x, y), (x + 2 * y) << 6) << x << ", " << y;
}

TEST(OtherRecords, AFrameOfADavisThatTheEndOfTheFileCutsOffIsIncomplete) {
  const TempFolder folder;
  const std::string frame = davis_frame(100);
  const auto path =
      folder.write("a.aedat", davis_header + record(1u << 11, 5) + frame.substr(0, frame.size() - 8));
  Kept kept;
  EXPECT_EQ(read_with(path, kept), "1 incomplete frames");
  EXPECT_TRUE(kept.frames.empty());
}

/// The seven samples of a reading with these values, at 9 us.
std::string davis_reading(const std::array<std::int16_t, 7>& stored) {
  std::string samples;
  for (std::uint32_t i = 0; i < 7; ++i)
    samples += record(1u << 31 | 3u << 10 | i << 28 |
                          static_cast<std::uint32_t>(static_cast<std::uint16_t>(stored[i])) << 12,
                      9);
  return samples;
}

TEST(OtherRecords, AReadingOfADavisHasJaersRangesAndSaysSo) {
  const TempFolder folder;
  const std::string content =
      davis_header + record(1u << 11, 5) + davis_reading({4096, -4096, 2048, 340, 328, -328, 0});
  const auto path = folder.write("a.aedat", content + record(1u << 10 | 2, 10) + record(1u << 10 | 3, 11) +
                                                record(1u << 10 | 4, 12) + record(1u << 10, 13));
  Kept kept;
  EventReadOptions options;
  options.others = &kept;
  const auto reader = open_event_file(path, options);
  EXPECT_EQ(read_all(*reader).size(), 1u);
  EXPECT_EQ(reader->skipped(), "");
  EXPECT_EQ(reader->guess(), "the inertial unit's range of 8 g and 1000 deg/s, jAER's default");
  ASSERT_EQ(kept.readings.size(), 1u);
  const InertialReading& reading = kept.readings[0];
  EXPECT_EQ(reading.t_us, 9);
  EXPECT_DOUBLE_EQ(reading.acceleration_m_s2[0], 9.80665);
  EXPECT_DOUBLE_EQ(reading.acceleration_m_s2[1], -9.80665);
  EXPECT_DOUBLE_EQ(reading.acceleration_m_s2[2], 9.80665 / 2);
  EXPECT_NEAR(reading.angular_velocity_rad_s[0], 10.0 * 3.14159265358979 / 180.0, 1e-12);
  EXPECT_DOUBLE_EQ(*reading.temperature_deg_c, 36.0);
  EXPECT_EQ(kept.triggers, (std::vector<std::string>{"10 0 falling DAVIS", "11 0 rising DAVIS",
                                                     "12 0 pulse DAVIS", "13 0 unknown DAVIS"}));
}

TEST(OtherRecords, TheHeadersRangesOfADavisAreTaken) {
  const std::string old_g = "#  <entry key=\"ImuAccelScale\" value=\"ImuAccelScaleG4\"/>\r\n";
  const std::string old_deg = "#  <entry key=\"ImuGyroScale\" value=\"GyroFullScaleDegPerSec500\"/>\r\n";
  const std::string new_g = "#  <entry key=\"DAVIS240C.IMU.AccelScale\" value=\"ImuAccelScaleG16\"/>\r\n";
  const std::string other_chip = "#  <entry key=\"DAVIS240B.IMU.AccelScale\" value=\"ImuAccelScaleG2\"/>\r\n";
  const std::string unknown = "#  <entry key=\"ImuGyroScale\" value=\"Fast\"/>\r\n";
  const auto expect = [](const std::string& preferences, double g, double deg_s, const std::string& guess) {
    const TempFolder folder;
    const auto path = folder.write("a.aedat", davis_header + preferences + record(1u << 11, 5) +
                                                  davis_reading({4096, 0, 0, 0, 328, 0, 0}));
    Kept kept;
    EventReadOptions options;
    options.others = &kept;
    const auto reader = open_event_file(path, options);
    EXPECT_EQ(read_all(*reader).size(), 1u);
    EXPECT_EQ(reader->guess(), guess) << preferences;
    ASSERT_EQ(kept.readings.size(), 1u);
    EXPECT_NEAR(kept.readings[0].acceleration_m_s2[0], g * 9.80665, 1e-9) << preferences;
    EXPECT_NEAR(kept.readings[0].angular_velocity_rad_s[0], deg_s * 3.14159265358979 / 180.0, 1e-9)
        << preferences;
  };
  expect(old_g + old_deg, 0.5, 328 / 65.5, "");
  expect(new_g + old_g + old_deg, 2.0, 328 / 65.5, "");
  expect(old_g + new_g + old_deg, 2.0, 328 / 65.5, "");
  expect(other_chip + old_g + unknown, 0.5, 10.0, "the inertial unit's range of 1000 deg/s, jAER's default");
}

TEST(OtherRecords, WhatNobodyWantsIsCountedAsBefore) {
  const TempFolder folder;
  const auto path =
      folder.write("a.aedat", davis_header + record(1u << 11, 5) + record(frame_sample(1, 1, 0, 3), 7) +
                                  record(1u << 31 | 3u << 10, 8) + record(1u << 10, 9));
  Kept kept;
  kept.wants = false;
  EXPECT_EQ(read_with(path, kept), "1 special events, 1 APS samples, 1 IMU values");
  EXPECT_TRUE(kept.triggers.empty());
}

// Words of Prophesee's sensors.

TEST(OtherRecords, TriggersOfSensorWordsHaveTimeChannelAndEdge) {
  const TempFolder folder;
  const std::vector<std::string> expected = {"69 6 rising ", "70 0 falling "};
  const auto check = [&](const std::string& name, const std::string& content) {
    Kept kept;
    EXPECT_EQ(read_with(folder.write(name, content), kept), "1 triggers") << name;  // before the first time
    std::vector<std::string> with_name = expected;
    for (std::string& line : with_name) line += name;
    EXPECT_EQ(kept.triggers, with_name);
  };
  check("evt2.raw", "% evt 2.0\n% end\n" +
                        little_endian_words<std::uint32_t>({0xau << 28, 0x8u << 28 | 1,
                                                            0xau << 28 | 5u << 22 | 6u << 8 | 1,
                                                            0xau << 28 | 6u << 22, 0x1u << 28 | 9u << 22}));
  check("evt21.raw", "% evt 2.1\n% end\n" + little_endian_words<std::uint64_t>(
                                                {0xaull << 60, 0x8ull << 60 | 1ull << 32,
                                                 0xaull << 60 | 5ull << 54 | 6ull << 40 | 1ull << 32,
                                                 0xaull << 60 | 6ull << 54, 0x1ull << 60 | 9ull << 54 | 1}));
  check("evt3.raw",
        "% evt 3.0\n% end\n" + little_endian_words<std::uint16_t>({0xa000, 0x8000, 0x6000 | 69, 0xa601,
                                                                   0x6000 | 70, 0xa000, 0x0007, 0x2003}));
}

// AEDAT 4.0. Tables of flatbuffers: where the fields are stands in front of a table, absent ones have 0.

class FlatBytes {
 public:
  explicit FlatBytes(const std::string& identifier) : bytes_(std::string(4, '\0') + identifier) {}
  /// Adds a table; returns where it is. A field without bytes is absent.
  std::size_t add_table(const std::vector<std::string>& fields) {
    const std::size_t places = bytes_.size();
    std::string there, inline_bytes;
    for (const std::string& field : fields) {
      there += little_endian(static_cast<std::uint16_t>(field.empty() ? 0 : 4 + inline_bytes.size()));
      inline_bytes += field;
    }
    bytes_ += little_endian(static_cast<std::uint16_t>(4 + there.size())) +
              little_endian(static_cast<std::uint16_t>(4 + inline_bytes.size())) + there;
    const std::size_t table = bytes_.size();
    bytes_ += little_endian(static_cast<std::int32_t>(table - places)) + inline_bytes;
    return table;
  }
  std::size_t add_bytes(const std::string& content, std::size_t count) {
    const std::size_t place = bytes_.size();
    bytes_ += little_endian(static_cast<std::uint32_t>(count)) + content;
    return place;
  }
  void point(std::size_t from, std::size_t to) {
    const std::string offset = little_endian(static_cast<std::uint32_t>(to - from));
    bytes_.replace(from, 4, offset);
  }
  [[nodiscard]] std::size_t size() const { return bytes_.size(); }
  [[nodiscard]] std::string packet(int stream) const {
    return little_endian(stream) + little_endian(static_cast<std::int32_t>(4 + bytes_.size())) +
           little_endian(static_cast<std::uint32_t>(bytes_.size())) + bytes_;
  }

 private:
  std::string bytes_;
};

std::string float_bytes(float value) {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, 4);
  return little_endian(bits);
}

std::string frame_packet(std::int8_t format, std::int16_t width, std::int16_t height,
                         const std::string& pixels) {
  FlatBytes flat("FRME");
  const std::size_t table =
      flat.add_table({little_endian<std::int64_t>(1'000), little_endian<std::int64_t>(900),
                      little_endian<std::int64_t>(1'200), little_endian<std::int64_t>(950),
                      little_endian<std::int64_t>(1'100), std::string(1, format), little_endian(width),
                      little_endian(height), little_endian<std::int16_t>(5), "", std::string(4, '\0')});
  flat.point(0, table);
  const std::size_t pixels_field = flat.size() - 4;
  const std::size_t place = flat.add_bytes(pixels, pixels.size());
  flat.point(pixels_field, place);
  return flat.packet(1);
}

/// A packet whose root has a vector of tables.
std::string tables_packet(const std::string& identifier, int stream,
                          const std::vector<std::vector<std::string>>& tables) {
  FlatBytes flat(identifier);
  const std::size_t root = flat.add_table({std::string(4, '\0')});
  flat.point(0, root);
  const std::size_t vector_field = flat.size() - 4;
  const std::size_t vector = flat.add_bytes(std::string(4 * tables.size(), '\0'), tables.size());
  flat.point(vector_field, vector);
  for (std::size_t i = 0; i < tables.size(); ++i) flat.point(vector + 4 + 4 * i, flat.add_table(tables[i]));
  return flat.packet(stream);
}

/// A file without compression of a stream of events, of frames, of readings and of triggers.
std::string aedat4_file(const std::string& packets) {
  std::string xml = "<dv version=\"2.0\"><node name=\"outInfo\" path=\"/outInfo/\">";
  const std::array<std::string, 4> types = {"EVTS", "FRME", "IMUS", "TRIG"};
  for (std::size_t i = 0; i < types.size(); ++i) {
    const std::string name = std::to_string(i);
    xml += "<node name=\"" + name + "\" path=\"\"><attr key=\"typeIdentifier\" type=\"string\">" + types[i] +
           "</attr><node name=\"info\" path=\"\"><attr key=\"sizeX\" type=\"int\">4</attr><attr "
           "key=\"sizeY\" type=\"int\">3"
           "</attr><attr key=\"source\" type=\"string\">DAVIS346_1</attr></node></node>";
  }
  xml += "</node></dv>";
  FlatBytes header("IOHE");
  const std::size_t table = header.add_table(
      {little_endian<std::int32_t>(0), little_endian<std::int64_t>(-1), std::string(4, '\0')});
  header.point(0, table);
  const std::size_t field = header.size() - 4;
  header.point(field, header.add_bytes(xml + '\0', xml.size()));
  return "#!AER-DAT4.0\r\n" + header.packet(0).substr(8) + packets;
}

TEST(OtherRecords, Aedat4HasFramesReadingsAndTriggers) {
  const TempFolder folder;
  std::vector<std::string> reading = {little_endian<std::int64_t>(2'000)};
  for (const float value : {31.5F, 1.0F, -1.0F, 0.5F, 180.0F, -90.0F, 0.0F, 1.0F, 2.0F, 3.0F})
    reading.push_back(float_bytes(value));
  const std::string content = frame_packet(16, 2, 1, "abcdef") + tables_packet("IMUS", 2, {reading, {}}) +
                              tables_packet("TRIG", 3,
                                            {{little_endian<std::int64_t>(3'000), "\x02"},
                                             {little_endian<std::int64_t>(3'001), "\x09"}});
  const auto path = folder.write("a.aedat4", aedat4_file(content));
  Kept kept;
  EXPECT_EQ(read_with(path, kept), "");
  ASSERT_EQ(kept.frames.size(), 1u);
  const Kept::Frame& frame = kept.frames[0];
  EXPECT_EQ(frame.record.t_us, 1'000);
  EXPECT_EQ(frame.record.begin_us, 950);
  EXPECT_EQ(frame.record.end_us, 1'100);
  EXPECT_EQ(frame.record.channels, 3);
  EXPECT_EQ(frame.record.bits, 8);
  EXPECT_EQ(frame.record.x, 5);
  EXPECT_EQ(frame.bytes, "abcdef");
  EXPECT_EQ(frame.source, "DAVIS346_1");
  ASSERT_EQ(kept.readings.size(), 2u);
  EXPECT_DOUBLE_EQ(kept.readings[0].acceleration_m_s2[1], -9.80665);
  EXPECT_NEAR(kept.readings[0].angular_velocity_rad_s[0], 3.14159265358979, 1e-12);
  EXPECT_FLOAT_EQ(static_cast<float>(*kept.readings[0].temperature_deg_c), 31.5F);
  EXPECT_EQ(kept.readings[1].t_us, 0) << "absent fields are 0";
  EXPECT_EQ(kept.triggers,
            (std::vector<std::string>{"3000 0 falling DAVIS346_1", "3001 0 exposure_end DAVIS346_1"}));
  kept.wants = false;
  EXPECT_EQ(read_with(path, kept),
            "1 packets of stream 1 (FRME), 1 packets of stream 2 (IMUS), 1 packets of stream 3 (TRIG)");
}

TEST(OtherRecords, ABrokenPacketOfAedat4IsAnError) {
  const TempFolder folder;
  const auto error_of = [&](const std::string& packets) -> std::string {
    Kept kept;
    try {
      read_with(folder.write("a.aedat4", aedat4_file(packets)), kept);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(error_of(frame_packet(16, 2, 1, "abcde")), HasSubstr("a frame of 5 bytes, expected 6"));
  EXPECT_THAT(error_of(frame_packet(5, 2, 1, "abcde")), HasSubstr("the format 5"));
  EXPECT_THAT(error_of(frame_packet(0, -1, 1, "")), HasSubstr("a frame of -1x1"));
  const std::string whole = tables_packet("TRIG", 3, {{little_endian<std::int64_t>(3'000), "\x02"}});
  for (std::size_t i = 12; i < whole.size(); ++i) {
    std::string broken = whole;
    broken[i] = '\x7f';
    (void)error_of(broken);  // no crash; most are errors
  }
  EXPECT_THAT(error_of(whole.substr(0, 12) + std::string(whole.size() - 12, '\x7f')),
              HasSubstr("outside the packet"));
}

// ROS messages.

std::string cdr(const std::string& members) { return std::string("\0\1\0\0", 4) + members; }
std::string with_count(const std::string& bytes) {
  return little_endian(static_cast<std::uint32_t>(bytes.size())) + bytes;
}
std::string image_message(const std::string& encoding, std::uint32_t width, std::uint32_t height,
                          std::uint32_t step, bool big, const std::string& pixels) {
  // ROS 1: sequence number, stamp 2.000003 s, frame.
  return little_endian_words<std::uint32_t>({9, 2, 3000}) + with_count("cam") + little_endian(height) +
         little_endian(width) + with_count(encoding) + (big ? '\1' : '\0') + little_endian(step) +
         with_count(pixels);
}

TEST(OtherRecords, ImagesOfRosLoseTheGapsBetweenRowsAndBecomeBgr) {
  Kept kept;
  const auto read = [&](const std::string& message) {
    return read_sensor_message(SensorMessageType::image, Serialisation::ros1, message, "/image_raw", kept);
  };
  EXPECT_FALSE(read(image_message("mono8", 2, 2, 3, false, "ab-cd-")));
  EXPECT_FALSE(read(image_message("rgb8", 1, 1, 3, false, "abc")));
  EXPECT_FALSE(read(image_message("mono16", 1, 1, 2, true, std::string("\1\2", 2))));
  ASSERT_EQ(kept.frames.size(), 3u);
  EXPECT_EQ(kept.frames[0].record.t_us, 2'000'003);
  EXPECT_EQ(kept.frames[0].bytes, "abcd");
  EXPECT_EQ(kept.frames[0].source, "/image_raw");
  EXPECT_EQ(kept.frames[1].bytes, "cba");
  EXPECT_EQ(kept.frames[2].at(0, 0), 0x102);
  EXPECT_EQ(read(image_message("yuv422", 1, 1, 2, false, "ab"))->found, "an image in the encoding yuv422");
  EXPECT_EQ(read(image_message("mono8", 2, 2, 2, false, "abc"))->expected, "bytes for all pixels");
  EXPECT_EQ(read(image_message("mono8", 2, 2, 2, false, "abcd").substr(0, 40))->expected, "a whole message");
}

TEST(OtherRecords, CompressedImagesOfRosAreKeptAsTheyAre) {
  Kept kept;
  const auto read = [&](const std::string& image) {
    const std::string message =
        cdr(little_endian_words<std::uint32_t>({2, 3000}) + with_count(std::string("cam\0", 4)) +
            with_count(std::string("jpeg\0\0\0\0", 8)) + with_count(image));
    return read_sensor_message(SensorMessageType::compressed_image, Serialisation::cdr, message, "/c", kept);
  };
  EXPECT_FALSE(read("\xff\xd8 the rest"));
  ASSERT_EQ(kept.frames.size(), 1u);
  EXPECT_EQ(kept.frames[0].bytes, "\xff\xd8 the rest");
  EXPECT_EQ(kept.frames[0].record.extension, ".jpg");
  EXPECT_EQ(read("GIF")->expected, "a PNG or JPEG file");
}

std::string imu_message() {
  std::string bytes = little_endian_words<std::uint32_t>({9, 2, 3000}) + with_count("");
  for (int i = 0; i < 28; ++i) {
    const double value = i;
    std::uint64_t bits = 0;
    std::memcpy(&bits, &value, 8);
    bytes += little_endian(bits);
  }
  return bytes;
}

TEST(OtherRecords, ReadingsOfRosAreInUnitsOfTheSi) {
  Kept kept;
  ASSERT_FALSE(read_sensor_message(SensorMessageType::imu, Serialisation::ros1, imu_message(), "/imu", kept));
  EXPECT_EQ(kept.readings.at(0).angular_velocity_rad_s, (std::array<double, 3>{13, 14, 15}));
  EXPECT_EQ(kept.readings.at(0).acceleration_m_s2, (std::array<double, 3>{25, 26, 27}));
  EXPECT_FALSE(kept.readings.at(0).temperature_deg_c);
  EXPECT_TRUE(read_sensor_message(SensorMessageType::imu, Serialisation::ros1, imu_message().substr(0, 200),
                                  "/imu", kept));
}

// A whole conversion.

TEST(OtherRecords, AConversionChangesTimesAndFramesAsItDoesEvents) {
  const TempFolder folder;
  const std::uint32_t bottom_right = 1u << 11;
  const auto path =
      folder.write("a.aedat", davis_header + record(1u << 10 | 3, 40) + record(bottom_right, 50) +
                                  davis_frame(100) + record(1u << 10 | 2, 300) + record(bottom_right, 400));
  Kept kept;
  ConversionConfig config;
  config.read.others = &kept;
  config.from_s = 0.0;
  config.until_s = 300e-6;
  config.zero_time = true;
  config.region = PixelRegion{200, 140, 40, 40};
  config.crop = true;
  config.swap_xy = true;
  config.flip_x = true;
  EXPECT_EQ(convert_recording(built_in_formats(), path, folder / "b.csv", config).events, 1);
  EXPECT_EQ(kept.triggers, (std::vector<std::string>{"250 0 falling DAVIS"}))
      << "the other one is before the first event";
  ASSERT_EQ(kept.frames.size(), 1u);
  const Kept::Frame& frame = kept.frames[0];
  EXPECT_EQ(frame.record.t_us, 50);
  EXPECT_EQ(frame.record.end_us, 51);
  EXPECT_EQ(frame.record.width, 40);
  // Column x of the written frame is row 39 - x of the region.
  EXPECT_EQ(frame.at(0, 0), (200 + 2 * (140 + 39)) << 6);
  EXPECT_EQ(frame.at(39, 5), (205 + 2 * 140) << 6);
}

TEST(OtherRecords, FramesOfAnotherSizeThanTheEventsAreNotTurned) {
  const TempFolder folder;
  const auto path = folder.write("a.aedat4", aedat4_file(frame_packet(0, 2, 1, "ab")));
  Kept kept;
  ConversionConfig config;
  config.read.others = &kept;
  config.flip_x = true;
  EXPECT_THAT(
      [&] { convert_recording(built_in_formats(), path, folder / "b.csv", config); },
      testing::ThrowsMessage<InputError>(HasSubstr("frames of 2x1, expected frames of the events' 4x3")));
  EXPECT_FALSE(std::filesystem::exists(folder / "b.csv"));
}

class OtherRecordsOfRealRecordings : public RealRecording {};

// Times and values as an independent reader of the file's tables has them (Python, struct and lz4).
TEST_F(OtherRecordsOfRealRecordings, AreRead) {
  Kept kept;
  read_with(path_of("head_dvxplorer320x240_lz4.aedat4"), kept);
  ASSERT_EQ(kept.readings.size(), 475u);
  EXPECT_EQ(kept.readings[0].t_us, 1605537493718788);
  Kept triggers;
  read_with(path_of("ros2_evt3_trigger.db3"), triggers);
  EXPECT_EQ(triggers.triggers.size(), 2u);
}

}  // namespace
}  // namespace saccade
