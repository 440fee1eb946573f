#include "recording/sensor_message.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <vector>

#include "recording/codec.h"

namespace saccade {
namespace {

constexpr int most_length_px = 1 << 16;

struct Encoding {
  int channels = 1;
  int bits = 8;
  bool red_first = false;
};

std::optional<Encoding> encoding_of(std::string_view name) {
  if (name == "mono8" || name == "8UC1" || (name.starts_with("bayer_") && name.ends_with("8")))
    return Encoding{};
  if (name == "mono16" || name == "16UC1" || (name.starts_with("bayer_") && name.ends_with("16")))
    return Encoding{1, 16, false};
  if (name == "bgr8" || name == "rgb8") return Encoding{3, 8, name == "rgb8"};
  if (name == "bgra8" || name == "rgba8") return Encoding{4, 8, name == "rgba8"};
  return std::nullopt;
}

const BrokenMessage cut{"a message that ends early", "a whole message"};

std::optional<BrokenMessage> read_image(MessageCursor& cursor, RecordedFrame frame, OtherRecords& others) {
  std::uint32_t height = 0, width = 0, step = 0;
  std::string_view name, data;
  std::uint8_t big_endian = 0;
  if (!cursor.take(height) || !cursor.take(width) || !cursor.take_text(name) || !cursor.take(big_endian) ||
      !cursor.take(step) || !cursor.take_bytes(data))
    return cut;
  const std::optional<Encoding> encoding = encoding_of(name);
  if (!encoding)
    return BrokenMessage{"an image in the encoding " + printable(name),
                         "mono8, mono16, 8UC1, 16UC1, rgb8, bgr8, rgba8, bgra8 or bayer_*"};
  const std::size_t row_bytes =
      std::size_t{width} * static_cast<std::size_t>(encoding->channels * encoding->bits / 8);
  if (width < 1 || height < 1 || width > most_length_px || height > most_length_px || step < row_bytes ||
      data.size() / step < height)
    return BrokenMessage{"an image of " + std::to_string(width) + "x" + std::to_string(height) + ", " +
                             std::to_string(step) + " bytes a row and " + std::to_string(data.size()) +
                             " in all",
                         "bytes for all pixels"};
  std::vector<char> pixels(row_bytes * height);
  for (std::size_t row = 0; row < height; ++row)
    std::memcpy(pixels.data() + row * row_bytes, data.data() + row * step, row_bytes);
  if (encoding->red_first) {
    const auto pixel = static_cast<std::size_t>(encoding->channels);
    for (std::size_t i = 0; i < pixels.size(); i += pixel) std::swap(pixels[i], pixels[i + 2]);
  }
  const bool other_order = (big_endian != 0) != (std::endian::native == std::endian::big);
  if (encoding->bits == 16 && other_order)
    for (std::size_t i = 0; i < pixels.size(); i += 2) std::swap(pixels[i], pixels[i + 1]);
  frame.width = static_cast<int>(width);
  frame.height = static_cast<int>(height);
  frame.channels = encoding->channels;
  frame.bits = encoding->bits;
  frame.pixels = std::as_bytes(std::span<const char>(pixels));
  others.add(frame);
  return std::nullopt;
}

std::optional<BrokenMessage> read_compressed_image(MessageCursor& cursor, RecordedFrame frame,
                                                   OtherRecords& others) {
  std::string_view format;
  if (!cursor.take_text(format) || !cursor.take_bytes(frame.encoded)) return cut;
  if (frame.encoded.starts_with("\x89PNG")) {
    frame.extension = ".png";
  } else if (frame.encoded.starts_with("\xff\xd8")) {
    frame.extension = ".jpg";
  } else {
    return BrokenMessage{"a compressed image in the format " + printable(format), "a PNG or JPEG file"};
  }
  others.add(frame);
  return std::nullopt;
}

std::optional<BrokenMessage> read_imu(MessageCursor& cursor, std::int64_t t_us, std::string_view topic,
                                      OtherRecords& others) {
  // Orientation, then the two vectors, each followed by its covariance.
  std::array<double, 4 + 9 + 3 + 9 + 3> numbers{};
  for (double& number : numbers)
    if (!cursor.take(number)) return cut;
  InertialReading reading;
  reading.t_us = t_us;
  std::copy_n(numbers.begin() + 13, 3, reading.angular_velocity_rad_s.begin());
  std::copy_n(numbers.begin() + 25, 3, reading.acceleration_m_s2.begin());
  reading.source = topic;
  others.add(reading);
  return std::nullopt;
}

}  // namespace

std::optional<SensorMessageType> wanted_sensor_message(const OtherRecords* others, std::string_view name) {
  if (others == nullptr) return std::nullopt;
  std::string plain(name);
  if (const std::size_t msg = plain.find("/msg/"); msg != std::string::npos) plain.erase(msg, 4);
  if (plain == "sensor_msgs/Image" && others->wants_frames()) return SensorMessageType::image;
  if (plain == "sensor_msgs/CompressedImage" && others->wants_frames())
    return SensorMessageType::compressed_image;
  if (plain == "sensor_msgs/Imu" && others->wants_inertial()) return SensorMessageType::imu;
  return std::nullopt;
}

std::optional<BrokenMessage> read_sensor_message(SensorMessageType type, Serialisation serialisation,
                                                 std::string_view message, std::string_view topic,
                                                 OtherRecords& others) {
  if (auto broken = broken_serialisation(message, serialisation)) return broken;
  MessageCursor cursor(message, serialisation);
  RecordedFrame frame;
  if (!cursor.take_header(frame.t_us)) return cut;
  frame.source = topic;
  switch (type) {
    case SensorMessageType::image:
      return read_image(cursor, frame, others);
    case SensorMessageType::compressed_image:
      return read_compressed_image(cursor, frame, others);
    case SensorMessageType::imu:
      break;
  }
  return read_imu(cursor, frame.t_us, topic, others);
}

}  // namespace saccade
