#include "external/robot_frames.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "recording/byte_order.h"

namespace saccade {
namespace {

constexpr std::size_t block_bytes = 64 * 1024;
constexpr std::size_t event_bytes = 16;
constexpr std::size_t joint_bytes = 24;
constexpr std::size_t hello_joint_bytes = joint_name_bytes + 24;
constexpr std::size_t hello_bytes = 44;
constexpr std::string_view mark = "saccade";  // and a 0

template <class T>
void put(T value, std::vector<std::byte>& out) {
  std::string bytes;
  append_little(bytes, value);
  const auto* const begin = reinterpret_cast<const std::byte*>(bytes.data());
  out.insert(out.end(), begin, begin + bytes.size());
}

void put_double(double value, std::vector<std::byte>& out) {
  std::uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  put(bits, out);
}

/// Writes the head of a frame, whose payload follows.
void put_head(RobotFrame type, std::size_t bytes, std::vector<std::byte>& out) {
  put(static_cast<std::uint32_t>(type), out);
  put(static_cast<std::uint32_t>(bytes), out);
}

/// Reads values one after the other; sizes are checked before.
class Cursor {
 public:
  explicit Cursor(std::span<const std::byte> bytes) : at_(reinterpret_cast<const char*>(bytes.data())) {}
  template <class T>
  T take() {
    const T value = load_little<T>(at_);
    at_ += sizeof(T);
    return value;
  }
  double take_double() {
    const auto bits = take<std::uint64_t>();
    double value = 0.0;
    std::memcpy(&value, &bits, sizeof value);
    return value;
  }
  std::string_view take_text(std::size_t bytes) {
    const std::string_view text(at_, bytes);
    at_ += bytes;
    return text;
  }

 private:
  const char* at_;
};

std::string wrong(std::string_view what, const std::string& found, const std::string& expected) {
  return std::string(what) + ": found " + found + ", expected " + expected;
}

std::string wrong_size(std::string_view what, std::size_t found, std::size_t expected) {
  return wrong(what, std::to_string(found) + " bytes", std::to_string(expected));
}

bool is_joint_name(std::string_view name) {
  return !name.empty() && std::ranges::all_of(name, [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
  });
}

}  // namespace

std::span<std::byte> FrameReader::room() {
  bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(begin_));
  end_ -= begin_;
  begin_ = 0;
  bytes_.resize(end_ + block_bytes);
  return std::span(bytes_).subspan(end_);
}

std::optional<FrameView> FrameReader::next() {
  if (!problem_.empty() || end_ - begin_ < frame_head_bytes) return std::nullopt;
  Cursor head(std::span<const std::byte>(bytes_).subspan(begin_, frame_head_bytes));
  const auto type = head.take<std::uint32_t>();
  const std::size_t bytes = head.take<std::uint32_t>();
  if (bytes > most_payload_bytes) {
    problem_ = wrong("frame of type " + std::to_string(type), std::to_string(bytes) + " bytes",
                     "at most " + std::to_string(most_payload_bytes));
    return std::nullopt;
  }
  if (end_ - begin_ < frame_head_bytes + bytes) return std::nullopt;
  const FrameView view{static_cast<RobotFrame>(type),
                       std::span(bytes_).subspan(begin_ + frame_head_bytes, bytes)};
  begin_ += frame_head_bytes + bytes;
  return view;
}

void write_hello(const RobotHello& hello, std::vector<std::byte>& out) {
  put_head(RobotFrame::hello, hello_bytes + hello_joint_bytes * hello.joints.size(), out);
  for (const char c : mark) out.push_back(static_cast<std::byte>(c));
  out.push_back(std::byte{0});
  put(robot_protocol, out);
  put(static_cast<std::uint32_t>(hello.image_size.width), out);
  put(static_cast<std::uint32_t>(hello.image_size.height), out);
  put(static_cast<std::uint32_t>(hello.watchdog_ms), out);
  put(hello.now_us, out);
  put(static_cast<std::uint32_t>(hello.has_imu ? 1 : 0), out);
  put(static_cast<std::uint32_t>(hello.torso_joints), out);
  put(static_cast<std::uint32_t>(hello.joints.size()), out);
  for (const RobotHello::Joint& joint : hello.joints) {
    std::string name = joint.name;
    name.resize(joint_name_bytes, '\0');
    for (const char c : name) out.push_back(static_cast<std::byte>(c));
    put_double(joint.min_rad, out);
    put_double(joint.max_rad, out);
    put_double(joint.max_speed_rad_s, out);
  }
}

std::string read_hello(std::span<const std::byte> payload, RobotHello& hello) {
  if (payload.size() < 12) return wrong_size("hello", payload.size(), hello_bytes);
  Cursor at(payload);
  if (at.take_text(8) != std::string_view("saccade\0", 8))
    return wrong("hello", "other bytes", "\"saccade\" and a zero");
  if (const auto version = at.take<std::uint32_t>(); version != robot_protocol)
    return wrong("hello: version of the protocol", std::to_string(version), std::to_string(robot_protocol));
  if (payload.size() < hello_bytes) return wrong_size("hello", payload.size(), hello_bytes);
  const auto width = at.take<std::uint32_t>();
  const auto height = at.take<std::uint32_t>();
  const auto watchdog = at.take<std::uint32_t>();
  hello.now_us = at.take<std::int64_t>();
  hello.has_imu = (at.take<std::uint32_t>() & 1) != 0;
  const auto torso = at.take<std::uint32_t>();
  const auto count = at.take<std::uint32_t>();
  if (width < 1 || width > 4096 || height < 1 || height > 4096)
    return wrong("hello: image", std::to_string(width) + " x " + std::to_string(height), "1 to 4096");
  if (watchdog < least_watchdog_ms || watchdog > most_watchdog_ms) {
    return wrong("hello: watchdog_ms", std::to_string(watchdog),
                 std::to_string(least_watchdog_ms) + " to " + std::to_string(most_watchdog_ms));
  }
  if (torso > torso_slots) return wrong("hello: joints of the torso", std::to_string(torso), "at most 3");
  if (count < torso || count - torso > gaze_slots)
    return wrong("hello: joints", std::to_string(count), "those of the torso and at most 12 more");
  if (payload.size() != hello_bytes + hello_joint_bytes * count)
    return wrong_size("hello", payload.size(), hello_bytes + hello_joint_bytes * count);
  hello.image_size = {static_cast<int>(width), static_cast<int>(height)};
  hello.watchdog_ms = watchdog;
  hello.torso_joints = static_cast<int>(torso);
  hello.joints.clear();
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::string_view field = at.take_text(joint_name_bytes);
    RobotHello::Joint joint{std::string(field.substr(0, field.find('\0'))), at.take_double(),
                            at.take_double(), at.take_double()};
    const std::string place = "hello: joint " + std::to_string(i);
    if (!is_joint_name(joint.name)) return wrong(place, "a name", "letters, digits and _");
    if (!std::isfinite(joint.min_rad) || !std::isfinite(joint.max_rad) || !(joint.min_rad < joint.max_rad) ||
        std::abs(joint.min_rad) > 100.0 || std::abs(joint.max_rad) > 100.0)
      return wrong(place + ", " + joint.name, "limits", "min < max, finite, rad");
    if (!(joint.max_speed_rad_s > 0.0) || !std::isfinite(joint.max_speed_rad_s))
      return wrong(place + ", " + joint.name, "a largest speed", "more than 0, finite, rad/s");
    hello.joints.push_back(std::move(joint));
  }
  return {};
}

void write_events(std::int64_t until_us, std::span<const Event> events, std::vector<std::byte>& out) {
  put_head(RobotFrame::events, 8 + event_bytes * events.size(), out);
  put(until_us, out);
  for (const Event& event : events) {
    put(event.t_us, out);
    put(event.x, out);
    put(event.y, out);
    out.push_back(static_cast<std::byte>(event.on ? 1 : 0));
    out.push_back(static_cast<std::byte>(event.camera));
    put(std::uint16_t{0}, out);
  }
}

std::string read_events(std::span<const std::byte> payload, std::int64_t& until_us,
                        std::vector<Event>& events) {
  events.clear();
  if (payload.size() < 8 || (payload.size() - 8) % event_bytes != 0)
    return wrong("events", std::to_string(payload.size()) + " bytes", "8 and 16 for each event");
  Cursor at(payload);
  until_us = at.take<std::int64_t>();
  for (std::size_t i = 0; i < (payload.size() - 8) / event_bytes; ++i) {
    Event event;
    event.t_us = at.take<std::int64_t>();
    event.x = at.take<std::uint16_t>();
    event.y = at.take<std::uint16_t>();
    event.on = at.take<std::uint8_t>() != 0;
    event.camera = at.take<std::uint8_t>();
    (void)at.take<std::uint16_t>();
    if (event.camera > 1) {
      events.clear();
      return wrong("events: camera", std::to_string(event.camera), "0 or 1");
    }
    events.push_back(event);
  }
  return {};
}

void write_joints(const JointsFrame& joints, std::vector<std::byte>& out) {
  put_head(RobotFrame::joints, 16 + joint_bytes * static_cast<std::size_t>(joints.count), out);
  put(joints.t_us, out);
  put(joints.activation, out);
  for (std::size_t i = 0; i < static_cast<std::size_t>(joints.count); ++i) {
    put_double(joints.position_rad[i], out);
    put_double(joints.velocity_rad_s[i], out);
    put(static_cast<std::uint64_t>(joints.drive[i]), out);
  }
}

std::string read_joints(std::span<const std::byte> payload, int count, JointsFrame& joints) {
  const std::size_t bytes = 16 + joint_bytes * static_cast<std::size_t>(count);
  if (payload.size() != bytes) return wrong_size("joints", payload.size(), bytes);
  Cursor at(payload);
  joints = {};
  joints.t_us = at.take<std::int64_t>();
  joints.activation = at.take<std::uint64_t>();
  joints.count = count;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    joints.position_rad[i] = at.take_double();
    joints.velocity_rad_s[i] = at.take_double();
    const auto drive = at.take<std::uint64_t>();
    if (drive > static_cast<std::uint64_t>(JointDrive::fault))
      return wrong("joints: drive", std::to_string(drive), "0 to 4");
    joints.drive[i] = static_cast<JointDrive>(drive);
  }
  return {};
}

void write_imu(const ImuReading& reading, std::vector<std::byte>& out) {
  put_head(RobotFrame::imu, 56, out);
  put(reading.t_us, out);
  for (int i = 0; i < 3; ++i) put_double(reading.angular_velocity_rad_s[i], out);
  for (int i = 0; i < 3; ++i) put_double(reading.acceleration_m_s2[i], out);
}

std::string read_imu(std::span<const std::byte> payload, ImuReading& reading) {
  if (payload.size() != 56) return wrong_size("imu", payload.size(), 56);
  Cursor at(payload);
  reading.t_us = at.take<std::int64_t>();
  for (int i = 0; i < 3; ++i) reading.angular_velocity_rad_s[i] = at.take_double();
  for (int i = 0; i < 3; ++i) reading.acceleration_m_s2[i] = at.take_double();
  return {};
}

void write_text(std::string_view text, std::vector<std::byte>& out) {
  text = text.substr(0, most_text_bytes);
  put_head(RobotFrame::text, text.size(), out);
  for (const char c : text) out.push_back(static_cast<std::byte>(c));
}

std::string read_text(std::span<const std::byte> payload, std::string& text) {
  if (payload.size() > most_text_bytes)
    return wrong("text", std::to_string(payload.size()) + " bytes",
                 "at most " + std::to_string(most_text_bytes));
  text.clear();
  for (const std::byte byte : payload) {
    const auto c = static_cast<unsigned char>(byte);
    text += c >= 0x20 && c != 0x7f ? static_cast<char>(c) : '?';
  }
  return {};
}

void write_client(RobotClient client, std::vector<std::byte>& out) {
  put_head(RobotFrame::client, 8, out);
  put(robot_protocol, out);
  put(static_cast<std::uint32_t>(client), out);
}

std::string read_client(std::span<const std::byte> payload, RobotClient& client) {
  if (payload.size() != 8) return wrong_size("client", payload.size(), 8);
  Cursor at(payload);
  if (const auto version = at.take<std::uint32_t>(); version != robot_protocol)
    return wrong("client: version of the protocol", std::to_string(version), std::to_string(robot_protocol));
  const auto kind = at.take<std::uint32_t>();
  if (kind != 1 && kind != 2) return wrong("client: kind", std::to_string(kind), "1 or 2");
  client = static_cast<RobotClient>(kind);
  return {};
}

void write_reference(std::uint64_t activation, std::span<const double> reference_rad,
                     std::vector<std::byte>& out) {
  put_head(RobotFrame::reference, 8 + 8 * reference_rad.size(), out);
  put(activation, out);
  for (const double value : reference_rad) put_double(value, out);
}

std::string read_reference(std::span<const std::byte> payload, int count, std::uint64_t& activation,
                           std::array<double, gaze_slots>& reference_rad) {
  const std::size_t bytes = 8 + 8 * static_cast<std::size_t>(count);
  if (payload.size() != bytes) return wrong_size("reference", payload.size(), bytes);
  Cursor at(payload);
  activation = at.take<std::uint64_t>();
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) reference_rad.at(i) = at.take_double();
  return {};
}

void write_number(RobotFrame type, std::uint64_t activation, std::vector<std::byte>& out) {
  put_head(type, 8, out);
  put(activation, out);
}

std::string read_number(std::span<const std::byte> payload, std::uint64_t& activation) {
  if (payload.size() != 8) return wrong_size("frame with a number", payload.size(), 8);
  activation = Cursor(payload).take<std::uint64_t>();
  return {};
}

void write_end(std::vector<std::byte>& out) { put_head(RobotFrame::end, 0, out); }

}  // namespace saccade
